#ifndef INSONIFY_ACOUSTICS_LAYER_HPP
#define INSONIFY_ACOUSTICS_LAYER_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/pose.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// A stretch of one object along a line. Consecutive layers touch; the last one ends where the line does.
///
/// Two neighbours of equal media have equal `medium`: no interface lies between them.
struct layer {
    float begin = 0;            ///< metres from the face of the probe
    float end = 0;              ///< metres from the face of the probe
    std::uint32_t medium = 0;   ///< index into the media of the line
    std::uint32_t object = ~0U; ///< id of the object, ~0 for the background
    float cosine = 1;           ///< of the angle of incidence on the surface at `begin`; 1 on the first layer
    vec2 tilt{0, 0};            ///< radians between beam and normal there: within the slice plane, and out of it
    std::uint32_t place = 0;    ///< index into the places of the line: where the object is
};

/// Where a line runs in the world. Axes of length 1; the slice plane is normal to `elevation`.
struct line_frame {
    vec3 origin{0, 0, 0};    ///< on the face of the probe, metres
    vec3 along{0, 0, 1};     ///< the way of the sound
    vec3 elevation{0, 1, 0}; ///< out of the slice
};

/// The probe's beam at one depth of a line, as far as a model needs it.
struct beam_sample {
    float fnumber = 2;           ///< within the slice plane
    float elevation_fnumber = 4; ///< out of it
    float lateral_sigma = 0;     ///< metres, of the Gaussian that `convolve` will apply across the lines; 0: none
    float line_spacing = 0;      ///< metres to the next line
    float incoherent = 1;        ///< what keeps the level of independent echoes through that Gaussian and the planes
    vec2 alike{0, 0}; ///< m^2: mean square distance between what they have in common, across the lines and the planes
    float surface_incoherent = 1; ///< the same of the diffuse echoes of surfaces
    vec2 surface_alike{0, 0};     ///< m^2: as `alike`, of the diffuse echoes of surfaces
    float independent = 1;        ///< the same of echoes that have nothing in common
};

/// Beam samples for equal parts of the displayed depth, from the face on.
struct line_beam {
    view<const beam_sample> samples{}; ///< from the face on
    float spacing = 1;                 ///< metres
    view<const float> plane_offsets{}; ///< metres out of the slice plane
    view<const float> plane_weights{}; ///< for each sample those of all planes; together 1

    /// The beam at a displayed depth, metres; the default one where none was made.
    INSONIFY_FN beam_sample at(float depth) const {
        if (samples.empty()) return {};
        return samples[index(depth)];
    }

    /// What the planes leave of echoes whose depth changes by `slope` metres a metre out of the slice: the sum of their
    /// weights, each as high on a pulse of deviation `sigma` and turned by as much phase as its depth is off.
    INSONIFY_FN float across_the_planes(float depth, float slope, float sigma, float phase_per_metre) const {
        if (plane_offsets.empty() || slope == 0) return 1;
        const float* weights = plane_weights.first + index(depth) * plane_offsets.size();
        float sum = 0;
        for (std::size_t i = 0; i < plane_offsets.size(); ++i) {
            const float deeper = slope * plane_offsets[i], sigmas = deeper / sigma;
            sum += weights[i] * std::exp(-0.5F * sigmas * sigmas) * std::cos(phase_per_metre * deeper);
        }
        return std::fabs(sum);
    }

  private:
    INSONIFY_FN std::size_t index(float depth) const {
        return static_cast<std::size_t>(clamped(depth / spacing, 0, static_cast<float>(samples.size() - 1)));
    }
};

/// One line as an acoustic model sees it: what it runs through, where, and with what beam.
struct traced_line {
    view<const layer> layers{}; ///< from the face on, without gaps
    view<const medium> media{}; ///< of the scene, the background first
    float frequency = 0;        ///< hertz
    view<const pose> places{};  ///< object to world: of the background (the world itself), then of the objects
    line_frame frame{};         ///< where it runs
    line_beam beam{};           ///< empty for models without `covariance`
    float pulse_sigma = 0; ///< metres of displayed depth, of the Gaussian that `convolve` will apply along the line
    float height = 0;      ///< metres out of the slice plane that the line stands for, where there are several planes
};

} // namespace insonify::inline INSONIFY_ABI
#endif
