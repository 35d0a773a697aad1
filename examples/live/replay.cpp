/// Replays a recorded session on one thread and on two, prints the hash of each picture, and fails where they differ.
///
///     live_replay FILE [--frames N] [--pictures PREFIX] [--every N] [--threads N]
///
/// --frames N stops after N frames; --pictures writes every 30th picture, or every Nth, to PREFIX<number>.png; --threads N
/// replays once.
#include "recording.hpp"
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>

namespace {

using namespace insonify;

struct options {
    std::string file{}, pictures{};
    std::uint32_t frames = 1'000'000, threads = 0, every = 30;
};

std::vector<std::uint64_t> replay(const options& asked, std::uint32_t threads) {
    const std::vector<live::step> steps = live::load_recording(asked.file);
    live::session one;
    std::vector<std::uint64_t> hashes;
    std::size_t measures = 0;
    const auto begin = std::chrono::steady_clock::now();
    live::play(steps, one, [&](live::session& now) {
        now.frame(exec::par_unseq.threads(threads));
        const std::uint64_t strip = live::hash_of(now.strip());
        hashes.push_back(live::hash_of(now.screen()) ^ (strip << 1U | strip >> 63U));
        if (!asked.pictures.empty() && hashes.size() % asked.every == 0) {
            const colour_image& seen = now.screen();
            write_png(asked.pictures + std::to_string(hashes.size()) + ".png", seen);
        }
        for (; measures < now.measured.size(); ++measures)
            std::printf("frame %zu: measured %.2f mm; needle to nerve %.2f mm\n", hashes.size(),
                        1e3 * static_cast<double>(now.measured[measures]),
                        1e3 * static_cast<double>(now.tip_distance("epineurium").value_or(0)));
        return hashes.size() < asked.frames;
    });
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    std::printf("%zu frames on %u threads, %.1f frames/s\n", hashes.size(), threads,
                static_cast<double>(hashes.size()) / took.count());
    return hashes;
}

} // namespace

int main(int count, char** arguments) {
    try {
        if (count < 2) {
            std::printf("live_replay FILE [--frames N] [--pictures PREFIX] [--every N] [--threads N]; events:\n%s",
                        live::session::help().c_str());
            return 2;
        }
        options asked{.file = arguments[1]};
        for (int i = 2; i + 1 < count; i += 2) {
            const std::string name = arguments[i], value = arguments[i + 1];
            if (name == "--pictures")
                asked.pictures = value;
            else if (name == "--frames")
                asked.frames = static_cast<std::uint32_t>(live::parse_number(name, value));
            else if (name == "--every")
                asked.every = std::max(1U, static_cast<std::uint32_t>(live::parse_number(name, value)));
            else if (name == "--threads")
                asked.threads = static_cast<std::uint32_t>(live::parse_number(name, value));
            else
                throw std::runtime_error{"live_replay: there is no option " + name};
        }
        if (asked.threads != 0) return replay(asked, asked.threads).empty() ? 1 : 0;
        const std::vector<std::uint64_t> one = replay(asked, 1), two = replay(asked, 2);
        for (std::size_t i = 0; i < one.size(); ++i)
            if (i % 30 == 0 || one[i] != two[i])
                std::printf("frame %zu: %016llx, on two threads %016llx\n", i + 1,
                            static_cast<unsigned long long>(one[i]), static_cast<unsigned long long>(two[i]));
        std::printf("%s\n", one == two ? "all pictures are the same" : "PICTURES DIFFER");
        return !one.empty() && one == two ? 0 : 1;
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "%s\n", fault.what());
        return 2;
    }
}
