#ifndef INSONIFY_TRACING_STRAIGHT_LINES_HPP
#define INSONIFY_TRACING_STRAIGHT_LINES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/line_grid.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/aperture_shading.hpp>
#include <insonify/tracing/cut_normals.hpp>
#include <insonify/tracing/frame_plan.hpp>
#include <insonify/tracing/slice_finder.hpp>
#include <insonify/tracing/tracer.hpp>
#include <algorithm>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What `straight_lines` keeps between frames: see `straight_lines::prepare`.
class straight_frame;

namespace detail {

/// The lines of one block: crossings with some objects come from slices, with the others from rays. Trivially copyable.
struct block_tracer {
    slice_finder::block_view slices{};    ///< crossings of the lines of the block
    view<const std::uint8_t> is_sliced{}; ///< of each object, by rank; empty: none is
    bool any_rays = true;                 ///< some objects are not sliced
    aperture_shading::gains_view gains{}; ///< corrections for the width of the aperture
    kept_layers::kept_view known{}; ///< layers by plane and line of the block, where these have been found already
    std::uint32_t lines = 0;        ///< of the block

    template <class Policy, acoustic_model Model>
    INSONIFY_FN bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                                view<typename Model::sample_type> out) const {
        const view<const layer> layers = layers_of<Model>(task, scratch);
        if (layers.empty()) return false;
        seen(task).apply(policy, model, layers, out);
        return true;
    }

    /// The layers of a line; none where the scratch is too small.
    template <acoustic_model Model>
    INSONIFY_FN view<const layer> layers_of(const line_task& task, line_scratch& scratch) const {
        if (!known.empty()) return known[std::size_t{task.plane} * lines + task.number % lines_per_block];
        if (!find(task, scratch.found)) return {};
        return stack_layers(task.scene, task.line.frame, task.max_depth, scratch.found, scratch.layers,
                            !takes_normal_incidence<Model>());
    }
    /// The task with the corrections for the width of the aperture.
    INSONIFY_FN line_task seen(line_task task) const {
        task.line.gains = gains.of_line(task.number, task.plane);
        return task;
    }

    INSONIFY_FN bool find(const line_task& task, line_crossings& found) const {
        const ray beam = task.beam();
        if (is_sliced.empty()) return find_crossings(task.scene, beam, task.max_depth, found);
        found.clear();
        slices.find(task.number, task.plane, [&](const crossing& one) {
            if (task.scene.objects[one.rank].box.contains(beam.origin)) found.inside.toggle(one.rank);
            if (one.distance <= task.max_depth) found.add(one);
        });
        if (any_rays) add_crossings(task.scene, beam, task.max_depth, is_sliced, found);
        found.sort();
        return found.complete();
    }
};

} // namespace detail

/// Straight lines: finds all crossings of each line in order, then applies the model once along it.
///
/// All lines of a plane lie in one slice of the scene. An object is cut by the slices once and the segments are distributed
/// over the lines, or a ray is traced for each line, whichever is faster for the object. Both find the same crossings,
/// except on lines within rounding error of a vertex or an edge.
struct straight_lines {
    /// How crossings are found.
    enum class search {
        best,   ///< for each object whichever is faster
        rays,   ///< one ray for each line and plane, through the trees
        slices, ///< by slices, which need no trees; rays where the lines are neither parallel nor from one point
    };
    enum search search = search::best; ///< how crossings are found
    std::uint32_t directions = 16;     ///< in which lines are traced to each point, 1 to 64; 1: only the straight one.
                                       ///< With several planes, each uses a quarter as many, at least 2

    using frame_state = straight_frame; ///< what is kept between frames

    /// @throws usage_error  for a number of directions out of range
    void check() const {
        if (directions < 1 || directions > detail::aperture_shading::max_directions)
            throw usage_error{"straight_lines: `directions` is " + std::to_string(directions) +
                              "; it must be 1 to 64 lines to each point, and 16 is usual"};
    }

    /// Cuts the scene where that pays; `trace` calls it once for each frame.
    template <exec::policy Policy, transducer Probe, acoustic_model Model>
    void prepare(const Policy& policy, const scene& body, const frame_view<Probe>& frame, const Model& model,
                 view<detail::scratch_memory> scratch, frame_state& state) const;

