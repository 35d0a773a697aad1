#ifndef INSONIFY_TRACING_BEAMS_HPP
#define INSONIFY_TRACING_BEAMS_HPP

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/scene/line_layers.hpp>
#include <insonify/tracing/check.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Beam `line` of a probe that stands in the world as `at` says.
template <transducer Probe>
INSONIFY_FN ray world_beam(const Probe& probe, const pose& at, float line) {
    const ray local = probe.beam(line);
    return {.origin = at.point(local.origin), .direction = at.direction(local.direction)};
}

/// One ray a line: all its crossings in order, then the model once along the line.
///
/// @return `probe.lines` lines of `settings.samples` samples, of the type that the model makes
/// @throws usage_error, geometry_error  as `check_acquisition`
template <exec::policy Policy, transducer Probe, acoustic_model Model>
line_grid<typename Model::sample_type> trace_beams(const Policy& policy, const scene& body, const Probe& probe,
                                                   const pose& at, const Model& model, const acquisition& settings) {
    const std::uint32_t samples = check_acquisition(body, probe, at, model, settings);
    line_grid<typename Model::sample_type> lines{probe.lines, samples, settings.depth};
    const float spacing = settings.depth / static_cast<float>(samples);
    const float reach = reach_of(model, settings.depth, body.media());
    exec::for_each_block(policy, probe.lines, 8, [&](std::size_t begin, std::size_t end) {
        line_crossings found;
        std::vector<layer> layers;
        for (std::size_t i = begin; i < end; ++i) {
            const ray line = world_beam(probe, at, static_cast<float>(i));
            find_crossings(body, line, reach, found);
            stack_layers(body, line.direction, reach, found, layers);
            model(policy, traced_line{layers, body.media(), probe.frequency}, spacing,
                  view<typename Model::sample_type>{lines.values.data() + i * samples, samples});
        }
    });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
