#ifndef INSONIFY_CHANNELS_TRANSMIT_HPP
#define INSONIFY_CHANNELS_TRANSMIT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/channels/element_array.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// One transmit: when each element fires, and how strongly. What follows the weights describes the wave front for
/// `beamform` and for files; a transmit with delays of one's own may leave it out.
struct transmit {
    /// What a wave front looks like.
    enum class wave {
        any,       ///< unknown: it arrives with the first of the elements' waves
        plane,     ///< at `angle`
        diverging, ///< as if from `source`, behind the face
        focused,   ///< at `source`, in front of the face
    };

    std::vector<float> delays{};  ///< of each element, seconds; the first one fires at 0
    std::vector<float> weights{}; ///< of each element, -1 to 1; 0: silent. Empty: all 1
    wave front = wave::any;       ///< its shape
    float angle = 0;              ///< of the direction in which it travels, from z towards x, radians
    vec3 source{0, 0, 0};         ///< virtual source or focus, metres
    vec3 origin{0, 0, 0};         ///< middle of the elements that fire, metres

    /// Of an element.
    float weight(std::uint32_t element) const { return weights.empty() ? 1.0F : weights[element]; }

    friend bool operator==(const transmit&, const transmit&) = default;
};

namespace detail {

/// The largest angle of a steered wave, radians: beyond, elements hardly radiate.
inline constexpr float max_steering = 80 * pi / 180;

/// Delays from the time at which each element would fire if time could be negative, and the middle of what fires.
template <element_transducer Array>
transmit fired_at(const Array& array, std::vector<float> times, transmit made) {
    float first = FLT_MAX;
    vec3 sum{0, 0, 0};
    float count = 0;
    for (std::uint32_t i = 0; i < array.elements; ++i) {
        if (made.weight(i) == 0) continue;
        first = min(first, times[i]);
        sum += array.element(i).origin;
        ++count;
    }
    for (std::uint32_t i = 0; i < array.elements; ++i) times[i] = made.weight(i) == 0 ? 0.0F : times[i] - first;
    made.delays = std::move(times);
    made.origin = sum / max(count, 1);
    return made;
}

/// @throws usage_error  for delays or weights that do not fit to an array
template <class Deferred = void>
void check_transmit(const transmit& one, std::size_t number, std::uint32_t elements) {
    const std::string name = "transmit " + std::to_string(number) + ": ";
    if (one.delays.size() != elements)
        throw usage_error{name,           "it has ", one.delays.size(),
                          " delays for ", elements,  " elements; state one for each"};
    if (!one.weights.empty() && one.weights.size() != elements)
        throw usage_error{
            name, "it has ", one.weights.size(), " weights for ", elements, " elements; state one for each, or none"};
    constexpr float max_delay = 1e-3F; // seconds: sound travels 1.5 m
    for (const float delay : one.delays)
        if (!is_finite(delay) || !(delay >= 0 && delay <= max_delay))
            throw usage_error{name, "a delay is ", delay,
                              " s; delays must be 0 to 1e-3 s: subtract the smallest from all"};
    bool fires = one.weights.empty();
    for (const float weight : one.weights) {
        if (!is_finite(weight) || !(std::fabs(weight) <= 1))
            throw usage_error{name, "a weight is ", weight, "; weights must be -1 to 1: divide all by the largest"};
        fires = fires || weight != 0;
    }
    if (!is_finite(one.angle) || !is_finite(one.source) || !is_finite(one.origin))
        throw usage_error{name, "`angle`, `source` and `origin` must be finite"};
    if (!fires) throw usage_error{name, "all weights are 0; at least one element must fire"};
}

} // namespace detail

/// Plane waves at equal steps of angle.
///
///     plane_waves(array, 11, 20_deg)  // from -10 to 10 degrees
///
/// @param count   one: at 0 degrees
/// @param spread  from the first to the last, radians
/// @throws usage_error  for arguments out of range
template <element_transducer Array>
std::vector<transmit> plane_waves(const Array& array, std::uint32_t count, float spread) {
    array.check();
    if (count == 0) throw usage_error{"plane_waves: count is 0; it must be at least 1"};
    if (!is_finite(spread) || !(std::fabs(spread) <= 2 * detail::max_steering))
        throw usage_error{"plane_waves: spread is ", spread, " rad; it must be at most 160 degrees: write 20_deg"};
    std::vector<transmit> made;
    for (std::uint32_t k = 0; k < count; ++k) {
        const float angle = count == 1 ? 0.0F : spread * (static_cast<float>(k) / static_cast<float>(count - 1) - 0.5F);
        const vec3 direction{std::sin(angle), 0, std::cos(angle)};
        std::vector<float> times(array.elements);
        for (std::uint32_t i = 0; i < array.elements; ++i)
            times[i] = dot(array.element(i).origin, direction) / array.sound_speed;
        made.push_back(detail::fired_at(array, std::move(times), {.front = transmit::wave::plane, .angle = angle}));
    }
    return made;
}

