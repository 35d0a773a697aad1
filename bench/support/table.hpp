#ifndef INSONIFY_BENCH_SUPPORT_TABLE_HPP
#define INSONIFY_BENCH_SUPPORT_TABLE_HPP

#include "contest.hpp"
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

namespace bench {

/// A line of the table of ratios: a work, how fast we do it, how fast the best peer does.
struct row {
    std::string work{}; ///< "closest, fan"
    std::string data{}; ///< "organ 82k, 1 thread"
    std::string unit{}; ///< of the two figures: "million rays/s" or "ms"
    double ours = 0;
    double peers = 0;
    std::string peer{};   ///< whose figure that is
    double ratio = 0;     ///< above 1: we are faster
    double must = 0;      ///< the ratio aimed at; 0: none
    double different = 0; ///< share of results that differ beyond rounding, compared before time is
};

/// Collects the rows, prints each as it comes, and writes all as JSON.
class table {
  public:
    table(std::string only, std::vector<std::string> files) : only_{std::move(only)}, files_{std::move(files)} {}

    /// Meshes that are measured beside those of the table.
    const std::vector<std::string>& files() const { return files_; }

    /// Whether rows of this work were asked for.
    bool wants(const std::string& work) const { return work.find(only_) != std::string::npos; }

    void add(const row& r) {
        if (rows_.empty())
            std::puts("| work | data | ours | best peer | | unit | ratio | must | differ "
                      "|\n|---|---|---|---|---|---|---|---|---|");
        std::printf("| %s | %s | %.3g | %.3g | %s | %s | **%.2f** | %s | %.1e |\n", r.work.c_str(), r.data.c_str(),
                    r.ours, r.peers, r.peer.c_str(), r.unit.c_str(), r.ratio, r.must > 0 ? text(r.must).c_str() : "",
                    r.different);
        std::fflush(stdout);
        rows_.push_back(r);
    }

    /// Measures ours (the first contender) against peers (the others) and adds the row. Figures are milliseconds, or,
    /// where `items` is given, millions of items a second.
    void measure(row r, std::vector<contender> contenders, double items = 0, const contest_settings& settings = {}) {
        run(contenders, settings);
        const contender ours = contenders.front();
        contenders.erase(contenders.begin());
        const contender& best = fastest(contenders);
        const auto figure = [&](double seconds) { return items > 0 ? items / seconds * 1e-6 : seconds * 1e3; };
        r.ours = figure(ours.median());
        r.peers = figure(best.median());
        r.peer = best.name;
        r.ratio = best.median() / ours.median();
        add(r);
    }

    void write_json(const std::string& path) const {
        std::ofstream file{path};
        file << "{\"machine\": \"" << machine() << "\", \"date\": \"" << date() << "\", \"commit\": \"" << commit()
             << "\", \"compiler\": \"" << compiler() << "\",\n \"rows\": [";
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const row& r = rows_[i];
            file << (i == 0 ? "\n" : ",\n") << "  {\"work\": \"" << r.work << "\", \"data\": \"" << r.data
                 << "\", \"unit\": \"" << r.unit << "\", \"ours\": " << r.ours << ", \"peer\": \"" << r.peer
                 << "\", \"peers\": " << r.peers << ", \"ratio\": " << r.ratio << ", \"must\": " << r.must
                 << ", \"different\": " << r.different << "}";
        }
        file << "\n ]}\n";
    }

    /// What the figures hold for: machine, compiler, date and commit.
    static std::string circumstances() {
        return machine() + ", " + compiler() + ", " + date() + ", commit " + commit();
    }

  private:
    static std::string text(double value) {
        char buffer[32];
        std::snprintf(buffer, sizeof buffer, "%g", value);
        return buffer;
    }

    static std::string machine() {
        std::ifstream info{"/proc/cpuinfo"};
        for (std::string line; std::getline(info, line);)
            if (line.rfind("model name", 0) == 0)
                return std::to_string(std::thread::hardware_concurrency()) + " x " + line.substr(line.find(':') + 2);
        return std::to_string(std::thread::hardware_concurrency()) + " processors";
    }

    static std::string compiler() {
#if defined(__clang__)
        return "clang " __clang_version__;
#else
        return "g++ " __VERSION__;
#endif
    }

    static std::string date() {
        const std::time_t now = std::time(nullptr);
        char buffer[32];
        std::strftime(buffer, sizeof buffer, "%Y-%m-%d", std::gmtime(&now));
        return buffer;
    }

    static std::string commit() {
#if defined(INSONIFY_BENCH_COMMIT)
        return INSONIFY_BENCH_COMMIT;
#else
        return "unknown";
#endif
    }

    std::string only_;
    std::vector<std::string> files_;
    std::vector<row> rows_{};
};

} // namespace bench
#endif
