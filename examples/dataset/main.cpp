// A dataset of labelled ultrasound images: what varies is described by options or a file, and MPI spreads the samples over
// processes. See README.md.
#define INSONIFY_IMPLEMENTATION
#include "drawing.hpp"
#include "ranks.hpp"
#include "summary.hpp"
#include <chrono>
#include <fstream>
#include <iostream>
#include <sstream>

using namespace dataset;

namespace {

using seconds = std::chrono::duration<double>;

double now() { return seconds(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Samples of the longest line of echoes.
std::uint32_t longest_line(const description& d) {
    std::uint32_t most = 0;
    for (const float frequency : {d.frequency.from, d.frequency.to}) {
        const linear_array probe = presets::in_use(linear_array{.frequency = frequency * 1_MHz});
        most = std::max(most, samples_for(d.depth.to * 1_mm, nominal_pulse(probe).sigma_z(probe.frequency)));
    }
    return most;
}

/// Creates the folder, or checks that it holds a part of this dataset.
void prepare_folder(const description& d, const std::string& described) {
    const std::filesystem::path folder{d.output}, file = folder / "description.ini";
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed) throw insonify::io_error{"--output: cannot create '" + d.output + "': " + failed.message()};
    if (std::ifstream old{file}) {
        std::stringstream text;
        text << old.rdbuf();
        if (text.str() != described)
            throw insonify::usage_error{"--output: '" + d.output + "' holds samples of another description (" +
                                        file.string() + "); choose another folder, or delete it"};
    } else {
        std::ofstream created{file};
        created << described;
        if (!created.flush())
            throw insonify::io_error{"--output: cannot write to '" + d.output +
                                     "'; is the disk full, or the folder read-only?"};
    }
    std::vector<std::filesystem::path> drafts; // of ranks that were killed
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        if (entry.path().string().find(".draft") != std::string::npos) drafts.push_back(entry.path());
    for (const auto& draft : drafts) std::filesystem::remove_all(draft);
}

/// Threads of this process: all cores where it is alone, else one, as there is a process for each core.
std::uint32_t threads_of(const ranks& shared) {
    return shared.count() > 1 ? 1 : std::max(std::thread::hardware_concurrency(), 1U);
}

void print_plan(const description& d, const anatomies& all, const ranks& shared) {
    const double begin = now();
    const std::uint32_t trial = std::min(d.samples, 4U);
    std::vector<record> records;
    for (std::uint32_t i = 0; i < trial; ++i) {
        records.push_back(render(d, all, draw_sample(d, i)));
        pack(records.back(), d, longest_line(d));
    }
    const double each = (now() - begin) / trial;
    const std::filesystem::path draft = std::filesystem::temp_directory_path() / "insonify-plan.h5";
    write_hdf5(draft.string(), d, all, records, longest_line(d));
    const double bytes = static_cast<double>(std::filesystem::file_size(draft)) / trial * d.samples;
    std::filesystem::remove(draft);
    const double cores = static_cast<double>(threads_of(shared)) * shared.count();
    std::printf("%u samples of %u x %u pixels in %u parts in '%s'\n%.0f ms a sample on one core: about %.0f s on %.0f\n"
                "about %.1f MB on disk\nlabels:",
                d.samples, d.size, d.size, part_count(d), d.output.c_str(), 1e3 * each, each * d.samples / cores, cores,
                bytes / 1e6);
    for (std::size_t i = 0; i < all.labels().names.size(); ++i)
        std::printf(" %zu %s", i, all.labels().names[i].c_str());
    std::printf("\nwhat varies, in the first %u samples:\n", std::min(d.samples, 1000U));
    for (const named_number& one : numbers()) {
        float least = one.of(draw_sample(d, 0)), most = least;
        for (std::uint32_t i = 1; i < std::min(d.samples, 1000U); ++i) {
            const float value = one.of(draw_sample(d, i));
            least = std::min(least, value);
            most = std::max(most, value);
        }
        if (least < most) std::printf("  %s: %g to %g %s\n", one.name, least, most, one.unit);
    }
}

void run(const description& d, const std::string& described, ranks& shared) {
    d.check();
    const anatomies all{d};
    if (d.plan) {
        if (shared.rank() == 0) print_plan(d, all, shared);
        return;
    }
    if (shared.rank() == 0) prepare_folder(d, described);
    shared.all(true); // wait for the folder

    const double begin = now();
    const std::uint32_t parts = part_count(d);
    std::uint32_t drawn = 0;
    drawing{d, all, longest_line(d), shared.rank()}.run(
        threads_of(shared), [&] { return shared.next(); },
        [&](std::uint32_t part, std::uint32_t samples) {
            drawn += samples;
            if (shared.rank() != 0 || samples == 0) return;
            const double passed = now() - begin, share = static_cast<double>(part + 1) / parts;
            std::fprintf(stderr, "\r%3.0f %%, %.1f samples/s, %.0f s left   ", 100 * share,
                         static_cast<double>(drawn) * shared.count() / passed, passed * (1 - share) / share);
        });
    shared.all(true);
    if (shared.rank() != 0) return;
    if (d.format == "hdf5") write_whole(d, all, longest_line(d));
    write_summary(d, all);
    std::fprintf(stderr, "\r%u samples in '%s', %.0f s; summary.html shows them\n", d.samples, d.output.c_str(),
                 now() - begin);
}

} // namespace

int main(int argc, char** argv) {
    ranks shared{argc, argv};
    hdf5_file::keep_quiet();
    CLI::App app{"Labelled ultrasound images of meshes, with ground truth."};
    description d;
    add_options(app, d);
    try {
        app.parse(argc, argv);
        if (d.anatomy.empty() && d.around.empty()) d.around = "skin"; // of the phantom, which lies below gel
        run(d, app.config_to_str(true, false), shared);
        return 0;
    } catch (const CLI::ParseError& error) {
        return shared.rank() == 0 ? app.exit(error) : error.get_exit_code();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "\ndataset: %s\n", error.what());
        if (shared.count() > 1) shared.stop(); // the others may be waiting
        return 1;
    }
}
