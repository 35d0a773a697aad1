#ifndef INSONIFY_TRACING_STRAIGHT_LINES_HPP
#define INSONIFY_TRACING_STRAIGHT_LINES_HPP

#include <insonify/scene/scene.hpp>
#include <insonify/tracing/frame_plan.hpp>
#include <insonify/tracing/slice_finder.hpp>
#include <insonify/tracing/tracer.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What `straight_lines` keeps between frames: see `straight_lines::prepare`.
class straight_frame;

namespace detail {

/// Makes layers of the crossings that were found and lets the model write the samples.
template <class Policy, acoustic_model Model>
INSONIFY_FN bool finish_line(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                             view<typename Model::sample_type> out) {
    const view<const layer> layers = stack_layers(task.scene, task.line.frame, task.max_depth, scratch.found,
                                                  scratch.layers, !takes_normal_incidence<Model>());
    if (layers.empty()) return false;
    task.apply(policy, model, layers, out);
    return true;
}

/// The lines of one block: crossings with some objects come from slices, with the others from rays. Trivially copyable.
struct block_tracer {
    slice_finder::block_view slices{};    ///< crossings of the lines of the block
    view<const std::uint8_t> is_sliced{}; ///< of each object, by rank; empty: none is
    bool any_rays = true;                 ///< some objects are not sliced

    template <class Policy, acoustic_model Model>
    INSONIFY_FN bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                                view<typename Model::sample_type> out) const {
        return find(task, scratch.found) && finish_line(policy, task, model, scratch, out);
    }

    INSONIFY_FN bool find(const line_task& task, line_crossings& found) const {
        const ray beam = task.beam();
        if (is_sliced.empty()) return find_crossings(task.scene, beam, task.max_depth, found);
        found.clear();
        slices.find(task.number, task.plane, [&](const crossing& one) {
            if (task.scene.objects[one.rank].box.contains(beam.origin)) found.inside.toggle(one.rank);
            if (one.distance <= task.max_depth) found.add(one);
        });
        if (any_rays)
            task.scene.boxes.for_each_hit({beam.origin, beam.direction, 0, task.max_depth}, [&](const hit& at) {
                if (is_sliced[at.primitive] == 0)
                    add_crossings(task.scene.objects[at.primitive], at.primitive, beam, task.max_depth, found);
            });
        found.sort();
        return found.complete();
    }
};

} // namespace detail

/// Straight lines: every crossing of each line in order, then the model once along it.
///
/// All lines of a plane lie in one slice of the scene. An object is cut by the slices once and the segments are shared out
/// over the lines, or a ray is traced for each line, whichever is faster for the object; both find the same crossings, but
/// for lines within rounding error of a vertex or an edge.
struct straight_lines {
    /// How crossings are found.
    enum class search {
        best,   ///< for each object whichever is faster
        rays,   ///< one ray for each line and plane, through the trees
        slices, ///< by slices, which need no trees; rays where the lines are neither parallel nor from one point
    };
    enum search search = search::best; ///< how crossings are found

    using frame_state = straight_frame; ///< what is kept between frames

    /// Cuts the scene where that pays; `trace` calls it once for each frame.
    template <exec::policy Policy, transducer Probe>
    void prepare(const Policy& policy, const scene& body, const frame_view<Probe>& frame, frame_state& state) const;

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
    template <exec::policy Policy, transducer Probe>
    void prepare(const Policy& policy, const scene& body, const frame_view<Probe>& frame, straight_lines how) {
        using search = enum straight_lines::search;
        const view<const float> offsets{frame.plane_offset, frame.planes};
        sliced_ = false;
        if (how.search != search::rays && slices_.assign(frame.probe)) {
            scene_ = body.view_for_slices(policy);
            sliced_ = slices_.choose(scene_, frame.at, offsets, how.search == search::slices);
        }
        if (sliced_)
            slices_.cut(policy, scene_, frame.at, offsets, frame.max_depth);
        else
            scene_ = body.view_for_rays(policy);
        const std::size_t blocks = (frame.probe.lines + detail::lines_per_block - 1) / detail::lines_per_block;
        if (sliced_ && blocks_.size() < blocks) blocks_.resize(blocks);
    }

    /// The scene as prepared.
    const scene_view& scene() const { return scene_; }

    /// Finds the crossings of the lines from `begin` on; blocks may be prepared on different threads.
    auto of_block(std::size_t begin) {
        if (!sliced_) return detail::block_tracer{};
        detail::slice_finder::block_crossings& own = blocks_[begin / detail::lines_per_block];
        slices_.find_block(begin, own);
        return detail::block_tracer{slices_.view_of(own), slices_.chosen(), slices_.leaves_rays()};
    }

    /// Nanoseconds to find the crossings of a line, roughly.
    float search_time() const {
        const auto objects = static_cast<float>(scene_.objects.size());
        const float by_rays = !sliced_ || slices_.leaves_rays() ? 300 + 20 * min(objects, 64) : 0.0F;
        return by_rays + (sliced_ ? slices_.search_time() : 0.0F);
    }

  private:
    bool sliced_ = false;
    scene_view scene_{};
    detail::slice_finder slices_{};
    std::vector<detail::slice_finder::block_crossings> blocks_{};
};

template <exec::policy Policy, transducer Probe>
void straight_lines::prepare(const Policy& policy, const scene& body, const frame_view<Probe>& frame,
                             frame_state& state) const {
    state.prepare(policy, body, frame, *this);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
