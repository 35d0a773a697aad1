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

inline void session::apply(const event& one) {
    const control& known = control_of(one);
    std::vector<float> values = one.values;
    for (float& value : values) {
        if (!is_finite(value)) throw std::invalid_argument{one.name + ": a number is not finite"};
        value = clamp(value, known.low, known.high);
    }
    if (known.unit == "pixels" && known.group == "Measure")
        for (std::size_t i = 0; i < values.size(); ++i) // within the picture
            values[i] = std::min(values[i], static_cast<float>(i % 2 == 0 ? screen_.size.x : screen_.size.y));
    if (record != nullptr) record->add(one);
    known.run(*this, values.data(), static_cast<std::uint32_t>(values.size()));
}

inline std::string session::help() {
    std::string text;
    for (const control& one : controls()) {
        std::ostringstream line;
        line << one.event << ": " << one.tooltip;
        if (one.values != 0)
            line << " (" << one.low << " to " << one.high << (one.unit.empty() ? "" : " ") << one.unit
                 << (one.is_relative ? ", added" : "") << ')';
        for (std::size_t i = 0; i < one.choices.size(); ++i)
            line << (i == 0 ? "; " : ", ") << one.low + static_cast<float>(i) << ' ' << one.choices[i];
        text += line.str() + '\n';
    }
    return text;
}

} // namespace live

#endif
