// A dataset of labelled ultrasound images: what varies is described by options or a file, and MPI spreads the samples over
// processes. See README.md.
#define INSONIFY_IMPLEMENTATION
#include "drawing.hpp"
#include "folder.hpp"
#include "ranks.hpp"
#include "summary.hpp"
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <unistd.h>

using namespace dataset;

namespace {

using seconds = std::chrono::duration<double>;

double now() { return seconds(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Threads of this process: all cores where it is alone, else one, as there is a process for each core.
std::uint32_t threads_of(const ranks& shared) {
    return shared.count() > 1 ? 1 : std::max(std::thread::hardware_concurrency(), 1U);
}

/// Bytes of a sample on the disk.
double size_of_sample(const description& d, const anatomies& all, const parts& files,
                      const std::vector<record>& trial) {
    if (!files.is_png()) return static_cast<double>(files.size_of(trial)) / static_cast<double>(trial.size());
    const std::filesystem::path draft =
        std::filesystem::temp_directory_path() / ("insonify-plan-" + std::to_string(getpid()));
    write_files(draft, files.arrays(), all, trial, d.size);
    double bytes = 0;
    for (const auto& entry : std::filesystem::directory_iterator{draft})
        bytes += static_cast<double>(entry.file_size());
    std::filesystem::remove_all(draft);
    return bytes / static_cast<double>(trial.size());
}

void print_plan(const description& d, const anatomies& all, const parts& files, const ranks& shared) {
    const double begin = now();
    std::vector<record> trial;
    renderer draw{d, all};
    for (std::uint32_t i = 0; i < std::min(d.samples, std::max(all.cycle(), 4U)); ++i) {
        trial.push_back(draw(i));
        record packed = trial.back();
        files.pack(packed);
    }
    const double each = (now() - begin) / static_cast<double>(trial.size()),
                 bytes = size_of_sample(d, all, files, trial);
    const double cores = static_cast<double>(threads_of(shared)) * shared.count();
    std::printf("%u samples of %u x %u pixels in %u parts in '%s'\n%.0f ms a sample on one core: about %.0f s on %.0f\n"
                "about %.1f MB on disk\nlabels:",
                d.samples, d.size, d.size, files.count(), d.output.c_str(), 1e3 * each, each * d.samples / cores, cores,
                bytes * d.samples / 1e6);
    for (std::size_t i = 0; i < all.labels().names.size(); ++i)
        std::printf(" %zu %s", i, all.labels().names[i].c_str());
    const std::uint32_t drawn = std::min(d.samples, 1000U);
    std::printf("\nwhat varies, in the first %u samples:\n", drawn);
    for (std::size_t number = 0; number < files.arrays().option_count(); ++number) {
        const fact& one = files.arrays().facts()[number];
        std::vector<float> values;
        for (std::uint32_t i = 0; i < drawn; ++i) {
            const spot at = all.place_of(i);
            one.append({.numbers = draw_sample(d, at, all.usual_view(at))}, values);
        }
        const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
        if (*smallest < *largest)
            std::printf("  %s: %g to %g %s\n", one.short_name().c_str(), static_cast<double>(*smallest),
                        static_cast<double>(*largest), one.name.unit.c_str());
    }
}

/// Prints what is wrong with the parts.
/// @return whether all are there, and whole
bool verify(const description& d, const parts& files) {
    std::uint32_t faults = 0;
    for (std::uint32_t part = 0; part < files.count(); ++part) {
        const std::string fault = files.exists(part) ? files.fault(part) : "is missing";
        if (fault.empty()) continue;
        ++faults;
        std::printf("%s: %s\n", files.name(part).c_str(), fault.c_str());
    }
    std::printf("%u of %u parts in '%s' are whole", files.count() - faults, files.count(), d.output.c_str());
    std::printf(faults == 0 ? "\n" : "; the same command without --verify draws the others\n");
    return faults == 0;
}

void draw(const description& d, const anatomies& all, const parts& files, ranks& shared) {
    const double begin = now();
    std::uint32_t drawn = 0;
    drawing{d, all, files, shared.rank()}.run(
        threads_of(shared), [&] { return shared.next(); },
        [&](std::uint32_t part, std::uint32_t samples) {
            drawn += samples;
            if (shared.rank() != 0 || samples == 0) return;
            const double passed = now() - begin, fraction = static_cast<double>(part + 1) / files.count();
            std::fprintf(stderr, "\r%3.0f %%, %.1f samples/s, %.0f s left   ", 100 * fraction,
                         static_cast<double>(drawn) * shared.count() / passed, passed * (1 - fraction) / fraction);
        });
    shared.first_to_fail(false);
    if (shared.rank() != 0) return;
    if (!files.is_png()) files.write_whole();
    write_summary(d, all, files);
    std::fprintf(stderr, "\r%u samples in '%s', %.0f s; summary.html shows them\n", d.samples, d.output.c_str(),
                 now() - begin);
}

/// Calls a step of the preparation, which may fail on every rank; one of them tells.
/// @return whether it succeeded on all
template <class Step>
bool prepared(const ranks& shared, const Step& step) {
    std::string failure;
    try {
        step();
    } catch (const std::exception& error) {
        failure = error.what();
    }
    const int failed = shared.first_to_fail(!failure.empty());
    if (failed == shared.rank()) std::fprintf(stderr, "dataset: %s\n", failure.c_str());
    return failed == shared.count();
}

int run(const description& d, const std::vector<described_option>& options, ranks& shared) {
    std::optional<anatomies> all;
    std::optional<parts> files;
    identity_lines identity;
    const bool ready = prepared(shared, [&] {
        d.check();
        all.emplace(d);
        identity = identity_of(d, options);
        if (!d.plan || d.verify) check_folder(d, identity);
        files.emplace(d, *all, text_of(identity));
    });
    if (!ready) return 1;
    if (shared.rank() == 0)
        for (std::size_t i = 0; i < all->size(); ++i)
            if (const std::string note = (*all)[i].note(); !note.empty()) std::fprintf(stderr, "%s\n", note.c_str());
    if (d.plan || d.verify) {
        if (shared.rank() != 0) return 0;
        if (d.plan) print_plan(d, *all, *files, shared);
        return d.verify && !verify(d, *files) ? 1 : 0;
    }
    const bool has_folder = prepared(shared, [&] {
        if (shared.rank() != 0) return;
        prepare_folder(d, identity, options);
        files->remove_drafts();
    });
    if (!has_folder) return 1;
    draw(d, *all, *files, shared);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    std::signal(SIGXFSZ, SIG_IGN); // a file that may not grow any more is an error, as on a full disk
    ranks shared{argc, argv};
    CLI::App app{"Labelled ultrasound images of meshes, with ground truth."};
    description d;
    try {
        const std::vector<described_option> options = add_options(app, d);
        app.parse(argc, argv);
        return run(d, options, shared);
    } catch (const CLI::ParseError& error) {
        return shared.rank() == 0 ? app.exit(error) : error.get_exit_code();
    } catch (const usage_error& error) { // of the file of --config, the same on all ranks
        if (shared.rank() == 0) std::fprintf(stderr, "dataset: %s\n", error.what());
        return 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "\ndataset: %s\n", error.what());
        if (shared.count() > 1) shared.stop(); // the others may be waiting
        return 1;
    }
}
