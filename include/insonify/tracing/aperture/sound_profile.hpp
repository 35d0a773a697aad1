#ifndef INSONIFY_TRACING_APERTURE_SOUND_PROFILE_HPP
#define INSONIFY_TRACING_APERTURE_SOUND_PROFILE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <array>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// What arrives at one depth of a line.
struct sound_at_depth {
    float amplitude = 0;     ///< one way
    float shown = 0;         ///< displayed depth, metres
    std::uint32_t place = 0; ///< what the depth lies in: see `layer::place`
};

/// What arrives along a line, at equal steps of depth: element k at (k + 1) * spacing.
struct sound_profile {
    static constexpr std::uint32_t steps = 64;

    std::array<sound_at_depth, steps> at{};

    /// @param line     with its layers
    /// @param spacing  of the steps, metres
    template <class Model>
    INSONIFY_FN void compute(const traced_line& line, const Model& model, float spacing) {
        vec2 both_ways[steps];
        model.arrivals(line, spacing, view<vec2>{both_ways, steps});
        std::size_t i = 0;
        for (std::uint32_t k = 0; k < steps; ++k) {
            // A step on a surface lies behind it, as in `physical::arrivals`.
            while (i + 1 < line.layers.size() && line.layers[i].end <= static_cast<float>(k + 1) * spacing) ++i;
            at[k] = {std::sqrt(max(both_ways[k].x, aperture_gains::least)), both_ways[k].y, line.layers[i].place};
        }
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
