#ifndef INSONIFY_TRACING_EMIT_TRACER_HPP
#define INSONIFY_TRACING_EMIT_TRACER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/signal/kernel/compensated_echoes.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

namespace detail {
struct path_branch;
struct path_arrival;
} // namespace detail

/// Memory of fixed capacity in which one line is traced. If it is too small, the tracer returns false, and the line is
/// traced again with more.
struct line_scratch : line_room {
    view<detail::path_branch> branches{};  ///< room for paths that are yet to be followed
    view<std::uint32_t> branch_objects{};  ///< room for the ranks of the objects that contain them, branch after branch
    view<detail::path_arrival> arrivals{}; ///< room for where paths met surfaces
};

/// One line of one elevation plane: what a tracer is given.
struct line_task {
    scene_view scene{};             ///< all objects
    traced_line line{};             ///< as the model will see it; its layers where `straight_lines` has found them
    std::uint32_t number = 0;       ///< of the line
    float max_depth = 0;            ///< how far the line is to be followed, metres
    float spacing = 0;              ///< metres from sample to sample
    detail::line_kernels kernels{}; ///< of the stages that follow

    /// The line as a ray in the world; distances along it are those along the line, even if its plane is tilted.
    INSONIFY_FN ray beam() const { return {.origin = line.frame.origin, .direction = line.frame.path()}; }

    /// Writes emitted echoes, compensated so that later stages do not change their levels.
    INSONIFY_FN detail::compensated_echoes echoes(view<vec2> out) const {
        return {echo_line{out, spacing, line.frequency}, kernels, line.frequency, line.pulse_sigma};
    }

    /// Lets the model write the samples of this line, whose layers are known.
    template <class Policy, acoustic_model Model>
    INSONIFY_FN void apply(const Policy& policy, const Model& model, view<typename Model::sample_type> out) const {
        if constexpr (emits_echoes<Model>)
            model.emit(line, echoes(out));
        else
            model(policy, line, spacing, out);
    }
    /// The same with the layers that a tracer has found.
    template <class Policy, acoustic_model Model>
    INSONIFY_FN void apply(const Policy& policy, const Model& model, view<const layer> layers,
                           view<typename Model::sample_type> out) const {
        line_task known = *this;
        known.line.layers = layers;
        known.apply(policy, model, out);
    }
};

/// How sound travels: `straight_lines` (the default), `paths`, or one of your own. A tracer turns one line into
/// samples:
///
///     template <class Policy, acoustic_model Model>
///     INSONIFY_FN bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
///                                 view<typename Model::sample_type> out) const;
///
/// It adds to samples that start at 0 and returns false where the scratch is too small, and only then. One that finds
/// layers passes them to `task.apply`; one that needs no mesh may compute them from its own data. It must not throw. It
/// is called from many threads at once, and on a device where it is marked INSONIFY_FN.
template <class Tracer, class Model = physical<>>
concept tracer = acoustic_model<Model> && requires(const Tracer& trace_one, const line_task& task, const Model& model,
                                                   line_scratch& scratch, view<typename Model::sample_type> out) {
    { trace_one(exec::seq, task, model, scratch, out) } -> std::same_as<bool>;
};

} // namespace insonify::inline INSONIFY_ABI

namespace insonify::inline INSONIFY_ABI::detail {

/// Whether samples can be weighted and added.
template <class Sample>
inline constexpr bool is_average_v = std::same_as<Sample, float> || std::same_as<Sample, vec2>;

/// The task of a tracer: one line of one plane.
/// @param line  `frame.line(number, plane)`, as it is kept with the layers of the line
INSONIFY_FN inline line_task task_of(const frame_view& frame, const scene_view& scene, std::uint32_t number,
                                     std::uint32_t plane, const line_frame& line) {
    return {.scene = scene,
            .line = {.media = scene.media,
                     .frequency = frame.frequency,
                     .places = scene.places,
                     .structures = scene.structures,
                     .frame = line,
                     .aperture = frame.aperture,
                     .plane = plane,
                     .pulse_sigma = frame.pulse_sigma,
                     .bandwidth = frame.bandwidth,
                     .frame_number = frame.frame_number,
                     .displacements = scene.displacements},
            .number = number,
            .max_depth = frame.max_depth,
            .spacing = frame.spacing,
            .kernels = frame.kernels.of_line(number, plane)};
}
INSONIFY_FN inline line_task task_of(const frame_view& frame, const scene_view& scene, std::uint32_t number,
                                     std::uint32_t plane) {
    return task_of(frame, scene, number, plane, frame.line(number, plane));
}

/// Adds samples, each times a weight of its own: component by component, so that compilers vectorize it.
template <class Sample>
INSONIFY_FN void add_weighted(view<Sample> samples, const float* weights, view<Sample> sums) {
    constexpr std::size_t parts = sizeof(Sample) / sizeof(float);
    const auto* const from = reinterpret_cast<const float*>(samples.data());
    auto* const to = reinterpret_cast<float*>(sums.data());
    const std::size_t count = sums.size();
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t i = 0; i < parts; ++i) to[k * parts + i] += weights[k] * from[k * parts + i];
}

/// The samples of one line, in one grid or several: in every plane they are traced, weighted and added.
///
/// @param room    for the samples of all grids where there are several, or several planes
/// @param out_of  out_of(grid): the line in that grid; whatever it held is overwritten
/// @param trace   trace(plane, samples): adds what is received in a plane to samples that are 0, those of one grid
///                after those of another
INSONIFY_VISITS
template <class Sample, class OutOf, class Trace>
INSONIFY_FN INSONIFY_INLINE void sum_planes(const frame_view& frame, std::uint32_t number, std::size_t grids,
                                            view<Sample> room, const OutOf& out_of, const Trace& trace) {
    for (std::size_t grid = 0; grid < grids; ++grid)
        for (Sample& sample : out_of(grid)) sample = Sample{};
    if (frame.planes == 1 && grids == 1) return trace(0U, out_of(0));
    if constexpr (is_average_v<Sample>)
        for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
            for (Sample& sample : room) sample = Sample{};
            trace(plane, room);
            for (std::size_t grid = 0; grid < grids; ++grid) {
                const view<Sample> out = out_of(grid), own{room.data() + grid * out.size(), out.size()};
                if (frame.planes > 1)
                    add_weighted(own, frame.weights(number, plane), out);
                else
                    for (std::size_t k = 0; k < out.size(); ++k) out[k] = own[k];
            }
        }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
