/// Replays a recorded session: live_replay FILE [PICTURES]. Prints the hash of each picture, drawn on one thread and on two,
/// and fails where they differ. PICTURES is the beginning of the names of PNG files.
#define INSONIFY_IMPLEMENTATION
#include "session.hpp"
#include <cstdio>
#include <exception>
#include <fstream>

namespace {

std::vector<std::uint64_t> replay(const std::string& file, std::uint32_t threads, const std::string& pictures) {
    std::ifstream lines{file};
    if (!lines) throw std::runtime_error{"live_replay: " + file + " cannot be opened"};
    live::session live;
    std::vector<std::uint64_t> hashes;
    for (std::string line; std::getline(lines, line);) {
        const std::optional<live::event> next = live::parse_event(line);
        if (!next) continue;
        if (next->name != "frame") {
            live.apply(*next);
            continue;
        }
        const insonify::image& seen = live.frame(insonify::exec::par_unseq.threads(threads));
        hashes.push_back(live::hash_of(live.screen()));
        if (!pictures.empty()) insonify::write_png(pictures + std::to_string(hashes.size()) + ".png", seen);
    }
    for (const float metres : live.measured) std::printf("measured: %.2f mm\n", 1e3 * metres);
    return hashes;
}

} // namespace

int main(int count, char** arguments) {
    try {
        if (count < 2) {
            std::printf("live_replay FILE [PICTURES]; events:\n%s", live::session::help().c_str());
            return 2;
        }
        const std::vector<std::uint64_t> one = replay(arguments[1], 1, count > 2 ? arguments[2] : ""),
                                         two = replay(arguments[1], 2, "");
        for (std::size_t i = 0; i < one.size(); ++i)
            std::printf("frame %zu: %016llx, on two threads %016llx\n", i + 1, static_cast<unsigned long long>(one[i]),
                        static_cast<unsigned long long>(two[i]));
        return !one.empty() && one == two ? 0 : 1;
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "%s\n", fault.what());
        return 2;
    }
}