    /// One line by rays; needs no preparation.
    template <class Policy, acoustic_model Model>
    INSONIFY_FN bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                                view<typename Model::sample_type> out) const {
        return detail::block_tracer{}(policy, task, model, scratch, out);
    }

    friend bool operator==(const straight_lines&, const straight_lines&) = default;
};

/// The state of `straight_lines` for one frame.
class straight_frame {
  public:
    /// As `straight_lines::prepare`.
    template <exec::policy Policy, transducer Probe, acoustic_model Model>
    void prepare(const Policy& policy, const scene& body, const frame_view<Probe>& frame, const Model& model,
                 view<detail::scratch_memory> scratch, straight_lines how) {
        using search = enum straight_lines::search;
        const view<const elevation_plane> planes{frame.plane, frame.planes};
        const bool fan = slices_.assign(frame.probe);
        shaded_ = detail::states_arrivals<Model> && how.directions > 1 && fan &&
                  shading_.assign(frame.probe, slices_.fan(), beam_of(frame.probe, frame.depth));
        const std::uint32_t directions = shaded_ ? 1 + how.directions : 1;
        sliced_ = false;
        if (how.search != search::rays && fan) {
            scene_ = body.view_for_slices(policy);
            sliced_ = slices_.choose(scene_, frame.at, planes, how.search == search::slices, directions);
        }
        if (sliced_) {
            slices_.cut(policy, scene_, frame.at, planes, frame.max_depth, shaded_,
                        shaded_ ? shading_.beyond(frame) : detail::outer_lines{});
            normals_.compute(policy, scene_, slices_.segments());
        } else {
            scene_ = body.view_for_rays(policy);
        }
        const std::size_t blocks = (frame.probe.lines + detail::lines_per_block - 1) / detail::lines_per_block;
        if (sliced_ && blocks_.size() < blocks) blocks_.resize(blocks);
        if constexpr (detail::states_arrivals<Model>)
            if (shaded_)
                shading_.compute(
                    policy, scene_, frame, model, how.directions, slices_, sliced_,
                    [&](std::size_t begin) { return found_block(begin); }, scratch);
    }

    /// What `prepare` has seen of the scene.
    const scene_view& prepared_scene() const { return scene_; }

    /// The tracer of the lines from `begin` on; blocks may be prepared on different threads.
    detail::block_tracer of_block(std::size_t begin) {
        if (!shaded_) return found_block(begin);
        detail::block_tracer block = tracer_of_found(begin); // `aperture_shading::compute` has found every block
        block.gains = shading_.view_of();
        block.known = shading_.layers_of_block(begin / detail::lines_per_block);
        block.lines =
            static_cast<std::uint32_t>(std::min<std::size_t>(detail::lines_per_block, block.gains.lines - begin));
        return block;
    }

    /// Nanoseconds to find the crossings of a line, roughly.
    float search_time() const {
        const auto objects = static_cast<float>(scene_.objects.size());
        const float by_rays = !sliced_ || slices_.leaves_rays() ? 300 + 20 * min(objects, 64) : 0.0F;
        return by_rays + (sliced_ ? slices_.search_time() : 0.0F);
    }

  private:
    detail::block_tracer found_block(std::size_t begin) {
        if (sliced_) slices_.find_block(begin, blocks_[begin / detail::lines_per_block]);
        return tracer_of_found(begin);
    }
    detail::block_tracer tracer_of_found(std::size_t begin) const {
        if (!sliced_) return {};
        return {slices_.view_of(blocks_[begin / detail::lines_per_block]), slices_.chosen(), slices_.leaves_rays()};
    }

    bool sliced_ = false, shaded_ = false;
    detail::aperture_shading shading_{};
    scene_view scene_{};
    detail::slice_finder slices_{};
    detail::cut_normals normals_{};
    std::vector<detail::slice_finder::block_crossings> blocks_{};
};

template <exec::policy Policy, transducer Probe, acoustic_model Model>
void straight_lines::prepare(const Policy& policy, const scene& body, const frame_view<Probe>& frame,
                             const Model& model, view<detail::scratch_memory> scratch, frame_state& state) const {
    state.prepare(policy, body, frame, model, scratch, *this);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
