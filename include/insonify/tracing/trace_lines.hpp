#ifndef INSONIFY_TRACING_TRACE_LINES_HPP
#define INSONIFY_TRACING_TRACE_LINES_HPP

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/execution/any_policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/beam_table.hpp>
#include <insonify/tracing/check.hpp>
#include <insonify/tracing/each_line.hpp>
#include <cstring>

namespace insonify::inline INSONIFY_ABI {

/// What `trace` keeps from frame to frame: handed back with the lines of the frame before, nothing is allocated.
template <transducer Probe, acoustic_model Model>
struct trace_workspace {
    line_workspace lines{};                                         ///< crossings and layers
    kept_beam_table<Probe, Model> beams{};                          ///< the beam at each depth
    std::vector<std::vector<typename Model::sample_type>> slices{}; ///< a line of a slice, for each block of lines
    std::vector<float> weights{};                                   ///< of the planes, by sample
};

/// Sets all samples to 0.
template <class Sample>
void clear(view<Sample> samples) {
    if constexpr (std::same_as<Sample, float> || std::same_as<Sample, vec2>)
        std::memset(samples.first, 0, samples.size() * sizeof(Sample));
    else
        std::fill(samples.begin(), samples.end(), Sample{});
}

/// Straight lines: all crossings of each in order, found as `by` says, then the model once along it.
///
/// @param lines  memory that is used again, whatever it held
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_lines(const Policy& policy, search by, const scene& body,
                                                   const Probe& probe, const pose& at, const Model& model,
                                                   const acquisition& settings, trace_workspace<Probe, Model>& own,
                                                   line_grid<typename Model::sample_type> lines) {
    using sample_type = typename Model::sample_type;
    constexpr bool averages = std::same_as<sample_type, float> || std::same_as<sample_type, vec2>;
    const std::uint32_t samples = check_acquisition(body, probe, at, model, settings);
    if (settings.planes > 1 && !averages)
        throw usage_error{"trace: samples of this model's type cannot be averaged over `planes`; use one plane"};
    const elevation_planes planes{beam_of(probe, settings.depth), settings.planes};
    const beam_table& beams = own.beams(policy, probe, settings.depth, planes, model);
    const float spacing = settings.depth / static_cast<float>(samples);
    const float pulse_sigma = nominal_pulse(probe).sigma_z(probe.frequency);
    lines.reshape(probe.lines, samples, settings.depth);
    if (planes.count() > 1) planes.weights_of_samples(samples, spacing, own.weights);
    own.slices.resize(line_blocks(probe.lines));
    const auto fill = [&](std::uint32_t i, std::uint32_t plane, const line_frame& frame, view<const layer> layers) {
        const traced_line traced{.layers = layers,
                                 .media = body.media(),
                                 .frequency = probe.frequency,
                                 .places = body.places(),
                                 .frame = frame,
                                 .beam = beams.of_line(i),
                                 .pulse_sigma = pulse_sigma,
                                 .height = planes.height(plane)};
        const view<sample_type> line{lines.values.data() + std::size_t{i} * samples, samples};
        if (plane == 0) clear(line);
        if (planes.count() == 1) {
            model(policy, traced, spacing, line);
            return;
        }
        if constexpr (averages) {
            std::vector<sample_type>& slice = own.slices[i / lines_per_block];
            slice.resize(samples);
            clear(view<sample_type>{slice});
            model(policy, traced, spacing, view<sample_type>{slice});
            const float* weight = own.weights.data() + std::size_t{plane} * samples;
            for (std::uint32_t k = 0; k < samples; ++k) line[k] += weight[k] * slice[k];
        }
    };
    constexpr angles wanted = takes_normal_incidence<Model>() ? angles::skip : angles::find;
    for_each_line(policy, by, body, probe, at, planes, reach_of(model, settings.depth, body.media()), wanted, own.lines,
                  nanoseconds_of<Model>() * static_cast<float>(samples), fill);
    return lines;
}

/// The same, in memory of its own.
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_lines(const Policy& policy, search by, const scene& body,
                                                   const Probe& probe, const pose& at, const Model& model,
                                                   const acquisition& settings) {
    trace_workspace<Probe, Model> own;
    return trace_lines(policy, by, body, probe, at, model, settings, own, {});
}

} // namespace insonify::inline INSONIFY_ABI
#endif