/// Waves that diverge from virtual sources behind the face, one for each.
/// @param sources  in the frame of the probe, with y = 0, behind every element, metres
/// @throws usage_error  for a source in front of an element
template <element_transducer Array>
std::vector<transmit> diverging_waves(const Array& array, std::span<const vec3> sources) {
    array.check();
    std::vector<transmit> made;
    for (const vec3 source : sources) {
        std::vector<float> times(array.elements);
        for (std::uint32_t i = 0; i < array.elements; ++i) {
            const ray one = array.element(i);
            if (!is_finite(source) || !(dot(one.origin - source, one.direction) > 0))
                throw usage_error{"diverging_waves: a source lies in front of an element, or is not finite; place it "
                                  "behind the face, such as {0, 0, -10_mm}"};
            times[i] = length(one.origin - source) / array.sound_speed;
        }
        made.push_back(
            detail::fired_at(array, std::move(times), {.front = transmit::wave::diverging, .source = source}));
    }
    return made;
}

/// Focused beams, one for each focus.
/// @param points   foci in the frame of the probe, metres, in front of the face
/// @param fnumber  depth of the focus over the width of the elements that fire; 0: all fire
/// @throws usage_error  for a focus behind an element that fires, or an F-number out of range
template <element_transducer Array>
std::vector<transmit> focused(const Array& array, std::span<const vec3> points, float fnumber = 0) {
    array.check();
    if (!is_finite(fnumber) || !(fnumber >= 0))
        throw usage_error{"focused: fnumber must be above 0, or 0 for all elements"};
    std::vector<transmit> made;
    for (const vec3 focus : points) {
        if (!is_finite(focus)) throw usage_error{"focused: a focus is not finite"};
        // The element that is nearest to the focus in direction of its normal is the middle of the aperture.
        std::uint32_t middle = 0;
        float nearest = FLT_MAX;
        for (std::uint32_t i = 0; i < array.elements; ++i) {
            const ray one = array.element(i);
            const vec3 to = focus - one.origin;
            const float beside = length(to - dot(to, one.direction) * one.direction);
            if (beside < nearest) nearest = beside, middle = i;
        }
        const float depth = dot(focus - array.element(middle).origin, array.element(middle).direction);
        if (!(depth > 0))
            throw usage_error{"focused: a focus lies behind the face; its depth must be above 0, such as 20_mm"};
        const vec3 foot = focus - depth * array.element(middle).direction;
        std::vector<float> times(array.elements);
        transmit one{.front = transmit::wave::focused, .source = focus};
        if (fnumber > 0) one.weights.assign(array.elements, 0.0F);
        for (std::uint32_t i = 0; i < array.elements; ++i) {
            const vec3 at = array.element(i).origin;
            times[i] = -length(focus - at) / array.sound_speed;
            if (fnumber > 0 && (i == middle || length(at - foot) <= 0.5F * depth / fnumber)) one.weights[i] = 1;
        }
        made.push_back(detail::fired_at(array, std::move(times), std::move(one)));
    }
    return made;
}

/// Every element fires once, alone: with these, any other transmit can be computed afterwards.
/// @throws usage_error  for a setting of the array out of range
template <element_transducer Array>
std::vector<transmit> full_synthetic_aperture(const Array& array) {
    array.check();
    std::vector<transmit> made(array.elements);
    for (std::uint32_t i = 0; i < array.elements; ++i) {
        made[i].delays.assign(array.elements, 0.0F);
        made[i].weights.assign(array.elements, 0.0F);
        made[i].weights[i] = 1;
        made[i].front = transmit::wave::diverging;
        made[i].source = made[i].origin = array.element(i).origin;
    }
    return made;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
