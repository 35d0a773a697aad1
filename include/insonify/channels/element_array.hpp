#ifndef INSONIFY_CHANNELS_ELEMENT_ARRAY_HPP
#define INSONIFY_CHANNELS_ELEMENT_ARRAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/probe/transducer.hpp>
#include <cmath>
#include <concepts>
#include <cstdint>

/// Arrays, element by element.
namespace insonify::inline INSONIFY_ABI {

/// What a transducer array must state for channel data. `element(i)` is the centre of an element and the normal of its
/// face, in the frame of the probe (x lateral, y elevation, z depth), in order of x; normals lie in the plane
/// y = 0, and z of them is above 0. All elements are rectangles of one size, `element_width` across, `height` out of
/// the slice plane, with a lens that focuses at `elevation_focus`.
///
///     struct arc {  // an array of one's own
///         std::uint32_t elements = 64;
///         float element_width = 0.2_mm, height = 5_mm, elevation_focus = 30_mm;
///         float frequency = 5_MHz, bandwidth = 0.7F, sound_speed = 1540, fnumber = 2;
///         ray element(std::uint32_t i) const;
///         void check() const;  // throws `usage_error` for settings out of range
///     };
template <class Array>
concept element_transducer = requires(const Array& array, std::uint32_t i) {
    { array.elements } -> std::convertible_to<std::uint32_t>;
    { array.element(i) } -> std::same_as<ray>;
    { array.element_width } -> std::convertible_to<float>;
    { array.height } -> std::convertible_to<float>;
    { array.elevation_focus } -> std::convertible_to<float>;
    { array.frequency } -> std::convertible_to<float>;
    { array.bandwidth } -> std::convertible_to<float>;
    { array.sound_speed } -> std::convertible_to<float>;
    { array.fnumber } -> std::convertible_to<float>;
    array.check();
};

namespace detail {

inline constexpr std::uint32_t max_elements = 4096; // of an array: 8 million pairs

/// Checks what all arrays state. @throws usage_error
template <class Array>
void check_elements(const Array& array, float pitch, const char* owner) {
    if (array.elements == 0 || array.elements > max_elements)
        throw usage_error{owner, ": elements is ", array.elements, "; it must be 1 to 4096"};
    check_length(pitch, "pitch", max_aperture, owner);
    check_length(array.element_width, "element_width", max_aperture, owner);
    if (array.element_width > pitch * 1.0001F)
        throw usage_error{
            owner,        ": element_width is ",           1e3F * array.element_width, " mm, more than the pitch of ",
            1e3F * pitch, " mm; elements must not overlap"};
    check_frequency(array.frequency, owner);
    check_length(array.height, "height", max_aperture, owner);
    if (array.height < 10e-6F) // powers of it would underflow
        throw usage_error{owner, ": height is ", array.height, " m; it must be at least 10 um, and 5_mm is usual"};
    check_length(array.elevation_focus, "elevation_focus", max_scan_depth, owner);
    if (array.height > 2 * array.elevation_focus) // no lens does
        throw usage_error{owner,
                          ": height is ",
                          1e3F * array.height,
                          " mm, and elevation_focus ",
                          1e3F * array.elevation_focus,
                          " mm; it must be at least half the height"};
    if (!is_finite(array.bandwidth) || !(array.bandwidth >= 0.01F && array.bandwidth <= 1.5F))
        throw usage_error{owner, ": bandwidth is ", array.bandwidth,
                          "; it must be a fraction of the frequency from 0.01 to 1.5, such as 0.7"};
    if (!is_finite(array.sound_speed) || !(array.sound_speed >= 100 && array.sound_speed <= 10000))
        throw usage_error{owner, ": sound_speed is ", array.sound_speed,
                          " m/s; it must be 100 to 10000 m/s, and 1540 is usual"};
    if (!is_finite(array.fnumber) || !(array.fnumber >= 0.1F && array.fnumber <= 100))
        throw usage_error{owner, ": fnumber is ", array.fnumber, "; it must be 0.1 to 100, such as 2"};
}

} // namespace detail

/// Flat array: linear and phased arrays. Element e lies at x = (e - (elements - 1) / 2) pitch.
struct element_array {
    std::uint32_t elements = 128;  ///< from left to right
    float pitch = 0.30_mm;         ///< from centre to centre, metres
    float element_width = 0.27_mm; ///< metres; the rest of the pitch is silent
    float frequency = 7.6_MHz;     ///< of the carrier, hertz
    float height = 5_mm;           ///< of the elements, out of the slice plane, metres
    float elevation_focus = 18_mm; ///< of the lens, metres
    float bandwidth = 0.77F;       ///< fractional, of echoes at -6 dB
    float sound_speed = 1540;      ///< that delays assume, m/s
    /// Of the pictures whose levels `medium::backscatter` states: see `channels/README.md`.
    float fnumber = 2;

