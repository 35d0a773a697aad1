#ifndef INSONIFY_TRACING_TRACE_LINES_HPP
#define INSONIFY_TRACING_TRACE_LINES_HPP

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/beam_table.hpp>
#include <insonify/tracing/check.hpp>
#include <insonify/tracing/each_line.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Straight lines: all crossings of each in order, found as `by` says, then the
/// model once along it.
///
/// @return `probe.lines` lines of `settings.samples` samples, of the type that
/// the model makes
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type>
trace_lines(const Policy &policy, search by, const scene &body,
            const Probe &probe, const pose &at, const Model &model,
            const acquisition &settings) {
  using sample_type = typename Model::sample_type;
  constexpr bool averages =
      std::same_as<sample_type, float> || std::same_as<sample_type, vec2>;
  const std::uint32_t samples =
      check_acquisition(body, probe, at, model, settings);
  if (settings.planes > 1 && !averages)
    throw usage_error{"trace: samples of this model's type cannot be averaged "
                      "over `planes`; use one plane"};
  const elevation_planes planes{beam_of(probe, settings.depth),
                                settings.planes};
  const beam_table beams =
      make_beam_table(policy, probe, settings.depth, planes, model);
  line_grid<sample_type> lines{probe.lines, samples, settings.depth};
  const float spacing = settings.depth / static_cast<float>(samples);
  const std::vector<float> weights =
      planes.weights_of_samples(samples, spacing);
  const float pulse_sigma = nominal_pulse(probe).sigma_z(probe.frequency);
  const auto fill = [&](std::uint32_t i, std::uint32_t plane,
                        const line_frame &frame, view<const layer> layers) {
    const traced_line traced{.layers = layers,
                             .media = body.media(),
                             .frequency = probe.frequency,
                             .places = body.places(),
                             .frame = frame,
                             .beam = beams.of_line(i),
                             .pulse_sigma = pulse_sigma};
    sample_type *line = lines.values.data() + std::size_t{i} * samples;
    if (planes.count() == 1) {
      model(policy, traced, spacing, view<sample_type>{line, samples});
      return;
    }
    if constexpr (averages) {
      std::vector<sample_type> slice(samples);
      model(policy, traced, spacing, view<sample_type>{slice});
      const float *weight = weights.data() + std::size_t{plane} * samples;
      for (std::uint32_t k = 0; k < samples; ++k)
        line[k] += weight[k] * slice[k];
    }
  };
  line_workspace found;
  for_each_line(policy, by, body, probe, at, planes,
                reach_of(model, settings.depth, body.media()), found, fill);
  return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
