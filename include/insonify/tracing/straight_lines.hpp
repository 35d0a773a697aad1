#ifndef INSONIFY_TRACING_STRAIGHT_LINES_HPP
#define INSONIFY_TRACING_STRAIGHT_LINES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/aperture/aperture_view.hpp>
#include <insonify/tracing/emit/tracer.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// Straight lines: finds all crossings of each line in order, then applies the model once along it.
///
/// All lines of a plane lie in one slice of the scene. An object is cut by the slices once and the segments are
/// distributed over the lines, or a ray is traced for each line, whichever is faster for the object. Both find the same
/// crossings, except on lines within rounding error of a vertex or an edge.
struct straight_lines {
    line_search search = line_search::best; ///< how crossings are found
    std::uint32_t directions = 16; ///< in which lines are traced to each point, 1 to 64; 1: only the straight one.
                                   ///< With several planes, each uses a quarter as many, at least 2

    /// @throws usage_error  for a number of directions out of range
    void check() const {
        if (directions < 1 || directions > detail::max_aperture_directions)
            throw usage_error{"straight_lines: `directions` is " + std::to_string(directions) +
                              "; it must be 1 to 64 lines to each point, and 16 is usual"};
    }

    /// One line by a ray, without corrections for the width of the aperture: what a kernel calls. `trace` finds the
    /// layers of all lines instead.
    template <class Policy, acoustic_model Model>
    INSONIFY_FN bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                                view<typename Model::sample_type> out) const {
        if (!find_crossings(task.scene, task.beam(), task.max_depth, scratch.found)) return false;
        const view<const layer> layers = stack_layers(task.scene, task.line.frame, task.max_depth, scratch.found,
                                                      scratch.layers, !detail::takes_normal_incidence<Model>());
        if (layers.empty()) return false;
        task.apply(policy, model, layers, out);
        return true;
    }

    friend bool operator==(const straight_lines&, const straight_lines&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
