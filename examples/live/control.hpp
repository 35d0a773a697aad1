#ifndef INSONIFY_EXAMPLES_LIVE_CONTROL_HPP
#define INSONIFY_EXAMPLES_LIVE_CONTROL_HPP

#include <insonify/core/math.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace live {

class session;

/// A text of the table, which is data and no code.
struct literal : std::string_view {
    constexpr literal(const char* text = "") : std::string_view{text} {}
    constexpr const char* c_str() const { return data(); }
    operator std::string() const { return std::string{*static_cast<const std::string_view*>(this)}; }
};

/// An event that a session takes, and how a user interface shows it. The table of all is `controls()`.
///
/// Numbers outside `low` to `high` are clamped by `session::apply`, and others than those of a `grid` go to the nearest one; those
/// that are not finite are refused.
struct control {
    literal event{};   ///< its name
    literal group{};   ///< Image, Quality, Probe, Needle, Doppler or Measure; of sliders and buttons in a panel
    literal title{};   ///< for people
    literal unit{};    ///< of its numbers
    literal tooltip{}; ///< one sentence
    float low = 0, high = 0, step = 1;
    std::uint32_t values = 1;                 ///< how many numbers it takes; `any_even`: x y x y ...
    float (*value)(const session&) = nullptr; ///< at present; null where there is none, as of a button
    bool is_relative = false;                 ///< the event takes the difference from the present value
    std::span<const literal> choices{};       ///< names of the values low, low + 1, ...; empty for a slider
    void (*run)(session&, const float*, std::uint32_t count) = nullptr; ///< takes the numbers, in range
    std::uint32_t parts = 0; ///< the first number chooses one of so many, from 0
    float (*part_value)(const session&, std::uint32_t part) = nullptr; ///< at present, of a part
    float grid = 0; ///< its numbers are `low` and so much more each; 0: any between, or the choices

    static constexpr std::uint32_t any_even = std::numeric_limits<std::uint32_t>::max();

    /// The range of its number i. @{
    float lowest(std::size_t i) const { return parts > 0 && i == 0 ? 0 : low; }
    float highest(std::size_t i) const { return parts > 0 && i == 0 ? static_cast<float>(parts - 1) : high; }
    float grid_of(std::size_t i) const { return !choices.empty() || (parts > 0 && i == 0) ? 1 : grid; }
    /// @}

    /// The nearest number that it takes as its number i.
    float nearest(std::size_t i, float number) const {
        const float smallest = lowest(i), inside = insonify::clamp(number, smallest, highest(i)), each = grid_of(i);
        return each > 0 ? smallest + each * std::round((inside - smallest) / each) : inside;
    }

    /// Whether a panel shows it as a slider.
    bool is_slider() const { return values == 1 && value != nullptr && choices.empty(); }
};

/// All events.
const std::vector<control>& controls();

} // namespace live

#endif
