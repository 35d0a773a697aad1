#ifndef INSONIFY_EXAMPLES_LIVE_CONTROL_HPP
#define INSONIFY_EXAMPLES_LIVE_CONTROL_HPP

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace live {

class session;

/// An event that a session takes, and how a user interface shows it. The table of all is `controls()`.
///
/// Numbers outside `low` to `high` are clamped by `session::apply`; those that are not finite are refused.
struct control {
    std::string event{};   ///< its name
    std::string group{};   ///< Image, Quality, Probe, Needle, Doppler or Measure; of sliders and buttons in a panel
    std::string title{};   ///< for people
    std::string unit{};    ///< of its numbers
    std::string tooltip{}; ///< one sentence
    float low = 0, high = 0, step = 1;
    std::uint32_t values = 1;                 ///< how many numbers it takes; `any_even`: x y x y ...
    float (*value)(const session&) = nullptr; ///< at present; null where there is none, as of a button
    bool is_relative = false;                 ///< the event takes the difference from the present value
    std::vector<std::string> choices{};       ///< names of the values low, low + 1, ...; empty for a slider
    void (*run)(session&, const float*, std::uint32_t count) = nullptr; ///< takes the numbers, in range
    std::uint32_t parts = 0; ///< the first number chooses one of so many, from 0
    float (*part_value)(const session&, std::uint32_t part) = nullptr; ///< at present, of a part

    static constexpr std::uint32_t any_even = std::numeric_limits<std::uint32_t>::max();

    /// The range of its number i. @{
    float lowest(std::size_t i) const { return parts > 0 && i == 0 ? 0 : low; }
    float highest(std::size_t i) const { return parts > 0 && i == 0 ? static_cast<float>(parts - 1) : high; }
    /// @}

    /// Whether a panel shows it as a slider.
    bool is_slider() const { return values == 1 && value != nullptr && choices.empty(); }
};

/// All events.
const std::vector<control>& controls();

} // namespace live

#endif