    /// See `element_transducer`.
    ray element(std::uint32_t i) const {
        return {.origin = {(static_cast<float>(i) - 0.5F * static_cast<float>(elements - 1)) * pitch, 0, 0}};
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const { detail::check_elements(*this, pitch, "element_array"); }

    friend bool operator==(const element_array&, const element_array&) = default;
};

/// Array on an arc, its elements at equal steps along it and normal to it.
struct convex_element_array {
    std::uint32_t elements = 128;  ///< from left to right
    float pitch = 0.508_mm;        ///< along the arc, from centre to centre, metres
    float radius = 49.57_mm;       ///< of the arc, metres
    float element_width = 0.46_mm; ///< metres; the rest of the pitch is silent
    float frequency = 3.57_MHz;    ///< of the carrier, hertz
    float height = 13.5_mm;        ///< of the elements, out of the slice plane, metres
    float elevation_focus = 60_mm; ///< of the lens, metres
    float bandwidth = 0.79F;       ///< fractional, of echoes at -6 dB
    float sound_speed = 1540;      ///< that delays assume, m/s
    float fnumber = 2;             ///< see `element_array::fnumber`

    /// See `element_transducer`.
    ray element(std::uint32_t i) const {
        const float angle = (static_cast<float>(i) - 0.5F * static_cast<float>(elements - 1)) * pitch / radius;
        const vec3 direction{std::sin(angle), 0, std::cos(angle)};
        return {.origin = radius * (direction - vec3{0, 0, 1}), .direction = direction};
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        detail::check_elements(*this, pitch, "convex_element_array");
        check_length(radius, "radius", max_aperture, "convex_element_array");
        if (!(static_cast<float>(elements) * pitch < pi * radius))
            throw usage_error{"convex_element_array: the elements span half a circle or more; round arrays have no "
                              "channel data: lower `elements` or `pitch`, or raise `radius`"};
    }

    friend bool operator==(const convex_element_array&, const convex_element_array&) = default;
};

/// The elements of the presets' probes. Source: as those; gaps between elements of a tenth of the pitch, as of L11-5v,
/// where PyMUST states none.
namespace presets {

// clang-format off

/// Vessels, nerves, muscles: 128 elements with a pitch of 0.30 mm.
inline constexpr element_array l11_5v_elements{};
/// Superficial structures: 192 elements with a pitch of 0.20 mm.
inline constexpr element_array l12_3v_elements{.elements = 192, .pitch = 0.20_mm, .element_width = 0.17_mm,
                                               .frequency = 7.54_MHz, .height = 5_mm, .elevation_focus = 20_mm,
                                               .bandwidth = 0.93F};
/// Abdomen: 128 elements with a pitch of 0.508 mm on an arc with a radius of 49.57 mm.
inline constexpr convex_element_array c5_2v_elements{};
/// Heart: 64 elements with a pitch of 0.30 mm.
inline constexpr element_array p4_2v_elements{.elements = 64, .pitch = 0.30_mm, .element_width = 0.25_mm,
                                              .frequency = 2.72_MHz, .height = 14_mm, .elevation_focus = 60_mm,
                                              .bandwidth = 0.74F};

// clang-format on

} // namespace presets
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
