#ifndef INSONIFY_TRACING_SLICE_HPP
#define INSONIFY_TRACING_SLICE_HPP

#include <insonify/tracing/trace_lines.hpp>

namespace insonify::inline INSONIFY_ABI {

/// `trace` by cutting the scene: all lines of a slice lie in one plane, so each object is cut by it once, and the
/// segments are handed out to the lines.
///
/// Needs no tree: objects whose trees wait (`scene::update`) are cut by a linear pass. Several planes cost about what
/// one does. Watertight: faces that share an edge are cut in the very same point of it, so each line crosses a closed
/// surface in and out by turns. Lines that are neither parallel nor from one point are traced as `trace_beams` does.
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_slice(const Policy& policy, const scene& body, const Probe& probe,
                                                   const pose& at, const Model& model, const acquisition& settings) {
    return trace_lines(exec::any_policy{policy}, search::slices, body, probe, at, model, settings);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
