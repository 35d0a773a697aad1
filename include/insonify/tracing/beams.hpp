#ifndef INSONIFY_TRACING_BEAMS_HPP
#define INSONIFY_TRACING_BEAMS_HPP

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/scene/line_layers.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/beam_table.hpp>
#include <insonify/tracing/check.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Beam `line` of a probe that stands in the world as `at` says.
template <transducer Probe>
INSONIFY_FN ray world_beam(const Probe& probe, const pose& at, float line) {
    const ray local = probe.beam(line);
    return {.origin = at.point(local.origin), .direction = at.direction(local.direction)};
}

/// Finds what every line of a probe runs through, down to `reach` metres, in each of its slices:
/// visit(line, plane, frame, layers), the planes of one line in order and by one thread.
template <exec::policy Policy, transducer Probe, class Visit>
void for_each_line(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                   const elevation_planes& planes, float reach, const Visit& visit) {
    const vec3 elevation = at.direction({0, 1, 0});
    exec::for_each_block(policy, probe.lines, 8, [&](std::size_t begin, std::size_t end) {
        line_crossings found;
        std::vector<layer> layers;
        for (std::size_t i = begin; i < end; ++i)
            for (std::uint32_t plane = 0; plane < planes.count(); ++plane) {
                ray beam = world_beam(probe, at, static_cast<float>(i));
                beam.origin += planes.offset(plane) * elevation;
                const line_frame frame{beam.origin, beam.direction, elevation};
                find_crossings(body, beam, reach, found);
                stack_layers(body, frame, reach, found, layers);
                visit(static_cast<std::uint32_t>(i), plane, frame, view<const layer>{layers});
            }
    });
}

/// One ray a line and slice: all its crossings in order, then the model once along the line.
///
/// @return `probe.lines` lines of `settings.samples` samples, of the type that the model makes
/// @throws usage_error, geometry_error  as `check_acquisition`; for several planes where samples cannot be averaged
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_beams(const Policy& policy, const scene& body, const Probe& probe,
                                                   const pose& at, const Model& model, const acquisition& settings) {
    using sample_type = typename Model::sample_type;
    constexpr bool averages = std::same_as<sample_type, float> || std::same_as<sample_type, vec2>;
    const std::uint32_t samples = check_acquisition(body, probe, at, model, settings);
    if (settings.planes > 1 && !averages)
        throw usage_error{"trace: samples of this model's type cannot be averaged over `planes`; use one plane"};
    const elevation_planes planes{beam_of(probe, settings.depth), settings.planes};
    const beam_table beams = make_beam_table(policy, probe, settings.depth, planes, model);
    line_grid<sample_type> lines{probe.lines, samples, settings.depth};
    const float spacing = settings.depth / static_cast<float>(samples);
    const std::vector<float> weights = planes.weights_of_samples(samples, spacing);
    const float pulse_sigma = nominal_pulse(probe).sigma_z(probe.frequency);
    const auto fill = [&](std::uint32_t i, std::uint32_t plane, const line_frame& frame, view<const layer> layers) {
        const traced_line traced{.layers = layers,
                                 .media = body.media(),
                                 .frequency = probe.frequency,
                                 .places = body.places(),
                                 .frame = frame,
                                 .beam = beams.of_line(i),
                                 .pulse_sigma = pulse_sigma};
        sample_type* line = lines.values.data() + std::size_t{i} * samples;
        if (planes.count() == 1) {
            model(policy, traced, spacing, view<sample_type>{line, samples});
            return;
        }
        if constexpr (averages) {
            std::vector<sample_type> slice(samples);
            model(policy, traced, spacing, view<sample_type>{slice});
            const float* weight = weights.data() + std::size_t{plane} * samples;
            for (std::uint32_t k = 0; k < samples; ++k) line[k] += weight[k] * slice[k];
        }
    };
    for_each_line(policy, body, probe, at, planes, reach_of(model, settings.depth, body.media()), fill);
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
