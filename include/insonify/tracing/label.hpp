#ifndef INSONIFY_TRACING_LABEL_HPP
#define INSONIFY_TRACING_LABEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// Depth and sampling of labels, and the meaning of depth.
struct label_settings {
    /// What the depth of a sample means.
    enum class grid {
        geometric, ///< metres along the line: where things are
        displayed, ///< c0 t / 2, where t is the travel time there and back: where a picture by `physical` shows them
    };
    float depth = 0.08F;              ///< metres, of the grid
    std::uint32_t samples = 0;        ///< along each line; 0: as many as a picture by `physical` has
    enum grid grid = grid::geometric; ///< what a depth means
};

namespace detail {

/// The samples of a line that lie in one of its layers: `first` up to, but without, `last`.
struct label_stretch {
    float begin = 0;       ///< of the layer, in metres of the grid
    float scale = 1;       ///< metres of the grid a metre of the layer
    std::size_t first = 0; ///< sample
    std::size_t last = 0;  ///< sample after the last one
};

/// The depths of a label grid: what models of labels share.
struct label_axis {
    enum label_settings::grid grid = label_settings::grid::geometric;

    /// Default: two samples for each standard deviation of the pulse, a multiple of 64.
    std::uint32_t samples(float depth, float frequency) const { return samples_for(depth, pulse{}.sigma_z(frequency)); }

    /// How far lines are followed, metres: fast media below `depth` are displayed above it.
    float max_depth(float depth, view<const medium> media) const {
        float fastest = display_speed;
        for (const medium& m : media) fastest = max(fastest, m.sound_speed);
        return grid == label_settings::grid::displayed ? depth * (fastest / display_speed) : depth;
    }

    /// Maps the layers of a line to the grid: calls visit(i, stretch) for layer i, starting at the face.
    ///
    /// Each sample, at (k + 1/2) * spacing metres, is in one stretch; the last layer takes all that are left.
    template <class Visit>
    INSONIFY_FN void for_each_stretch(const traced_line& line, std::size_t samples, float spacing,
                                      const Visit& visit) const {
        std::size_t next = 0;
        float begin = 0;
        for (std::size_t i = 0; i < line.layers.size(); ++i) {
            const layer& here = line.layers[i];
            const bool displayed = grid == label_settings::grid::displayed;
            const float scale = displayed ? displayed_stretch(line.media[here.medium]) : 1.0F;
            const float end = begin + scale * (here.end - here.begin);
            const float before_end = clamp(std::ceil(end / spacing - 0.5F), 0, static_cast<float>(samples));
            const std::size_t last = i + 1 == line.layers.size() ? samples : static_cast<std::size_t>(before_end);
            visit(i, label_stretch{begin, scale, next, last});
            next = last;
            begin = end;
        }
    }
    friend bool operator==(const label_axis&, const label_axis&) = default;
};

/// A model whose samples are labels.
struct label_model : label_axis {
    using sample_type = label_id;
    static constexpr bool normal_incidence = true;
    static constexpr float nanoseconds = 0.1F;

    template <class Policy>
    INSONIFY_FN void operator()(const Policy&, const traced_line& line, float spacing, view<label_id> out) const {
        for_each_stretch(line, out.size(), spacing, [&](std::size_t i, const label_stretch& part) {
            for (std::size_t k = part.first; k < part.last; ++k) out[k] = line.layers[i].object;
        });
    }
    friend bool operator==(const label_model&, const label_model&) = default;
};

} // namespace detail

/// The object that each sample lies in: its id, and `background_label` outside all.
///
///     label_lines truth = label(exec::par, body, probe, at, {.depth = 40_mm, .samples = 400});
///     bool in_bone = truth(line, sample) == static_cast<label_id>(bone);
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
    return trace(detail::any_policy<false>{policy}, body, probe, at, detail::label_model{{settings.grid}},
                 {.depth = settings.depth, .samples = settings.samples});
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
