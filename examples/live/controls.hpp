#ifndef INSONIFY_EXAMPLES_LIVE_CONTROLS_HPP
#define INSONIFY_EXAMPLES_LIVE_CONTROLS_HPP

#include "controls_case.hpp"
#include "controls_doppler.hpp"
#include "controls_hands.hpp"
#include "controls_image.hpp"
#include "controls_tracker.hpp"
#include <algorithm>
#include <cmath>

namespace live {

inline const std::vector<control>& controls() {
    static const std::vector<control> all = [] {
        std::vector<control> joined;
        for (const std::span<const control> part :
             {detail::case_controls(), detail::image_controls(), detail::hand_controls(), detail::doppler_controls(),
              detail::tracker_controls()})
            joined.insert(joined.end(), part.begin(), part.end());
        return joined;
    }();
    return all;
}

/// The entry of an event; null for an unknown name.
inline const control* find_control(const std::string& name) {
    for (const control& one : controls())
        if (one.event == name) return &one;
    return nullptr;
}

/// The names of what can be chosen, such as "; 0 Off, 1 On"; empty where it is a number.
inline std::string choices_text(const control& one) {
    std::ostringstream text;
    for (std::size_t i = 0; i < one.choices.size(); ++i)
        text << (i == 0 ? "; " : ", ") << one.low + static_cast<float>(i) << ' ' << one.choices[i];
    return text.str();
}

/// The entry of an event. @throws std::invalid_argument  for an unknown name or a wrong number of values
inline const control& control_of(const event& one) {
    const control* const known = find_control(one.name);
    if (known == nullptr) throw std::invalid_argument{"there is no event '" + one.name + "'"};
    const std::size_t count = one.values.size();
    if (known->values == control::any_even) {
        if (count < 6 || count > 1024 || count % 2 != 0)
            throw std::invalid_argument{one.name + " takes x and y of 3 to 512 points: " + known->tooltip.c_str()};
    } else if (count != known->values)
        throw std::invalid_argument{one.name + " takes " + std::to_string(known->values) +
                                    (known->values == 1 ? " number: " : " numbers: ") + known->tooltip.c_str() +
                                    choices_text(*known)};
    return *known;
}

/// Checks an event as `session::apply` does, and refuses numbers that it would change. @throws std::invalid_argument
inline void check_range(const event& one) {
    const control& known = control_of(one);
    for (std::size_t i = 0; i < one.values.size(); ++i) {
        if (known.nearest(i, one.values[i]) == one.values[i]) continue;
        const float low = known.lowest(i), high = known.highest(i), grid = known.grid_of(i);
        const bool has_unit = !known.unit.empty() && (known.parts == 0 || i > 0);
        std::ostringstream sentence;
        sentence << one.name << ": " << one.values[i] << " is not ";
        if (grid == 1) sentence << "a whole number from ";
        sentence << low << " to " << high;
        if (grid > 1) sentence << ", in steps of " << grid;
        if (has_unit) sentence << ' ' << known.unit;
        throw std::invalid_argument{sentence.str() + choices_text(known)};
    }
}

/// Whether an event measures on the picture.
inline bool measures(const control& one) { return one.group == "Measure" && one.unit == "pixels"; }

inline constexpr const char* no_picture = "there is no picture yet; send it after the first one";

/// Refuses events that would do nothing in the state of a session, for programs that answer for each event. Of several events, one
/// after another, the earlier ones count as applied.
class effect_check {
  public:
    explicit effect_check(const session& of)
        : of_{of}, stored_{of.machine.cine().size()}, frozen_{of.machine.frozen()},
          probe_held_{of.hand.held.has_value()}, needle_held_{of.needle.held.has_value()} {}

    /// @throws std::invalid_argument  saying why, and what to do first
    void add(const event& one) {
        const control& known = control_of(one);
        const std::string& name = one.name;
        const auto fail = [&](const std::string& why) { throw std::invalid_argument{name + ": " + why}; };
        if (known.group == "Measure" && name != "unfreeze" && stored_ == 0) fail(no_picture);
        if (name == "cine" && !frozen_) fail("earlier frames are shown while frozen; send freeze first");
        if (name == "cine" && !(one.values[0] < static_cast<float>(stored_)))
            fail("of the frames that are stored, the earliest is " + std::to_string(stored_ - 1));
        if (probe_held_ && known.group == "Probe" && known.is_relative)
            fail("a tracker holds the probe; send release first");
        if (needle_held_ && (name == "entry" || name == "steepness" || name == "aside" || name == "advance"))
            fail("a tracker holds the needle; send release first");
        if (known.is_relative && is_at_end(known, one)) fail("that is the end of its way; it can only go back");
        moved_.push_back(name);
        if (known.group == "Case") { // another body: nothing is known of it yet
            opens_ = true;
            stored_ = 0;
            frozen_ = probe_held_ = needle_held_ = false;
        }
        if (name == "freeze" || name == "unfreeze") frozen_ = name == "freeze";
        if (name == "hold_probe") probe_held_ = true;
        if (name == "hold_needle") needle_held_ = true;
        if (name == "release") probe_held_ = needle_held_ = false;
    }

