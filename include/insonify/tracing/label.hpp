#ifndef INSONIFY_TRACING_LABEL_HPP
#define INSONIFY_TRACING_LABEL_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/execution/any_policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/scene/line_layers.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/check.hpp>
#include <insonify/tracing/each_line.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What the depth of a sample means.
enum class grid {
    geometric, ///< metres along the line: where things are
    displayed, ///< c0 t / 2, t being the travel time there and back: where a picture by `physical` shows them
};

/// How deep to look, how finely, and along which depths.
struct label_settings {
    float depth = 0.08F;                             ///< metres, of the grid
    std::uint32_t samples = 0;                       ///< along each line; 0: as many as a picture by `physical` has
    insonify::grid grid = insonify::grid::geometric; ///< what a depth means
};

/// The depths of a label grid, for the tracer: it makes no samples itself.
struct label_axis {
    insonify::grid grid = insonify::grid::geometric; ///< what a depth means

    /// Where the caller leaves it open: two for each deviation of the pulse, a multiple of 64.
    INSONIFY_LAZY std::uint32_t samples(float depth, float frequency) const {
        return samples_for(depth, pulse{}.sigma_z(frequency));
    }

    /// How far lines are to be followed, metres: where sound is fast, things below `depth` are displayed above it.
    INSONIFY_LAZY float reach(float depth, view<const medium> media) const {
        float fastest = display_speed;
        for (const medium& m : media) fastest = greater(fastest, m.sound_speed);
        return grid == grid::displayed ? depth * (fastest / display_speed) : depth;
    }

    /// Metres of the grid a metre of the medium: c0 / c where displayed.
    float scale(const medium& m) const { return grid == grid::displayed ? displayed_stretch(m) : 1.0F; }
};

/// Which samples of a line stand in one of its layers: `first` up to, but without, `last`.
struct label_stretch {
    float begin = 0;       ///< of the layer, in metres of the grid
    float scale = 1;       ///< metres of the grid a metre of the layer
    std::size_t first = 0; ///< sample
    std::size_t last = 0;  ///< sample after the last one
};

/// Lays the layers of one line on a grid: visit(i, stretch) for layer i, from the face down.
///
/// Each sample, at (k + 1/2) * spacing metres, is in one stretch; the last layer takes all that are left.
template <class Visit>
void for_each_stretch(view<const layer> layers, view<const medium> media, const label_axis& axis, std::uint32_t samples,
                      float spacing, const Visit& visit) {
    std::size_t next = 0;
    float begin = 0;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const float scale = axis.scale(media[layers[i].medium]);
        const float end = begin + scale * (layers[i].end - layers[i].begin);
        const float before_end = clamped(std::ceil(end / spacing - 0.5F), 0, static_cast<float>(samples));
        const std::size_t last = i + 1 == layers.size() ? samples : static_cast<std::size_t>(before_end);
        visit(i, label_stretch{begin, scale, next, last});
        next = last;
        begin = end;
    }
}

/// `label`, compiled once for all policies.
template <transducer Probe>
label_lines find_labels(const exec::any_policy<false>& policy, const scene& body, const Probe& probe, const pose& at,
                        const label_settings& settings) {
    const label_axis axis{settings.grid};
    const std::uint32_t samples =
        check_acquisition(body, probe, at, axis, {.depth = settings.depth, .samples = settings.samples});
    const float spacing = settings.depth / static_cast<float>(samples);
    label_lines labels{probe.lines, samples, settings.depth};
    const auto fill_line = [&](std::uint32_t line, std::uint32_t, const line_frame&, view<const layer> layers) {
        label_id* const values = labels.values.data() + std::size_t{line} * samples;
        for_each_stretch(layers, body.media(), axis, samples, spacing, [&](std::size_t i, const label_stretch& part) {
            std::fill(values + part.first, values + part.last, layers[i].object);
        });
    };
    const elevation_planes middle{beam_of(probe, settings.depth), 1};
    line_workspace found;
    for_each_line(policy, search::best, body, probe, at, middle, axis.reach(settings.depth, body.media()), angles::skip,
                  found, 0.1F * static_cast<float>(samples), fill_line);
    return labels;
}

/// Which object each sample lies in: its id, and `background_label` outside all.
///
///     label_lines truth = label(exec::par, body, probe, at, {.depth = 40_mm, .samples = 400});
///     bool in_bone = truth(line, sample) == static_cast<label_id>(bone);
///
/// Of nested and overlapping objects the one that gives the medium, as `scene` says. What the middle slice meets: beams
/// are straight lines here, without thickness.
/// @param at  probe to world: x lateral, y elevation, z depth
/// @return `probe.lines` lines of `settings.samples` samples
/// @throws usage_error     for an unbuilt scene, senseless settings, absurd sizes
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
label_lines label(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                  const label_settings& settings) {
    return find_labels(exec::any_policy<false>{policy}, body, probe, at, settings);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
