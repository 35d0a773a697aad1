#ifndef INSONIFY_TRACING_TRACE_HPP
#define INSONIFY_TRACING_TRACE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/aperture/aperture_shading.hpp>
#include <insonify/tracing/aperture/aperture_view.hpp>
#include <insonify/tracing/emit/tracer.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <concepts>
#include <utility>
#include <vector>

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
            throw usage_error{"straight_lines: `directions` is ", directions,
                              "; it must be 1 to 64 lines to each point, and 16 is usual"};
    }

    /// One line by a ray, without corrections for the width of the aperture: what a kernel calls. `trace` finds the
    /// layers of all lines instead.
    template <class Policy, acoustic_model Model>
    INSONIFY_FN bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                                view<typename Model::sample_type> out) const {
        const view<const layer> layers = detail::find_line(task.scene, task.line.frame, task.max_depth,
                                                           !detail::takes_normal_incidence<Model>, {}, scratch)
                                             .layers;
        if (layers.empty()) return false;
        task.apply(policy, model, layers, out);
        return true;
    }

    friend bool operator==(const straight_lines&, const straight_lines&) = default;
};

namespace detail {

/// The scratch of one thread on the host: doubles until the line fits.
class scratch_memory {
  public:
    scratch_memory() { line_.grow(); }

    line_scratch scratch() { return {line_.room(), branches_, branch_objects_, arrivals_}; }
    void grow() {
        line_.grow();
        branches_.resize(2 * branches_.size());
        branch_objects_.resize(2 * branch_objects_.size());
        arrivals_.resize(2 * arrivals_.size());
    }

    /// Calls attempt(scratch), in larger and larger memory, until it returns true.
    template <class Attempt>
    void fit(const Attempt& attempt) {
        for (line_scratch room = scratch(); !attempt(room); room = scratch()) grow();
    }

  private:
    line_memory line_{};
    std::vector<path_branch> branches_ = std::vector<path_branch>(32);
    std::vector<std::uint32_t> branch_objects_ = std::vector<std::uint32_t>(128);
    std::vector<path_arrival> arrivals_ = std::vector<path_arrival>(128);
};

/// The one loop over the lines and planes of a frame: what a line is traced in is made here alone, the scene as the
/// tracer sees it, with tissue as it is deformed now. Keeps its memory from frame to frame.
template <class Sample>
class line_driver {
  public:
    /// Finds the layers of all lines, computes what arrives through the aperture, and emits the echoes of every line.
    /// @param line_time  nanoseconds to emit one line of one plane, roughly
    /// @param sinks      grids that receive the samples; planes are weighted and added
    /// @param emit       emit(block, task, samples), whose line has its layers: adds to samples that are 0, those of one sink after those
    ///                   of another
    template <exec::policy Policy, acoustic_model Model, class Emit>
    void emit_lines(const Policy& policy, const scene& body, const probe_lines& probe, const frame_view& frame,
                    const Model& model, const straight_lines& how, float line_time,
                    view<line_grid<Sample>* const> sinks, const Emit& emit) {
        constexpr bool incident = !takes_normal_incidence<Model>;
        const any_policy<false> any{policy}; // for what does not depend on SIMD
        const view<const displacement_view> displaced = displacements_.compute(any, body, frame);
        const bool fan = finder_.assign(probe);
        bool shaded = false;
        if constexpr (states_arrivals<Model>)
            shaded = how.directions > 1 && fan &&
                     shading_.assign(probe.settings(), finder_.fan(), make_beam(probe.settings(), frame.depth));
        finder_.prepare(any, body, frame, how.search, incident || shaded, shaded ? 1 + how.directions : 1,
                        shaded ? shading_.beyond(frame) : outer_lines{});
        scene_view seen = finder_.scene_seen();
        seen.displacements = displaced;
        frame_gains gains{};
        if constexpr (states_arrivals<Model>)
            if (shaded) {
                finder_.find(any, frame, incident, layers_);
                const aperture_view shading = shading_.prepare(seen, frame, how.directions);
                shading_.compute(any, shading, model, layers_, finder_.slices());
                gains = shading.gains;
            }
        if (!shaded) {
            finder_.begin(frame, layers_);
            line_time += finder_.search_time();
        }
        sum_blocks(
            policy, frame, line_time, sinks,
            [&](std::size_t begin) {
                if (!shaded) finder_.find_block(frame, begin, incident, layers_);
            },
            [&](std::size_t block, std::uint32_t number, std::uint32_t plane, view<Sample> samples) {
                line_task task = task_of(frame, seen, number, plane, layers_.frame(number, plane));
                task.line.gains = gains.of_line(number, plane);
                task.line.layers = layers_(number, plane);
                emit(block, task, samples);
            });
        layers_.lines = frame.count();
    }

