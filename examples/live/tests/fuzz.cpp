/// Random events, valid, out of range and garbage: live_fuzz --help. The same events are played again until a round
/// takes no more memory: buffers grow to what these settings need (those of the cine for a few rounds), and then no more.
#include "../../command_line.hpp"
#include "../recording.hpp"
#include <cstdio>
#include <limits>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

using namespace insonify;

/// Memory that is allocated now, MB; 0 where the system does not tell.
double memory_in_use() {
#ifdef __GLIBC__
    const struct mallinfo2 now = mallinfo2();
    return static_cast<double>(now.uordblks + now.hblkhd) / 1e6;
#else
    return 0;
#endif
}

/// Random numbers of a seed.
struct dice {
    std::uint64_t seed, drawn = 0;
    float fraction() { return hash_uniform(seed, drawn++); }
    std::uint32_t below(std::uint32_t count) {
        return std::min(static_cast<std::uint32_t>(fraction() * static_cast<float>(count)), count - 1);
    }
    float number(float low, float high) {
        constexpr float inf = std::numeric_limits<float>::infinity();
        const float odd[] = {std::numeric_limits<float>::quiet_NaN(), inf, -inf, 1e30F, -1e30F, 0, -1, 1e-30F};
        return below(8) == 0 ? odd[below(8)] : low + (1.4F * fraction() - 0.2F) * (high - low);
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
    if (one.values == 12 && random.below(2) == 0) { // a tracker: any direction, in the body and around it
        const auto any = [&](float size) { return size * (2 * random.fraction() - 1); };
        const vec3 from{any(60_mm), any(60_mm), any(60_mm)};
        const pose at = look_at(from, from + vec3{any(1), any(1), any(1)}, {any(1), any(1), any(1)});
        const vec3 columns[] = {at.rotation[0], at.rotation[1], at.rotation[2], 1e3F * from};
        made.values.clear();
        for (const vec3& column : columns)
            for (int i = 0; i < 3; ++i) made.values.push_back(column[i]);
    }
    if (one.group == "Quality" && count == 1)
        made.values[0] = one.event == "planes" ? 1.0F : 16 + 16 * random.fraction();
    return made;
}

/// What a round saw.
struct tally {
    std::uint32_t accepted = 0, refused = 0;
};

/// Plays the random events of a seed. @throws std::runtime_error  for a pixel out of range
tally play_round(live::session& one, std::uint64_t seed, int frames) {
    dice random{seed};
    tally seen;
    for (int frame = 0; frame < frames; ++frame) {
        for (std::uint32_t i = random.below(4); i > 0; --i) try {
                if (random.below(6) == 0) {
                    if (const std::optional<live::step> read = live::parse_step(garbage(random)); read && read->what)
                        one.apply(*read->what);
                } else
                    one.apply(random_event(random));
                ++seen.accepted;
            } catch (const std::invalid_argument&) {
                ++seen.refused;
            }
        for (const live::event& small : {live::event{"lines", {24}}, {"planes", {1}}, {"width", {32}}})
            one.apply(small);
        if (frame % 16 == 0) one.apply({"unfreeze", {}});
        for (const float pixel : one.frame(exec::par_unseq.threads(2)).pixels)
            if (!(pixel >= 0 && pixel <= 1)) throw std::runtime_error{"a pixel is " + std::to_string(pixel)};
        if (frame % 500 == 0) std::printf("frame %d: %.1f MB in use\n", frame, memory_in_use()), std::fflush(stdout);
    }
    return seen;
}

/// Turns all knobs to where they were in another session.
void reset(live::session& one, const live::session& to) {
    one.apply({"unfreeze", {}});
    one.apply({"interval", {live::session::usual_ticks}});
    one.hand = to.hand;
    one.needle = to.needle;
    for (const live::control& knob : live::controls())
        if (knob.value != nullptr) one.apply({knob.event, {knob.value(to) - (knob.is_relative ? knob.value(one) : 0)}});
    one.renew_needle();
}

int run(int frames, std::uint64_t seed) {
    const live::session fresh;
    live::session one;
    one.machine.cine_length = 8; // each picture of the ring keeps the memory of the largest one that it held
    const tally seen = play_round(one, seed, frames);
    std::printf("%d frames, %u events accepted, %u refused\n", frames, seen.accepted, seen.refused);
    if (seen.accepted == 0 || seen.refused == 0) return 1;
    double before = memory_in_use(), growth = 1;
    for (int round = 2; round <= 6 && growth > 0.001; ++round) {
        reset(one, fresh);
        play_round(one, seed, frames);
        const double after = memory_in_use();
        growth = before > 0 ? after / before - 1 : 0;
        std::printf("round %d: %.2f MB in use, %+.3f %%; at most 0.1 %% expected of one of them\n", round, after,
                    100 * growth);
        before = after;
    }
    return growth > 0.001 ? 1 : 0;
}

} // namespace

int main(int count, char** arguments) {
    int frames = 100;
    std::uint64_t seed = 1;
    return command_line::run(
        "live_fuzz", count, arguments,
        [&](CLI::App& app) {
            using namespace command_line;
            app.description("Plays random events, valid, out of range and garbage, and watches pixels and memory.");
            add_whole_number(app, "--frames", frames, "COUNT", "frames of a round", 1, 1'000'000);
            add_whole_number(app, "--seed", seed, "NUMBER", "of the random numbers", 0, 4'294'967'295);
        },
        [&] { return run(frames, seed); });
}
