#ifndef INSONIFY_EXAMINATIONS_HPP
#define INSONIFY_EXAMINATIONS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/b_mode.hpp>
#include <insonify/probe/presets.hpp>
#include <insonify/probe/radial_array.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A probe and scanner settings for an examination. The probes have the effective pulse and aperture of a scanner in
/// use: see `presets::in_use`; the intravascular one has those of the transducer.
template <transducer Probe>
struct examination {
    Probe probe{};              ///< the transducer
    b_mode_settings settings{}; ///< for `b_mode`
};

} // namespace insonify::inline INSONIFY_ABI

namespace insonify::inline INSONIFY_ABI::presets {

/// Tone curve of clinical images, for a dynamic range of 85 dB: gaps between the echoes of a tissue are dark but not
/// black, and its borders stay below white.
///
/// `tests/examinations.cpp` compares the grey levels of muscle, of fat and of the fascia between them with those of
/// clinical images.
inline constexpr grey_map clinical_grey{.reject = 0.35F, .shoulder = 0.55F, .softness = 0.06F};

/// Ring-down of transducers in use: the upper edge of bright lines is 1.1 to 1.3 times as steep as the lower one in
/// clinical pictures of muscle, by four scanners.
inline constexpr float in_use_ring_down_db = -16;

/// Nerve block: a needle near a nerve a few centimetres below the skin.
inline const examination<linear_array> nerve_block{
    .probe = in_use(
        linear_array{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz, .focus = 18_mm, .elevation_focus = 18_mm}),
    .settings = {.depth = 40_mm,
                 .dynamic_range_db = 85,
                 .tgc = 0.85_dB_per_cm,
                 .planes = 7,
                 .grey = clinical_grey,
                 .compound = {.angles = 3, .spread = 6_deg},
                 .ring_down_db = in_use_ring_down_db}};

/// Liver, kidneys, gall bladder.
inline const examination<convex_array> abdomen{
    .probe = in_use(convex_array{.lines = 192, .radius = 60_mm, .field_of_view = 60_deg, .frequency = 3.5_MHz}),
    .settings = {.depth = 160_mm,
                 .dynamic_range_db = 85,
                 .reference_db = -21,
                 .grey = clinical_grey,
                 .compound = {.angles = 3, .spread = 6_deg},
                 .ring_down_db = in_use_ring_down_db}};

/// The heart between the ribs.
inline const examination<phased_array> heart{
    .probe = in_use(phased_array{.lines = 128, .width = 20_mm, .field_of_view = 90_deg, .frequency = 2.5_MHz}),
    .settings = {.depth = 160_mm,
                 .dynamic_range_db = 85,
                 .reference_db = -20,
                 .grey = clinical_grey,
                 .ring_down_db = in_use_ring_down_db}};

/// Vessel, from inside.
inline const examination<radial_array> intravascular{
    .probe = {.lines = 256, .radius = 0.5_mm, .frequency = 20_MHz},
    .settings = {.depth = 6_mm, .dynamic_range_db = 85, .reference_db = -17, .grey = clinical_grey}};

/// Settings of the examination for which a kind of probe is made.
/// @{
inline const b_mode_settings& settings_for(const linear_array&) { return nerve_block.settings; }
inline const b_mode_settings& settings_for(const convex_array&) { return abdomen.settings; }
inline const b_mode_settings& settings_for(const phased_array&) { return heart.settings; }
inline const b_mode_settings& settings_for(const radial_array&) { return intravascular.settings; }
/// @}

} // namespace insonify::inline INSONIFY_ABI::presets

#include <insonify/core/restore_macros.hpp>

#endif
