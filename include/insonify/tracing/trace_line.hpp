#ifndef INSONIFY_TRACING_TRACE_LINE_HPP
#define INSONIFY_TRACING_TRACE_LINE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/frame_plan.hpp>
#include <insonify/tracing/tracer.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI::detail {

/// Whether samples can be weighted and added.
template <class Sample>
inline constexpr bool is_average_v = std::same_as<Sample, float> || std::same_as<Sample, vec2>;

/// The task of a tracer: one line of one plane.
template <transducer Probe>
INSONIFY_FN line_task task_of(const frame_view<Probe>& frame, const scene_view& scene, std::uint32_t number,
                              std::uint32_t plane) {
    return {.scene = scene,
            .line = {.media = scene.media,
                     .frequency = frame.probe.frequency,
                     .places = scene.places,
                     .structures = scene.structures,
                     .frame = frame.line(number, plane),
                     .aperture = frame.aperture,
                     .plane = plane,
                     .pulse_sigma = frame.pulse_sigma,
                     .bandwidth = frame.bandwidth,
                     .frame_number = frame.frame_number,
                     .displacements = scene.displacements},
            .number = number,
            .plane = plane,
            .planes = frame.planes,
            .max_depth = frame.max_depth,
            .spacing = frame.spacing,
            .kernels = frame.kernels.of_line(number, plane)};
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

/// All the work of one line, from crossings to samples: every plane is traced, weighted and added.
///
/// @param plane_samples  room for the samples of one plane where there are several
/// @param out            the samples of the line; whatever they held is overwritten
/// @return               false where the scratch is too small; the samples are then undefined
template <class Policy, transducer Probe, class Tracer, acoustic_model Model>
INSONIFY_FN bool trace_line(const Policy& policy, const frame_view<Probe>& frame, const scene_view& scene,
                            const Tracer& tracer, const Model& model, std::uint32_t number, line_scratch& scratch,
                            view<typename Model::sample_type> plane_samples, view<typename Model::sample_type> out) {
    using sample_type = typename Model::sample_type;
    for (sample_type& sample : out) sample = sample_type{};
    for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
        const line_task task = task_of(frame, scene, number, plane);
        if (frame.planes == 1) return tracer(policy, task, model, scratch, out);
        if constexpr (is_average_v<sample_type>) {
            for (sample_type& sample : plane_samples) sample = sample_type{};
            if (!tracer(policy, task, model, scratch, plane_samples)) return false;
            const float* weight = frame.weights(number, plane);
            add_weighted(plane_samples, weight, out);
        }
    }
    return true;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
