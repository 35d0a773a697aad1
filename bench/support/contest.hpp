#ifndef INSONIFY_BENCH_SUPPORT_CONTEST_HPP
#define INSONIFY_BENCH_SUPPORT_CONTEST_HPP

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

/// Contenders measured against each other in one process, by turns, so that what disturbs the machine disturbs all.
namespace bench {

/// One way to do the work.
struct contender {
    std::string name{};
    std::function<void()> work{};
    std::function<void()> prepare{[] {}}; ///< before each time, unmeasured
    std::vector<double> seconds{};        ///< of each turn

    double median() const {
        std::vector<double> sorted = seconds;
        std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
        return sorted[sorted.size() / 2];
    }
};

struct contest_settings {
    double seconds = 2; ///< for all contenders together
    std::size_t min_rounds = 7;
    std::size_t max_rounds = 200;
};

inline double seconds_of(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Runs all by turns until the time is spent. In its turn each works twice at least, and for 5 ms; all but the first time
/// count, and the turn's figure is their mean: as where one frame follows another, without the cold caches that another
/// contender leaves.
inline void run(std::vector<contender>& contenders, const contest_settings& settings = {}) {
    constexpr double turn = 5e-3;
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t round = 0; round < settings.max_rounds; ++round) {
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
        if (round >= settings.min_rounds && spent.count() > settings.seconds) break;
        for (std::size_t i = 0; i < contenders.size(); ++i) { // another begins each round
            contender& one = contenders[(i + round) % contenders.size()];
            one.prepare();
            one.work();
            double seconds = 0;
            std::size_t times = 0;
            for (; times == 0 || seconds < turn; ++times) {
                one.prepare();
                seconds += seconds_of(one.work);
            }
            one.seconds.push_back(seconds / static_cast<double>(times));
        }
    }
}

/// The fastest of several by median.
inline const contender& fastest(const std::vector<contender>& contenders) {
    return *std::min_element(contenders.begin(), contenders.end(),
                             [](const contender& a, const contender& b) { return a.median() < b.median(); });
}

} // namespace bench
#endif