    /// The same for a tracer that makes the samples of a line itself.
    template <exec::policy Policy, acoustic_model Model, tracer<Model> Tracer>
    void trace_lines(const Policy& policy, const scene& body, const frame_view& frame, const Model& model,
                     const Tracer& how, line_grid<Sample>& lines) {
        constexpr float line_time = 1e6F;
        const any_policy<false> any{policy};
        scene_view seen = body.view_for_rays(any);
        seen.displacements = displacements_.compute(any, body, frame);
        layers_ = {};
        if (scratch_.size() < blocks_of(frame.count())) scratch_.resize(blocks_of(frame.count()));
        line_grid<Sample>* const sink = &lines;
        sum_blocks(
            policy, frame, line_time, {&sink, 1}, [](std::size_t) {},
            [&](std::size_t block, std::uint32_t number, std::uint32_t plane, view<Sample> samples) {
                scratch_[block].fit([&](line_scratch& scratch) {
                    for (Sample& sample : samples) sample = Sample{};
                    return how(policy, task_of(frame, seen, number, plane), model, scratch, samples);
                });
            });
    }

    /// Of the last frame whose lines were emitted.
    const line_layers& layers() const { return layers_; }

  private:
    template <exec::policy Policy, class BeginBlock, class Trace>
    void sum_blocks(const Policy& policy, const frame_view& frame, float line_time,
                    view<line_grid<Sample>* const> sinks, const BeginBlock& begin_block, const Trace& trace) {
        if (rooms_.size() < blocks_of(frame.count())) rooms_.resize(blocks_of(frame.count()));
        line_time *= static_cast<float>(frame.planes);
        exec::for_each_block(
            policy, frame.count(), lines_per_block, line_time, [&](std::size_t begin, std::size_t end) {
                const std::size_t block = begin / lines_per_block;
                begin_block(begin);
                std::vector<Sample>& room = rooms_[block];
                if (frame.planes > 1 || sinks.size() > 1) room.resize(sinks.size() * frame.samples);
                for (std::size_t i = begin; i < end; ++i) {
                    const auto number = static_cast<std::uint32_t>(i);
                    sum_planes(
                        frame, number, sinks.size(), view<Sample>{room},
                        [&](std::size_t grid) {
                            return view<Sample>{sinks[grid]->values.data() + i * frame.samples, frame.samples};
                        },
                        [&](std::uint32_t plane, view<Sample> samples) { trace(block, number, plane, samples); });
                }
            });
    }

    layer_finder finder_{};
    line_layers layers_{};
    aperture_shading shading_{};
    frame_displacements displacements_{};
    std::vector<std::vector<Sample>> rooms_{}; // of each block of lines
    std::vector<scratch_memory> scratch_{};    // of each block of lines
};

} // namespace detail

/// `trace`, frame after frame: holds tables, layers and memory, so that it allocates only while buffers grow.
template <acoustic_model Model = physical<>, tracer<Model> Tracer = straight_lines>
class line_tracer {
    static_assert(detail::model_check<Model>::passed);

  public:
    using sample_type = typename Model::sample_type; ///< that the model makes

    /// What the probe receives along its lines: see `insonify::trace`.
    /// @param recycled  lines whose memory is reused, whatever they held
    /// @throws usage_error, geometry_error  as `insonify::trace`
    template <exec::policy Policy, transducer Probe>
    line_grid<sample_type> trace(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                 const Model& model, const acquisition& scan, const Tracer& how = {},
                                 line_grid<sample_type> recycled = {}) {
        probe_.assign(probe);
        return trace_lines(detail::any_policy{policy}, body, at, model, scan, how, std::move(recycled));
    }

    /// What lies along the lines of the last frame; of tracers other than `straight_lines`, no lines.
    const line_layers& layers() const { return driver_.layers(); }

  private:
    template <class Policy>
    line_grid<sample_type> trace_lines(const Policy& policy, const scene& body, const pose& at, const Model& model,
                                       const acquisition& scan, const Tracer& how, line_grid<sample_type> recycled);

    detail::probe_lines probe_{};
    detail::frame_plan<Model> plan_{};
    detail::line_driver<sample_type> driver_{};
};

/// The work of `trace`, for the lines in `probe_`.
template <acoustic_model Model, tracer<Model> Tracer>
template <class Policy>
line_grid<typename line_tracer<Model, Tracer>::sample_type>
line_tracer<Model, Tracer>::trace_lines(const Policy& policy, const scene& body, const pose& at, const Model& model,
                                        const acquisition& scan, const Tracer& how, line_grid<sample_type> recycled) {
    const std::uint32_t samples = detail::check_acquisition(body, probe_.settings(), at, model, scan);
    if (scan.planes > 1 && !detail::is_average_v<sample_type>)
        throw usage_error{"trace: samples of this model's type cannot be averaged over `planes`; use one plane"};
    if constexpr (requires { how.check(); }) how.check();
    const detail::frame_view frame = plan_.view_of(policy, probe_, at, model, scan, samples, body.media());
    recycled.reshape(probe_.size(), samples, scan.depth);
    line_grid<sample_type>* const sink = &recycled;
    if constexpr (std::same_as<Tracer, straight_lines>)
        driver_.emit_lines(
            policy, body, probe_, frame, model, how, detail::nanoseconds_of<Model>() * static_cast<float>(samples),
            {&sink, 1},
            [&](std::size_t, const line_task& task, view<sample_type> out) { task.apply(policy, model, out); });
    else
        driver_.trace_lines(policy, body, frame, model, how, recycled);
    return recycled;
}

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
    return line_tracer<Model, Tracer>{}.trace(policy, body, probe, at, model, settings, how);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
