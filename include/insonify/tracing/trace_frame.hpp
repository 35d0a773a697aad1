#ifndef INSONIFY_TRACING_TRACE_FRAME_HPP
#define INSONIFY_TRACING_TRACE_FRAME_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/any_policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/check.hpp>
#include <insonify/tracing/frame_displacements.hpp>
#include <insonify/tracing/frame_plan.hpp>
#include <insonify/tracing/scratch_memory.hpp>
#include <insonify/tracing/trace_line.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The state that a tracer prepares for a frame; the tracer itself if it prepares none.
template <class Tracer>
concept prepares_frames = requires {
    typename Tracer::frame_state;
};

template <class Tracer>
struct tracer_memory {}; // nothing to keep
template <prepares_frames Tracer>
struct tracer_memory<Tracer> {
    typename Tracer::frame_state state{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

/// Tables and buffers of `trace`, kept so that it allocates only while buffers grow.
template <transducer Probe, acoustic_model Model, class Tracer>
struct trace_workspace_of {
    detail::frame_plan<Probe, Model> plan{};                               ///< tables
    detail::tracer_memory<Tracer> tracing{};                               ///< of the tracer
    detail::frame_displacements displacements{};                           ///< of tissue that is deformed
    std::vector<detail::scratch_memory> scratch{};                         ///< for each block of lines
    std::vector<std::vector<typename Model::sample_type>> plane_samples{}; ///< for each block of lines
};

namespace detail {

/// Prepares the tracer of a frame and traces its lines, blocks of them on the policy's threads. What a line is traced in is
/// made here alone: the scene as the tracer sees it, with tissue as it is deformed now.
/// @param model_time   of one line of one plane, nanoseconds, roughly
/// @param trace_block  called as (const scene_view&, const Tracer&, begin, end) for the lines from `begin` to `end`, where the
///                     tracer is that of the block if it prepares frames
template <exec::policy Policy, transducer Probe, acoustic_model Model, class Tracer, class TraceBlock>
void trace_blocks(const Policy& policy, const scene& body, const frame_view<Probe>& frame, const Model& model,
                  const Tracer& how, float model_time, trace_workspace_of<Probe, Model, Tracer>& own,
                  const TraceBlock& trace_block) {
    const std::size_t blocks = (frame.probe.lines + lines_per_block - 1) / lines_per_block;
    if (own.scratch.size() < blocks) own.scratch.resize(blocks);
    if (own.plane_samples.size() < blocks) own.plane_samples.resize(blocks);
    const view<const displacement_view> displacements = own.displacements.compute(policy, body, frame);
    if constexpr (prepares_frames<Tracer>) {
        auto& state = own.tracing.state;
        how.prepare(policy, body, frame, model, view<scratch_memory>{own.scratch}, state);
        scene_view scene = state.prepared_scene();
        scene.displacements = displacements;
        const float line_time = (model_time + state.search_time()) * static_cast<float>(frame.planes);
        exec::for_each_block(
            policy, frame.probe.lines, lines_per_block, line_time,
            [&](std::size_t begin, std::size_t end) { trace_block(scene, state.of_block(begin), begin, end); });
    } else {
        scene_view scene = body.view_for_rays(policy);
        scene.displacements = displacements;
        exec::for_each_block(policy, frame.probe.lines, lines_per_block, 1e6F,
                             [&](std::size_t begin, std::size_t end) { trace_block(scene, how, begin, end); });
    }
}

/// Traces a frame: every line by the same function.
/// @param lines  memory that is reused, whatever it held
template <exec::policy Policy, transducer Probe, acoustic_model Model, tracer<Model> Tracer>
line_grid<typename Model::sample_type> trace_frame(const Policy& policy, const scene& body, const Probe& probe,
                                                   const pose& at, const Model& model, const acquisition& scan,
                                                   const Tracer& how, trace_workspace_of<Probe, Model, Tracer>& own,
                                                   line_grid<typename Model::sample_type> lines) {
    using sample_type = typename Model::sample_type;
    const std::uint32_t samples = check_acquisition(body, probe, at, model, scan);
    if (scan.planes > 1 && !is_average_v<sample_type>)
        throw usage_error{"trace: samples of this model's type cannot be averaged over `planes`; use one plane"};
    if constexpr (requires { how.check(); }) how.check();
    const frame_view<Probe> frame = own.plan.view_of(policy, probe, at, model, scan, samples, body.media());
    lines.reshape(probe.lines, samples, scan.depth);
    const float model_time = nanoseconds_of<Model>() * static_cast<float>(samples);
    trace_blocks(policy, body, frame, model, how, model_time, own,
                 [&](const scene_view& scene, const auto& tracer, std::size_t begin, std::size_t end) {
                     scratch_memory& memory = own.scratch[begin / lines_per_block];
                     std::vector<sample_type>& plane_samples = own.plane_samples[begin / lines_per_block];
                     if (frame.planes > 1) plane_samples.resize(samples);
                     for (std::size_t i = begin; i < end; ++i) {
                         const view<sample_type> out{lines.values.data() + i * samples, samples};
                         memory.fit([&](line_scratch& scratch) {
                             return trace_line(policy, frame, scene, tracer, model, static_cast<std::uint32_t>(i),
                                               scratch, view<sample_type>{plane_samples}, out);
                         });
                     }
                 });
    return lines;
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
