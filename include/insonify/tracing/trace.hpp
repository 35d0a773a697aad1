#ifndef INSONIFY_TRACING_TRACE_HPP
#define INSONIFY_TRACING_TRACE_HPP

#include <insonify/tracing/beams.hpp>
#include <insonify/tracing/slice.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What the probe receives along its lines.
///
///     iq_lines echoes = trace(exec::par_unseq, body, linear_array{}, at, physical{}, {.depth = 40_mm});
///     scan_lines paper = trace(exec::par_unseq, body, linear_array{}, at, law2011{}, {.depth = 40_mm});
///
/// @param at     probe to world: x lateral, y elevation, z depth
/// @param model  what happens at interfaces and between them: `physical`, `law2011`, or your own (`acoustic_model`)
/// @return `probe.lines` lines of `settings.samples` samples, of the type that the model makes
/// @throws usage_error     for an unbuilt scene, senseless settings, absurd sizes
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace(const Policy& policy, const scene& body, const Probe& probe,
                                             const pose& at, const Model& model, const acquisition& settings) {
    return trace_lines(exec::any_policy{policy}, search::best, body, probe, at, model, settings);
}

/// The same frame after frame: allocates nothing after the first.
///
///     trace_workspace<linear_array, physical<>> own;
///     iq_lines echoes;
///     for (;;) echoes = trace(exec::par_unseq, body, probe, at, model, scan, own, std::move(echoes));
///
/// @param own       kept from frame to frame
/// @param recycled  lines whose memory is used again
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace(const Policy& policy, const scene& body, const Probe& probe,
                                             const pose& at, const Model& model, const acquisition& settings,
                                             trace_workspace<Probe, Model>& own,
                                             line_grid<typename Model::sample_type> recycled) {
    return trace_lines(exec::any_policy{policy}, search::best, body, probe, at, model, settings, own,
                       std::move(recycled));
}

} // namespace insonify::inline INSONIFY_ABI
#endif
