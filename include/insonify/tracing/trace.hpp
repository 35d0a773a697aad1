#ifndef INSONIFY_TRACING_TRACE_HPP
#define INSONIFY_TRACING_TRACE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/straight_lines.hpp>
#include <insonify/tracing/trace_frame.hpp>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// Tables and buffers of `trace`: passed again with the lines of the last frame, they avoid allocations.
template <transducer Probe, acoustic_model Model, class Tracer = straight_lines>
using trace_workspace = trace_workspace_of<Probe, Model, Tracer>;

/// What the probe receives along its lines.
///
///     iq_lines echoes = trace(exec::par_unseq, body, linear_array{}, at, physical{}, {.depth = 40_mm});
///     scan_lines paper = trace(exec::par_unseq, body, linear_array{}, at, law2011{}, {.depth = 40_mm});
///     iq_lines bent = trace(exec::par_unseq, body, linear_array{}, at, physical{}, {.depth = 40_mm}, paths{});
///
/// @param at     probe to world: x lateral, y elevation, z depth
/// @param model  what happens at interfaces and between them: `physical`, `law2011`, or your own (`acoustic_model`)
/// @param how    how sound travels: `straight_lines`, `paths`, or your own (`tracer`)
/// @return `probe.lines` lines of `settings.samples` samples, of the type that the model makes
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, tracer<Model> Tracer = straight_lines>
line_grid<typename Model::sample_type> trace(const Policy& policy, const scene& body, const Probe& probe,
                                             const pose& at, const Model& model, const acquisition& settings,
                                             const Tracer& how = {}) {
    trace_workspace<Probe, Model, Tracer> own;
    return detail::trace_frame(detail::any_policy{policy}, body, probe, at, model, settings, how, own, {});
}

/// The same frame after frame: allocates only while buffers grow.
///
///     trace_workspace<linear_array, physical<>> own;
///     iq_lines echoes;
///     for (;;) echoes = trace(exec::par_unseq, body, probe, at, model, scan, own, std::move(echoes));
///
/// @param own       kept from frame to frame
/// @param recycled  lines whose memory is reused
template <exec::policy Policy, transducer Probe, acoustic_model Model, tracer<Model> Tracer = straight_lines>
line_grid<typename Model::sample_type> trace(const Policy& policy, const scene& body, const Probe& probe,
                                             const pose& at, const Model& model, const acquisition& settings,
                                             trace_workspace_of<Probe, Model, Tracer>& own,
                                             line_grid<typename Model::sample_type> recycled, const Tracer& how = {}) {
    return detail::trace_frame(detail::any_policy{policy}, body, probe, at, model, settings, how, own,
                               std::move(recycled));
}

/// `trace` by one ray for each line and plane, through the trees of the objects.
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_beams(const Policy& policy, const scene& body, const Probe& probe,
                                                   const pose& at, const Model& model, const acquisition& settings) {
    return trace(policy, body, probe, at, model, settings, straight_lines{straight_lines::search::rays});
}

/// `trace` by slices alone: all lines of a plane lie in one slice of the scene, so each object is cut by it once, and the
/// segments are distributed over the lines.
///
/// Needs no tree: objects that have moved are cut by a linear pass. Several planes cost about as much as one. Watertight:
/// faces that share an edge are cut at exactly the same point of it, so each line enters and leaves a closed surface in turn.
/// Lines that are neither parallel nor from one point are traced as `trace_beams` does.
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_slice(const Policy& policy, const scene& body, const Probe& probe,
                                                   const pose& at, const Model& model, const acquisition& settings) {
    return trace(policy, body, probe, at, model, settings, straight_lines{straight_lines::search::slices});
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
