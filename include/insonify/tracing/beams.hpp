#ifndef INSONIFY_TRACING_BEAMS_HPP
#define INSONIFY_TRACING_BEAMS_HPP

#include <insonify/tracing/trace_lines.hpp>

namespace insonify::inline INSONIFY_ABI {

/// `trace` by one ray a line and slice, through the trees of the objects.
/// @throws usage_error, geometry_error  as `trace`, and where a tree of the scene waits
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_beams(const Policy& policy, const scene& body, const Probe& probe,
                                                   const pose& at, const Model& model, const acquisition& settings) {
    return trace_lines(exec::any_policy{policy}, search::rays, body, probe, at, model, settings);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
