#ifndef INSONIFY_TRACING_TRACE_HPP
#define INSONIFY_TRACING_TRACE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/line_tracer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What the probe receives along its lines.
///
///     iq_lines echoes = trace(exec::par_unseq, body, linear_array{}, at, physical{}, {.depth = 40_mm});
///     scan_lines paper = trace(exec::par_unseq, body, linear_array{}, at, law2011{}, {.depth = 40_mm});
///     iq_lines bent = trace(exec::par_unseq, body, linear_array{}, at, physical{}, {.depth = 40_mm}, paths{});
///
/// Frame after frame, `line_tracer` does the same without allocations.
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
    return line_tracer<Probe, Model, Tracer>{}.trace(policy, body, probe, at, model, settings, how);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
