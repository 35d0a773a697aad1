#ifndef INSONIFY_B_MODE_HPP
#define INSONIFY_B_MODE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scanner.hpp>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// The `scanner` that `b_mode` keeps its tables and memory in.
template <transducer Probe, acoustic_model Model = physical<>, class Tracer = straight_lines>
using b_mode_workspace = scanner<Probe, Model, Tracer>;

/// Simulates a B-mode image: the whole chain in one call, `scanner::scan`.
///
///     trace (physical) -> add_near_field -> convolve (the probe's pulse and beam) -> add_electronic_noise -> envelope
///         -> tgc -> compounding -> log_compress -> persistence -> map_grey -> scan_convert
///
/// The levels are fixed, so clips do not flicker. For a clip:
///
///     b_mode_workspace<linear_array> own;
///     for (;; ++settings.frame) show(b_mode(exec::par_unseq, body, probe, at, settings, physical{}, own));
///
/// @param model  acoustics of interfaces and media
/// @param own    tables and memory; pass it again with the next frame to avoid allocations
/// @param how    how sound travels: `straight_lines`, `paths`, or your own (`tracer`)
/// @return the image, valid until `own` is used again
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, tracer<Model> Tracer>
const image& b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                    const b_mode_settings& settings, const Model& model, scanner<Probe, Model, Tracer>& own,
                    const Tracer& how = {}) {
    own.probe = probe;
    own.settings = settings;
    own.model = model;
    own.how = how;
    return own.scan(policy, body, at);
}
/// The same for a single image.
///
///     b_mode(exec::par_unseq, body, probe, at, {.depth = 40_mm}, physical{}, paths{});
///
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, acoustic_model Model = physical<>,
          tracer<Model> Tracer = straight_lines>
image b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
             const b_mode_settings& settings = {}, const Model& model = {}, const Tracer& how = {}) {
    scanner<Probe, Model, Tracer> own{probe, settings, model, how};
    own.scan(policy, body, at);
    return std::move(own).picture();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
