/// Random events, valid, out of range and garbage: live_fuzz [FRAMES] [SEED]. From 2,000 frames on it fails
/// if memory grows after the first half.
#include "../recording.hpp"
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>

namespace {

using namespace insonify;

/// Resident memory, MB; 0 where the system does not tell.
double resident_memory() {
    std::ifstream file{"/proc/self/statm"};
    double pages = 0;
    file >> pages >> pages;
    return pages * 4096 / 1e6;
}

/// Random numbers of a seed.
struct dice {
    std::uint64_t seed, drawn = 0;
    float share() { return hash_uniform(seed, drawn++); }
    std::uint32_t below(std::uint32_t count) {
        return std::min(static_cast<std::uint32_t>(share() * static_cast<float>(count)), count - 1);
    }
    float number(float low, float high) {
        constexpr float inf = std::numeric_limits<float>::infinity();
        const float odd[] = {std::numeric_limits<float>::quiet_NaN(), inf, -inf, 1e30F, -1e30F, 0, -1, 1e-30F};
        return below(8) == 0 ? odd[below(8)] : low + (1.4F * share() - 0.2F) * (high - low);
    }
};

/// A random line of text.
std::string garbage(dice& random) {
    std::string line = random.below(2) == 0 ? live::controls()[random.below(20)].event : "";
    for (std::uint32_t i = random.below(12); i > 0; --i)
        line += static_cast<char>(random.below(2) == 0 ? 32 + random.below(95) : 1 + random.below(255));
    return line;
}

/// An event with random numbers; small pictures stay small.
live::event random_event(dice& random) {
    const std::vector<live::control>& all = live::controls();
    const live::control& one = all[random.below(static_cast<std::uint32_t>(all.size()))];
    live::event made{one.event};
    const std::uint32_t count = one.values == live::control::any_even ? 2 * random.below(8)
                                : random.below(20) == 0               ? random.below(6)
                                                                      : one.values;
    for (std::uint32_t i = 0; i < count; ++i) made.values.push_back(random.number(one.low, one.high));
    if (one.group == "Quality" && count == 1) made.values[0] = one.event == "planes" ? 1.0F : 16 + 16 * random.share();
    return made;
}

} // namespace

int main(int count, char** arguments) {
    const int frames = count > 1 ? std::atoi(arguments[1]) : 300;
    dice random{count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1};
    live::session one;
    for (const live::event& small : {live::event{"lines", {24}}, {"planes", {1}}, {"width", {32}}}) one.apply(small);
    std::uint32_t accepted = 0, refused = 0;
    double warm = 0;
    for (int frame = 0; frame < frames; ++frame) {
        for (std::uint32_t i = random.below(4); i > 0; --i) try {
                if (random.below(6) == 0) {
                    if (const std::optional<live::step> read = live::parse_step(garbage(random)); read && read->what)
                        one.apply(*read->what);
                } else
                    one.apply(random_event(random));
                ++accepted;
            } catch (const std::invalid_argument&) {
                ++refused;
            }
        one.apply({"lines", {24}});
        one.apply({"width", {32}});
        if (frame % 16 == 0) one.apply({"unfreeze", {}});
        const image& seen = one.frame(exec::par_unseq.threads(2));
        for (const float pixel : seen.pixels)
            if (!(pixel >= 0 && pixel <= 1)) return std::printf("a pixel is %g in frame %d\n", double{pixel}, frame), 1;
        if (frame == frames / 2) warm = resident_memory();
        if (frames >= 2000 && frame % 1000 == 0) std::printf("frame %d: %.1f MB\n", frame, resident_memory());
    }
    const double grown = resident_memory() - warm;
    std::printf("%d frames, %u events accepted, %u refused; memory grew by %.1f MB from %.1f MB\n", frames, accepted,
                refused, grown, warm);
    return accepted > 0 && refused > 0 && (frames < 2000 || grown < 0.1 * warm) ? 0 : 1;
}
