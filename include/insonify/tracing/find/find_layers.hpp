#ifndef INSONIFY_TRACING_FIND_FIND_LAYERS_HPP
#define INSONIFY_TRACING_FIND_FIND_LAYERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/policy.hpp>
#include <insonify/tracing/find/layer_finder.hpp>
#include <insonify/tracing/plan/check.hpp>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// `find_layers`, again and again: keeps its memory.
class layer_search {
  public:
    /// @param max_depth  how far the lines are followed, metres
    /// @param incident   whether to compute how they meet surfaces
    /// @return           valid until the next call
    template <exec::policy Policy, transducer Probe>
    line_layers& operator()(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                            const acquisition& scan, float max_depth, bool incident) {
        frame_lines<Probe> frame{
            .probe = probe, .at = at, .depth = scan.depth, .max_depth = max_depth, .planes = scan.planes};
        const elevation_planes planes{beam_of(probe, scan.depth), scan.planes, scan.depth, lines_follow_depth(probe)};
        for (std::uint32_t i = 0; i < scan.planes; ++i) frame.plane[i] = planes[i];
        finder_.assign(probe);
        finder_.prepare(policy, body, frame, line_search::best);
        finder_.find(policy, frame, incident, found_);
        return found_;
    }

  private:
    layer_finder finder_{};
    line_layers found_{};
};

} // namespace detail

/// What lies along the lines of a probe, in every elevation plane, down to `scan.depth` metres along them.
///
///     const line_layers found = find_layers(exec::par_unseq, body, probe, at, {.depth = 40_mm, .planes = 5});
///
/// The first stage of a frame: `trace` computes echoes from the same layers, and `label`, `ground_truth`, `add_near_field` and
/// `automatic_tgc` read them. `scan.samples` has no effect.
/// @param at  probe to world: x lateral, y elevation, z depth
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
line_layers find_layers(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                        const acquisition& scan) {
    detail::check_lines(body, probe, at, scan.depth, "find_layers");
    detail::check_planes(scan.planes, "find_layers");
    return std::move(
        detail::layer_search{}(detail::any_policy<false>{policy}, body, probe, at, scan, scan.depth, true));
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
