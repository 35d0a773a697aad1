/// Every event of the table, in a recording: typical, at both ends of its range and beyond them. Pixels stay in range, knobs have
/// the value that was set, and the recording gives the same pictures. live_tests events
#include "../recording.hpp"
#include <cstdio>

namespace events_test {
namespace {

using namespace insonify;

constexpr const char* name = "events.txt";

/// Numbers of an event: at a share of its range, 0 to 1.
std::vector<float> numbers(const live::control& one, float fraction) {
    if (one.values == 12) { // a pose: no rotation
        const float place = one.low + fraction * (one.high - one.low);
        return {1, 0, 0, 0, 1, 0, 0, 0, 1, place, -place, place};
    }
    std::vector<float> values(one.values == live::control::any_even ? 8 : one.values);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = one.lowest(i) + fraction * (one.highest(i) - one.lowest(i));
    return values;
}

std::uint64_t draw(live::session& one) {
    for (const float pixel : one.frame(exec::par_unseq.threads(2)).pixels)
        if (!(pixel >= 0 && pixel <= 1)) throw std::runtime_error{"a pixel is " + std::to_string(pixel)};
    return live::hash_of(one.screen());
}

/// The mode in which an event shows.
float mode_of(const live::control& one) {
    if (one.event.rfind("gate", 0) == 0 || one.event == "baseline") return 4;
    return one.event == "m_line" ? 1.0F : one.group == "Doppler" ? 2.0F : 0.0F;
}

/// Small pictures, whatever the event before has done.
void make_small(live::session& one, float mode = 0) {
    for (const live::event& small : {live::event{"preset", {0}},
                                     {"mode", {mode}},
                                     {"compound", {1}},
                                     {"lines", {24}},
                                     {"planes", {1}},
                                     {"width", {32}},
                                     {"interval", {4}},
                                     {"unfreeze", {}}})
        one.apply(small);
}

// The value that a knob shows after an event.
bool shows(const live::session& one, const live::control& knob, float wanted) {
    if (knob.value == nullptr || knob.is_relative) return true;
    const float value = knob.value(one), step = knob.event == "planes" ? 2.0F : 0.51F;
    return std::fabs(value - wanted) <=
           (knob.choices.empty() && knob.step < 1 ? 1e-3F * std::fabs(wanted) + 1e-3F : step);
}

/// Applies all events and draws after each. @return the pictures
std::vector<std::uint64_t> play_all(live::session& one) {
    std::vector<std::uint64_t> pictures;
    for (const live::control& knob : live::controls())
        for (const float fraction : {0.5F, 0.0F, 1.0F, -1.0F, 2.0F}) { // typical, ends, beyond
            make_small(one, mode_of(knob));
            one.apply({knob.event, numbers(knob, fraction)});
            const std::vector<float> reached = numbers(knob, std::clamp(fraction, 0.0F, 1.0F));
            if (!reached.empty() && !shows(one, knob, reached[0]))
                throw std::runtime_error{live::event_line({knob.event, numbers(knob, fraction)}) + " gives " +
                                         std::to_string(knob.value(one))};
            if (knob.group == "Quality" && fraction > 0.5F) make_small(one);
            pictures.push_back(draw(one));
            if (knob.group == "Case") one.apply({"case", {0}});
            if (knob.event.rfind("hold", 0) == 0) one.apply({"release", {}});
        }
    return pictures;
}

// What a range refuses and what no range can hold.
bool refuses() {
    live::session one;
    std::size_t refused = 0, asked = 0;
    const auto ask = [&](const live::event& what, const auto& apply) {
        ++asked;
        try {
            apply(what);
            std::printf("not refused: %s\n", live::event_line(what).c_str());
        } catch (const std::invalid_argument&) {
            ++refused;
        }
    };
    for (const live::control& knob : live::controls()) {
        std::vector<float> values = numbers(knob, 0.5F);
        if (!values.empty()) {
            for (const float fraction : {-1.0F, 2.0F})
                if (knob.values != 12) ask({knob.event, numbers(knob, fraction)}, live::check_range);
            if (knob.grid_of(0) > 0 && knob.values != 12) {
                values[0] = knob.lowest(0) + 0.5F * knob.grid_of(0);
                ask({knob.event, values}, live::check_range);
            }
            values[0] = std::numeric_limits<float>::quiet_NaN();
            ask({knob.event, values}, [&](const live::event& what) { one.apply(what); });
        }
        ask({knob.event, std::vector<float>(values.size() + 1)}, [&](const live::event& what) { one.apply(what); });
    }
    return refused == asked;
}

// What would do nothing now, and what must come before it.
bool refuses_what_does_nothing() {
    live::session one;
    make_small(one);
    bool holds = true;
    const auto ask = [&](std::vector<live::event> all, const std::string& part) { // "" where it acts
        std::string said;
        try {
            live::effect_check effects{one};
            for (const live::event& each : all) effects.add(each);
        } catch (const std::invalid_argument& refused) {
            said = refused.what();
        }
        const bool right = part.empty() ? said.empty() : said.find(part) != std::string::npos;
        std::printf("%s %s: '%s'\n", right ? "ok  " : "FAIL", live::event_line(all.back()).c_str(), said.c_str());
        holds = holds && right;
    };
    const std::vector<float> pose{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 20};
    for (const live::event& early :
         {live::event{"freeze", {}}, {"cine", {0}}, {"measure", {1, 1, 9, 9}}, {"area", {1, 1, 9, 9, 1, 9}}})
        ask({early}, early.name + ": there is no picture yet; send it after the first one");
    draw(one);
    draw(one);
    ask({{"freeze", {}}}, "");
    ask({{"cine", {1}}}, "cine: earlier frames are shown while frozen; send freeze first");
    ask({{"freeze", {}}, {"cine", {1}}}, "");
    ask({{"freeze", {}}, {"cine", {2}}}, "the earliest is 1"); // two are stored
    ask({{"freeze", {}}, {"unfreeze", {}}, {"cine", {1}}}, "send freeze first");
    ask({{"measure", {1, 1, 9, 9}}}, "");
    for (const live::event& moved :
         {live::event{"slide", {1, 0}}, {"tilt", {1}}, {"rock", {1}}, {"rotate", {1}}, {"press", {1}}}) {
        ask({moved}, "");
        ask({{"hold_probe", pose}, moved}, "a tracker holds the probe; send release first");
        ask({{"hold_probe", pose}, {"release", {}}, moved}, "");
    }
    for (const live::event& moved :
         {live::event{"entry", {1, 0}}, {"steepness", {40}}, {"aside", {1}}, {"advance", {1}}}) {
        ask({moved}, "");
        ask({{"hold_needle", pose}, moved}, "a tracker holds the needle; send release first");
        ask({{"hold_probe", pose}, moved}, "");
    }
    for (const live::event& end : {live::event{"slide", {100, 100}},
                                   {"tilt", {-45}},
                                   {"rock", {30}},
                                   {"press", {10}},
                                   {"advance", {60}},
                                   {"rotate", {180}}}) {
        for (int i = 0; i < 2; ++i) one.apply(end); // from wherever it is
        live::event back = end;
        for (float& value : back.values) value *= -0.1F;
        ask({end}, end.name == "rotate" ? "" : "the end of its way");
        ask({back}, "");
        ask({back, end}, "");
    }
    return holds;
}

// A new session stands where its preset puts it: "preset 0" changes nothing.
bool begins_as_preset() {
    live::session fresh, set;
    set.apply({"preset", {0}});
    bool same = true;
    for (const live::control& knob : live::controls())
        if (knob.value != nullptr && knob.value(fresh) != knob.value(set)) {
            std::printf("%s is %g at the start, and %g after preset 0\n", knob.event.c_str(),
                        static_cast<double>(knob.value(fresh)), static_cast<double>(knob.value(set)));
            same = false;
        }
    return same && draw(fresh) == draw(set);
}

// Air below a probe that is lifted beyond the gel: nothing is seen through it.
bool air_is_black() {
    live::session one;
    make_small(one);
    one.apply({"press", {-8}});
    const image& seen = one.frame(exec::par_unseq);
    float brightest = 0;
    for (std::uint32_t y = seen.size.y / 2; y < seen.size.y; ++y)
        for (std::uint32_t x = 0; x < seen.size.x; ++x) brightest = std::max(brightest, seen(x, y));
    std::printf("lifted by 8 mm: the lower half is at most %.3f bright; 0.2, as noise, expected\n",
                static_cast<double>(brightest));
    return brightest < 0.2F;
}

} // namespace

int run() {
    std::vector<std::uint64_t> drawn, replayed;
    {
        std::ofstream file{name};
        live::recorder record{file};
        live::session one;
        one.record = &record;
        drawn = play_all(one);
    }
    live::session again;
    for (live::player steps{live::load_recording(name).steps}; steps.advance(again);) replayed.push_back(draw(again));
    std::printf("%zu events, %zu pictures; replayed: %s\n", live::controls().size(), drawn.size(),
                drawn == replayed ? "the same" : "NOT THE SAME");
    bool holds = drawn == replayed && refuses() && begins_as_preset();
    holds = air_is_black() && refuses_what_does_nothing() && holds;
    return holds ? 0 : 1;
}

} // namespace events_test