  private:
    // Whether nothing is left of a movement: not where an earlier event has moved the same.
    bool is_at_end(const control& known, const event& one) const {
        constexpr float step = 1e-3F;
        if (opens_) return false;
        if (std::find(moved_.begin(), moved_.end(), one.name) != moved_.end()) return false;
        if (one.name == "slide") {
            const vec2 way{one.values[0], one.values[1]};
            return way != vec2{0, 0} && of_.slid(1e-3F * way) == of_.hand.on_skin;
        }
        if (known.event == "rotate") return false; // all around
        const float now = known.value(of_), way = one.values[0];
        return way > 0 ? now > known.high - step : way < 0 && now < known.low + step;
    }

    const session& of_;
    std::uint32_t stored_; // frames
    bool frozen_, probe_held_, needle_held_;
    bool opens_ = false;               // another body
    std::vector<std::string> moved_{}; // events so far
};

inline session::session(examined begun) {
    machine.probe = begun.probe;
    machine.settings = begun.settings;
    machine.cine_length = 32;
    begin(std::move(begun));
}

inline void session::begin(examined next) {
    static_cast<patient&>(*this) = patient{std::move(next.body), std::move(next.vessels)};
    ++bodies;
    next.body = scene{};
    next.vessels.clear();
    view = std::move(next);
    hand = view.hand;
    if (view.face) hand.gel = skin_at(hand.on_skin) - *view.face;
    needle = view.needle;
    if (!view.enters) needle.entry.z = skin_at({needle.entry.x, needle.entry.y});

    // A new scanner of the same quality, whose clock goes on.
    const b_mode_settings before = machine.settings;
    scanner<array_probe> fresh{view.probe, view.settings};
    fresh.probe.lines = machine.probe.lines;
    fresh.settings.planes = before.planes;
    fresh.settings.size = before.size;
    fresh.settings.frame = before.frame;
    fresh.settings.interpolates_lines = true;
    fresh.time = machine.time;
    fresh.cine_length = machine.cine_length;
    machine = std::move(fresh);
    use_preset(*this, view.face ? preset_of_view : 0);
    const float scale = doppler.scale; // of the preset
    doppler = doppler_unit{};
    doppler.scale = scale;
    place_doppler();
    shown = mode::b;
    m_side = 0;
    sweep = m_mode{{.columns = 256, .rows = 256}};
    measured.clear();
    shows_measurement = false;
    cine_back.reset();
    renew_needle();
    follow_needle();
}

inline void session::open(std::uint32_t number, std::uint32_t drawn) {
    examined next = examine(cases[number], drawn, given); // may throw
    case_number = number;
    patient_number = drawn;
    begin(std::move(next));
}

// Box and gate to the vessel of the slice that is seen best: wide, not deep, and rather an artery. Veins right below the face
// are pressed flat, about as deep as twice the depth of the press.
inline void session::place_doppler() {
    constexpr float near_slice = 1.5_mm, priority_of_arteries = 4;
    const float depth = machine.settings.depth, pressed = view.face ? *view.face : 0;
    doppler.box_size = depth * vec2{0.4F, 0.35F};
    if (machine.probe.kind != array_probe::shape::linear) doppler.gain_db = 10; // echoes from the depth are weaker
    doppler.box_middle = doppler.gate = {0, 0.5F * depth};
    float best = 0;
    for (const vessel& one : vessels())
        for (std::size_t i = 1; i < one.line.size(); ++i)
            for (int k = 0; k < 8; ++k) {
                const tube_section &a = one.line[i - 1], &b = one.line[i];
                const vec3 at = a.centre + static_cast<float>(k) / 8 * (b.centre - a.centre);
                const vec2 place = machine.probe.locate({at.x, at.z});
                if (std::fabs(at.y) > near_slice || place.x < 0 || place.y < 3_mm || place.y > 0.75F * depth ||
                    place.x > static_cast<float>(machine.probe.lines - 1))
                    continue;
                if (one.type == vessel::kind::vein && at.z < 2 * pressed) continue;
                const float away = length(vec2{at.x, at.z});
                const float seen = (one.type == vessel::kind::artery ? priority_of_arteries : 1) * a.radii.x *
                                   a.radii.y / (away * away);
                if (!(seen > best)) continue;
                best = seen;
                doppler.box_middle = doppler.gate = {at.x, at.z - pressed};
            }
}

inline void session::apply(const event& one) {
    const control& known = control_of(one);
    std::vector<float> values = one.values;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!is_finite(values[i])) throw std::invalid_argument{one.name + ": a number is not finite"};
        values[i] = known.nearest(i, values[i]);
    }
    if (measures(known))
        for (std::size_t i = 0; i < values.size(); ++i) // within the picture
            values[i] = std::min(values[i], static_cast<float>(i % 2 == 0 ? screen_.size.x : screen_.size.y));
    known.run(*this, values.data(), static_cast<std::uint32_t>(values.size()));
    if (record != nullptr) record->add(one);
}

inline std::string session::help() {
    std::string text;
    for (const control& one : controls()) {
        std::ostringstream line;
        line << one.event << ": " << one.tooltip;
        if (one.values != 0)
            line << " (" << (one.parts > 0 ? "0 to " + std::to_string(one.parts - 1) + ", " : "") << one.low << " to "
                 << one.high << (one.unit.empty() ? "" : " ") << one.unit << (one.is_relative ? ", added" : "")
                 << (one.grid_of(one.values - 1) > 0
                         ? ", in steps of " + std::to_string(std::lround(one.grid_of(one.values - 1)))
                         : "")
                 << ')';
        text += line.str() + choices_text(one) + '\n';
    }
    return text;
}

} // namespace live

#endif
