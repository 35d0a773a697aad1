#ifndef INSONIFY_TRACING_EMIT_TRACE_LINE_HPP
#define INSONIFY_TRACING_EMIT_TRACE_LINE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/emit/tracer.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI::detail {

/// Whether samples can be weighted and added.
template <class Sample>
inline constexpr bool is_average_v = std::same_as<Sample, float> || std::same_as<Sample, vec2>;

/// The task of a tracer: one line of one plane.
template <transducer Probe>
INSONIFY_FN line_task task_of(const detail::frame_view<Probe>& frame, const scene_view& scene, std::uint32_t number,
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

/// The samples of one line, in one grid or several: in every plane they are traced, weighted and added.
///
/// @param room    for the samples of all grids where there are several, or several planes
/// @param out_of  out_of(grid): the line in that grid; whatever it held is overwritten
/// @param trace   trace(plane, samples): adds what is received in a plane to samples that are 0, those of one grid after those of
///                another; false where it cannot
/// @return        false where `trace` did; the samples are then undefined
INSONIFY_VISITS
template <transducer Probe, class Sample, class OutOf, class Trace>
INSONIFY_FN bool sum_planes(const detail::frame_view<Probe>& frame, std::uint32_t number, std::size_t grids,
                            view<Sample> room, const OutOf& out_of, const Trace& trace) {
    for (std::size_t grid = 0; grid < grids; ++grid)
        for (Sample& sample : out_of(grid)) sample = Sample{};
    if (frame.planes == 1 && grids == 1) return trace(0U, out_of(0));
    if constexpr (is_average_v<Sample>)
        for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
            for (Sample& sample : room) sample = Sample{};
            if (!trace(plane, room)) return false;
            for (std::size_t grid = 0; grid < grids; ++grid) {
                const view<Sample> out = out_of(grid), own{room.data() + grid * out.size(), out.size()};
                if (frame.planes > 1)
                    add_weighted(own, frame.weights(number, plane), out);
                else
                    for (std::size_t k = 0; k < out.size(); ++k) out[k] = own[k];
            }
        }
    return true;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
