#ifndef INSONIFY_PROBE_PRESETS_HPP
#define INSONIFY_PROBE_PRESETS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>

/// Real probes, with one line for each element (the phased array: 128 lines over 90 degrees). They have the bandwidth
/// of the transducer, and F/2; `in_use` gives them the pulse and the aperture of a scanner in use.
///
/// Source: `getparam` of PyMUST (Garcia 2021), after Verasonics: pitch, elements, frequency, bandwidth, elevation.
namespace insonify::inline INSONIFY_ABI::presets {

// clang-format off

/// Vessels, nerves, muscles: 128 elements with a pitch of 0.30 mm.
inline constexpr linear_array l11_5v{.lines = 128, .width = 128 * 0.30_mm, .frequency = 7.6_MHz,
                                     .elevation_height = 5_mm, .elevation_focus = 18_mm, .bandwidth = 0.77F};

/// Superficial structures: 192 elements with a pitch of 0.20 mm.
inline constexpr linear_array l12_3v{.lines = 192, .width = 192 * 0.20_mm, .frequency = 7.54_MHz,
                                     .elevation_height = 5_mm, .elevation_focus = 20_mm, .bandwidth = 0.93F};

/// Abdomen: 128 elements with a pitch of 0.508 mm on an arc with a radius of 49.57 mm.
inline constexpr convex_array c5_2v{.lines = 128, .radius = 49.57_mm, .field_of_view = 128 * 0.508F / 49.57F,
                                    .frequency = 3.57_MHz, .elevation_height = 13.5_mm, .elevation_focus = 60_mm,
                                    .bandwidth = 0.79F};

/// Heart: 64 elements with a pitch of 0.30 mm.
inline constexpr phased_array p4_2v{.lines = 128, .width = 64 * 0.30_mm, .field_of_view = 90_deg, .frequency = 2.72_MHz,
                                    .elevation_height = 14_mm, .elevation_focus = 60_mm, .bandwidth = 0.74F};

// clang-format on

/// A transducer as a scanner uses it: with a receive filter of 3.1 MHz at -6 dB and an apodized aperture of F/2.5,
/// which give images of muscle as coarse as clinical ones. A narrower `bandwidth` or a larger `fnumber` of the
/// transducer stays.
///
///     b_mode(exec::par_unseq, body, presets::in_use(presets::l11_5v), at)
///
/// `tests/in_use.cpp` measures the cells of muscle, along its fibres, as was done on 300 clinical
/// pictures of muscle by four scanners: 0.23 to 0.33 mm along the lines, 0.7 to 1.1 mm across them.
/// @tparam Array  a `linear_array`, `convex_array` or `phased_array`
template <transducer Array>
constexpr Array in_use(Array array) {
    constexpr float filter = 3.1_MHz, fnumber = 2.5F;
    if (filter < array.bandwidth * array.frequency) array.bandwidth = filter / array.frequency;
    if (array.fnumber < fnumber) array.fnumber = fnumber;
    return array;
}

} // namespace insonify::inline INSONIFY_ABI::presets

#include <insonify/core/restore_macros.hpp>

#endif
