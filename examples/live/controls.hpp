#ifndef INSONIFY_EXAMPLES_LIVE_CONTROLS_HPP
#define INSONIFY_EXAMPLES_LIVE_CONTROLS_HPP

#include "controls_doppler.hpp"
#include "controls_hands.hpp"
#include "controls_image.hpp"
#include "controls_tracker.hpp"
#include <cmath>

namespace live {

inline const std::vector<control>& controls() {
    static const std::vector<control> all = [] {
        std::vector<control> joined = detail::image_controls();
        for (const auto& part : {detail::hand_controls(), detail::doppler_controls(), detail::tracker_controls()})
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

/// The entry of an event. @throws std::invalid_argument  for an unknown name or a wrong number of values
inline const control& control_of(const event& one) {
    const control* const known = find_control(one.name);
    if (known == nullptr) throw std::invalid_argument{"there is no event '" + one.name + "'"};
    const std::size_t count = one.values.size();
    if (known->values == control::any_even) {
        if (count < 6 || count > 1024 || count % 2 != 0)
            throw std::invalid_argument{one.name + " takes x and y of 3 to 512 points: " + known->tooltip};
    } else if (count != known->values)
        throw std::invalid_argument{one.name + " takes " + std::to_string(known->values) +
                                    " numbers: " + known->tooltip};
    return *known;
}

/// Checks an event as `session::apply` does, and refuses numbers that it would clamp. @throws std::invalid_argument
inline void check_range(const event& one) {
    const control& known = control_of(one);
    for (std::size_t i = 0; i < one.values.size(); ++i)
        if (const float low = known.lowest(i), high = known.highest(i);
            !(one.values[i] >= low && one.values[i] <= high)) {
            std::ostringstream sentence;
            sentence << one.name << ": " << one.values[i] << " is not " << low << " to " << high
                     << (known.unit.empty() ? "" : " ") << known.unit;
            throw std::invalid_argument{sentence.str()};
        }
}

inline session::session(scene anatomy) : patient{std::move(anatomy)} {
    machine.probe = nerve_block::probe;
    machine.settings = nerve_block::settings;
    machine.settings.interpolates_lines = true;
    machine.cine_length = 32;
    use_preset(*this, preset);
    const aabb whole = box();
    if (!whole.empty() && !body.find("nerve")) { // an unknown body: above its middle
        hand.on_skin = {0.5F * (whole.lower.x + whole.upper.x), 0.5F * (whole.lower.y + whole.upper.y)};
        needle.entry = {hand.on_skin.x - 24_mm, hand.on_skin.y, 0};
    }
    needle.entry.z = skin_at({needle.entry.x, needle.entry.y});
    renew_needle();
    follow_needle();
}

inline void session::apply(const event& one) {
    const control& known = control_of(one);
    std::vector<float> values = one.values;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!is_finite(values[i])) throw std::invalid_argument{one.name + ": a number is not finite"};
        values[i] = clamp(values[i], known.lowest(i), known.highest(i));
    }
    if (known.unit == "pixels" && known.group == "Measure")
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
                 << one.high << (one.unit.empty() ? "" : " ") << one.unit << (one.is_relative ? ", added" : "") << ')';
        for (std::size_t i = 0; i < one.choices.size(); ++i)
            line << (i == 0 ? "; " : ", ") << one.low + static_cast<float>(i) << ' ' << one.choices[i];
        text += line.str() + '\n';
    }
    return text;
}

} // namespace live

#endif
