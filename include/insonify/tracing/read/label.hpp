#ifndef INSONIFY_TRACING_READ_LABEL_HPP
#define INSONIFY_TRACING_READ_LABEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/physical.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <algorithm>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// Depth and sampling of labels, and the meaning of depth.
struct label_settings {
    /// What the depth of a sample means.
    enum class depth_grid {
        geometric, ///< metres along the line: where things are
        displayed, ///< c0 t / 2, where t is the travel time there and back: where a picture by `physical` shows them
    };
    float depth = 0.08F;                     ///< metres, of the grid
    std::uint32_t samples = 0;               ///< along each line; 0: as many as a picture by `physical` has
    depth_grid grid = depth_grid::geometric; ///< what a depth means
};

namespace detail {

/// The samples of a line that lie in one of its layers: `first` up to, but without, `last`.
struct label_stretch {
    float begin = 0;       ///< of the layer, in metres of the grid
    float scale = 1;       ///< metres of the grid a metre of the layer
    std::size_t first = 0; ///< sample
    std::size_t last = 0;  ///< sample after the last one
};

/// Checks the arguments of `label`. @return the number of samples of the grid: by default as many as echoes have
inline std::uint32_t check_labels(const scene& body, const probe_settings& probe, const pose& at,
                                  const label_settings& settings, const char* caller) {
    return check_acquisition(body, probe, at, physical<>{}, {.depth = settings.depth, .samples = settings.samples},
                             caller);
}

/// How far lines are followed, metres: fast media below `depth` are displayed above it.
inline float max_depth_of(const label_settings& settings, view<const medium> media) {
    float fastest = display_speed;
    for (const medium& m : media) fastest = max(fastest, m.sound_speed);
    return settings.grid == label_settings::depth_grid::displayed ? settings.depth * (fastest / display_speed)
                                                                  : settings.depth;
}

/// Maps the layers of a line to a grid: calls visit(i, stretch) for layer i, starting at the face.
///
/// Each sample, at (k + 1/2) * spacing metres, is in one stretch; the last layer takes all that are left.
template <class Visit>
void for_each_stretch(view<const layer> layers, view<const medium> media, label_settings::depth_grid grid,
                      std::size_t samples, float spacing, const Visit& visit) {
    std::size_t next = 0;
    float begin = 0;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const layer& here = layers[i];
        const bool displayed = grid == label_settings::depth_grid::displayed;
        const float scale = displayed ? displayed_stretch(media[here.medium]) : 1.0F;
        const float end = begin + scale * (here.end - here.begin);
        const float before_end = clamp(std::ceil(end / spacing - 0.5F), 0, static_cast<float>(samples));
        const std::size_t last = i + 1 == layers.size() ? samples : static_cast<std::size_t>(before_end);
        visit(i, label_stretch{begin, scale, next, last});
        next = last;
        begin = end;
    }
}

/// The layers that labels are read from: of one plane.
template <exec::policy Policy, transducer Probe>
const line_layers& layers_for_labels(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                     const label_settings& settings, bool incident, layer_search& search) {
    return search(policy, body, probe, at, {.depth = settings.depth}, max_depth_of(settings, body.media()), incident);
}

} // namespace detail

/// The object that each sample of lines lies in, whose layers have been found.
/// @param found     layers; those of the slice plane are read. The last layer of a line is taken to go on for ever:
///                  they must reach as deep as `settings` displays
/// @param settings  `samples` must not be 0
/// @param recycled  labels whose memory is reused
/// @throws usage_error  for a depth or a number of samples out of range
template <exec::policy Policy>
label_lines label(const Policy& policy, const line_layers& found, const label_settings& settings,
                  label_lines recycled = {}) {
    check_depth(settings.depth, "label");
    if (settings.samples == 0)
        throw usage_error{"label: `samples` is 0; give the number along each line of the layers"};
    const std::uint32_t samples = detail::checked_samples(found.lines, settings.samples, "label");
    recycled.reshape(found.lines, samples, settings.depth);
    const float spacing = settings.depth / static_cast<float>(samples);
    const auto line_time = 0.2F * static_cast<float>(samples);
    exec::for_each_in_blocks(policy, found.lines, detail::lines_per_block, line_time, [&](std::size_t line) {
        const view<const layer> layers = found(static_cast<std::uint32_t>(line));
        label_id* const out = recycled.values.data() + line * samples;
        const auto fill = [&](std::size_t i, const detail::label_stretch& part) {
            std::fill(out + part.first, out + part.last, layers[i].object);
        };
        detail::for_each_stretch(layers, found.media, settings.grid, samples, spacing, fill);
    });
    return recycled;
}

/// The object that each sample lies in: its id, and `background_label` outside all.
///
/// Of nested and overlapping objects the one that gives the medium, as `scene` says. Lines are straight and without
/// thickness: those of the middle plane.
/// @param at  probe to world: x lateral, y elevation, z depth
/// @return `probe.lines` lines of `settings.samples` samples
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
label_lines label(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                  const label_settings& settings) {
    const detail::any_policy<false> any{policy};
    const std::uint32_t samples = detail::check_labels(body, probe, at, settings, "label");
    detail::layer_search search;
    return label(any, detail::layers_for_labels(any, body, probe, at, settings, false, search),
                 {settings.depth, samples, settings.grid});
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
