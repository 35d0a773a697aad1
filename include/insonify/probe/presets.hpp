#ifndef INSONIFY_PROBE_PRESETS_HPP
#define INSONIFY_PROBE_PRESETS_HPP

#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>

/// Real probes, with one line for each element (the phased array: 128 lines over 90 degrees). They have the bandwidth of
/// the transducer, and F/2; `in_use` gives them the pulse and the aperture of a scanner in use.
///
/// Source: `getparam` of PyMUST (Garcia 2021), after Verasonics: pitch, elements, frequency, bandwidth, elevation.
namespace insonify::inline INSONIFY_ABI::presets {

/// Vessels, nerves, muscles: 128 elements with a pitch of 0.30 mm.
inline constexpr linear_array l11_5v{.lines = 128,
                                     .width = 128 * 0.30_mm,
                                     .frequency = 7.6_MHz,
                                     .elevation_height = 5_mm,
                                     .elevation_focus = 18_mm,
                                     .bandwidth = 0.77F};

/// Superficial structures: 192 elements with a pitch of 0.20 mm.
inline constexpr linear_array l12_3v{.lines = 192,
                                     .width = 192 * 0.20_mm,
                                     .frequency = 7.54_MHz,
                                     .elevation_height = 5_mm,
                                     .elevation_focus = 20_mm,
                                     .bandwidth = 0.93F};

/// Abdomen: 128 elements with a pitch of 0.508 mm on an arc with a radius of 49.57 mm.
inline constexpr convex_array c5_2v{.lines = 128,
                                    .radius = 49.57_mm,
                                    .field_of_view = 128 * 0.508F / 49.57F,
                                    .frequency = 3.57_MHz,
                                    .elevation_height = 13.5_mm,
                                    .elevation_focus = 60_mm,
                                    .bandwidth = 0.79F};

/// Heart: 64 elements with a pitch of 0.30 mm.
inline constexpr phased_array p4_2v{.lines = 128,
                                    .width = 64 * 0.30_mm,
                                    .field_of_view = 90_deg,
                                    .frequency = 2.72_MHz,
                                    .elevation_height = 14_mm,
                                    .elevation_focus = 60_mm,
                                    .bandwidth = 0.74F};

namespace detail {

/// The pulse after the receive filter, and the aperture after apodization.
template <class Array>
constexpr Array in_use(Array array, float fnumber) {
    constexpr float filter = 2.1_MHz;
    if (filter < array.bandwidth * array.frequency) array.bandwidth = filter / array.frequency;
    if (array.fnumber < fnumber) array.fnumber = fnumber;
    return array;
}

} // namespace detail

/// A transducer as a scanner uses it: with a receive filter of 2.1 MHz at -6 dB and an apodized aperture, which give speckle
/// cells as coarse as in clinical pictures. A narrower `bandwidth` or a larger `fnumber` of the transducer stays.
///
///     b_mode(exec::par_unseq, body, presets::in_use(presets::l11_5v), at)
///
/// Linear arrays get F/5.5, the width of an F/3 aperture with strong apodization. At 7 to 9 MHz and depths of 8 to 25 mm
/// the -6 dB widths of the autocovariance are then about 0.26 mm along the lines and 0.94 to 0.74 mm across them.
/// Source: autocovariance of 300 clinical pictures of muscle by four scanners, 0.23 to 0.33 mm and 0.7 to 1.1 mm.
constexpr linear_array in_use(const linear_array& transducer) { return detail::in_use(transducer, 5.5F); }
/// The same with F/3. Convention.
constexpr convex_array in_use(const convex_array& transducer) { return detail::in_use(transducer, 3); }
/// The same with F/3. Convention.
constexpr phased_array in_use(const phased_array& transducer) { return detail::in_use(transducer, 3); }

} // namespace insonify::inline INSONIFY_ABI::presets
#endif
