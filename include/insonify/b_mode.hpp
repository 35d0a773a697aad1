#ifndef INSONIFY_B_MODE_HPP
#define INSONIFY_B_MODE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scanner.hpp>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// Simulates a B-mode image: the whole chain in one call, the first picture of a `scanner`, which a clip is made by.
///
///     trace (physical) -> add_reverberation -> add_near_field -> convolve (the probe's pulse and beam)
///         -> resample_lines -> add_electronic_noise -> envelope -> tgc -> compounding -> log_compress -> persistence
///         -> map_grey -> scan_convert
///
/// @param at  probe to world
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
image b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
             const b_mode_settings& settings = {}) {
    return b_mode(policy, body, probe, at, physical<>{}, settings);
}
/// The same with other acoustics, and another way for sound to travel.
/// @param model  acoustics of interfaces and media
/// @param how    how sound travels: `straight_lines`, `paths`, or your own (`tracer`)
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, acoustic_model Model, tracer<Model> Tracer = straight_lines>
image b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at, const Model& model,
             const b_mode_settings& settings = {}, const Tracer& how = {}) {
    scanner<Probe, Model, Tracer> machine{probe, settings, model, how};
    machine.scan(policy, body, at);
    return std::move(machine).picture();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
