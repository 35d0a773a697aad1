/// Replays a recorded session on one thread and on two, prints the hash of each picture, and fails where they differ:
/// live_replay --help
#include "options.hpp"
#include "recording.hpp"
#include <chrono>
#include <cstdio>

namespace {

using namespace insonify;

struct options {
    std::string file{}, pictures{};
    live::anatomy_options body{};
    std::uint64_t frames = 0, every = 30; // 0 frames: all
    std::uint32_t threads = 0;
};

void add_options(CLI::App& app, options& into) {
    using namespace command_line;
    app.description(
        "Replays a recorded session as fast as it can, on one thread and on two, and compares the pictures.");
    add(app, "recording", into.file, "FILE", "text file of events, such as nerve_block.txt")->check(name())->required();
    add_whole_number(app, "--frames", into.frames, "COUNT", "stops after so many frames", 1, live::max_frames);
    add(app, "--pictures", into.pictures, "PREFIX", "writes pictures to PREFIX<number>.png")->check(name());
    add_whole_number(app, "--every", into.every, "COUNT", "writes every COUNT-th picture", 1, 1'000'000);
    add_whole_number(app, "--threads", into.threads, "COUNT", "replays once, on so many threads", 1, 1024);
    live::add_anatomy_options(app, into.body);
    app.footer(
        "Without --obj and --anatomy, the session is played on the anatomy that it was recorded with. Events:\n" +
        live::session::help());
}

std::vector<std::uint64_t> replay(const options& asked, const live::loaded_anatomy& examined, live::player steps,
                                  std::uint32_t threads) {
    live::session one = live::begin_session(examined);
    std::vector<std::uint64_t> hashes;
    std::size_t measures = 0;
    const auto begin = std::chrono::steady_clock::now();
    while ((asked.frames == 0 || hashes.size() < asked.frames) && steps.advance(one)) {
        for (; measures < one.measured.size(); ++measures) {
            const live::measurement& last = one.measured[measures];
            std::printf("frame %zu: measured ", hashes.size() + 1);
            if (last.closed)
                std::printf("%.2f mm2\n", 1e6 * static_cast<double>(last.area));
            else
                std::printf("%.2f mm; needle to nerve %.2f mm\n", 1e3 * static_cast<double>(last.length),
                            1e3 * static_cast<double>(one.tip_distance("epineurium").value_or(0)));
        }
        one.frame(exec::par_unseq.threads(threads));
        const std::uint64_t strip = live::hash_of(one.strip());
        hashes.push_back(live::hash_of(one.screen()) ^ (strip << 1U | strip >> 63U));
        if (!asked.pictures.empty() && hashes.size() % asked.every == 0)
            write_png(asked.pictures + std::to_string(hashes.size()) + ".png", one.screen());
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    std::printf("%zu frames on %u threads, %.1f frames/s\n", hashes.size(), threads,
                static_cast<double>(hashes.size()) / took.count());
    return hashes;
}

int run(const options& asked) {
    live::recording played = live::load_recording(asked.file);
    const live::loaded_anatomy examined = live::load_body(live::choice_of(asked.body), &played);
    const live::player steps{std::move(played.steps)};
    if (steps.frames() == 0)
        throw std::runtime_error{asked.file + ": nothing is drawn; a recorded session has lines such as: frames 30"};
    std::printf("%s\n", live::describe(examined).c_str());
    if (asked.threads != 0) {
        replay(asked, examined, steps, asked.threads);
        return 0;
    }
    const std::vector<std::uint64_t> one = replay(asked, examined, steps, 1), two = replay(asked, examined, steps, 2);
    for (std::size_t i = 0; i < one.size(); ++i)
        if (i % 30 == 0 || one[i] != two[i])
            std::printf("frame %zu: %016llx, on two threads %016llx\n", i + 1, static_cast<unsigned long long>(one[i]),
                        static_cast<unsigned long long>(two[i]));
    std::printf("%s\n", one == two ? "all pictures are the same" : "PICTURES DIFFER");
    return one == two ? 0 : 1;
}

} // namespace

int main(int count, char** arguments) {
    options asked;
    return command_line::run(
        "live_replay", count, arguments, [&](CLI::App& app) { add_options(app, asked); }, [&] { return run(asked); });
}
