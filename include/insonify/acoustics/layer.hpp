#ifndef INSONIFY_ACOUSTICS_LAYER_HPP
#define INSONIFY_ACOUSTICS_LAYER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/tissue/displacement_view.hpp>
#include <insonify/tissue/structure.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Where a line meets a surface of the object that it is in; by default there is none, or it belongs to the object on
/// its other side.
struct object_surface {
    float cosine = 0;     ///< of the angle of incidence
    vec3 normal{0, 0, 0}; ///< in the world, on either side, of length 1
};

/// The segment of a line inside one object. Consecutive layers are adjacent, and the last one extends to the end of the
/// line.
///
/// Adjacent layers with the same `medium` have no interface between them.
struct layer {
    float begin = 0;            ///< metres from the probe face
    float end = 0;              ///< metres from the probe face
    std::uint32_t medium = 0;   ///< index into the media of the line
    std::uint32_t object = ~0U; ///< id of the object, ~0 for the background
    float cosine = 1;           ///< of the angle of incidence on the surface at `begin`; 1 on the first layer
    /// Tangents of the angles between that surface's forward normal and the line, within the slice plane and out of it.
    vec2 slope{0, 0};
    /// Second derivatives of that surface's depth, 1/m, positive where it recedes to both sides: across the line in the
    /// slice plane, out of it, and mixed.
    vec3 curvature{0, 0, 0};
    float roughness = -1;       ///< of that surface: rms height, metres; below 0: the larger one of the two media
    std::uint32_t place = 0;    ///< index into the poses of the line
    object_surface own_begin{}; ///< at `begin`
    object_surface own_end{};   ///< at `end`
    vec2 moved{0, 0};           ///< of `begin` and `end` since the first pulse of a train, metres along the line
};

/// The coordinate frame of a line in the world; axes of length 1.
struct line_frame {
    vec3 origin{0, 0, 0};    ///< on the probe face, metres
    vec3 along{0, 0, 1};     ///< propagation direction
    vec3 elevation{0, 1, 0}; ///< normal of the slice plane
    float tilt = 0;          ///< metres out of the slice plane per metre along the line, in a tilted elevation plane
    vec3 steering{0, 0, 0};  ///< of a steered line: `along` less its `steered::scatterer_axis`

    /// Displacement per metre of the line, longer than 1 where it tilts. A tilt changes the points of a line, not the
    /// propagation: distances, times and angles of incidence are those along `along`.
    INSONIFY_FN vec3 path() const { return along + tilt * elevation; }
    /// The point at a distance, metres along the line.
    INSONIFY_FN vec3 at(float distance) const { return origin + distance * path(); }
};

/// The receive aperture of a line, as a function of displayed depth.
struct line_aperture {
    view<const float> fnumbers{}; ///< in the slice plane, at equal steps of displayed depth
    float spacing = 1;            ///< length of a step, metres of displayed depth
    float elevation_fnumber = 4;  ///< out of the slice plane
    float height = 0; ///< of the tissue that contributes to an echo, out of the slice plane, metres; 0: unknown
    view<const float> strips{};        ///< what `strip` interpolates, metres: in the middle of the same steps
    view<const float> phase_spreads{}; ///< what `phase_spread` interpolates, rad/m: in the middle of the same steps

    /// F-number in the slice plane at a displayed depth, metres; 2 if none is given.
    INSONIFY_FN float fnumber(float depth) const {
        if (fnumbers.empty()) return 2;
        return fnumbers[static_cast<std::size_t>(clamp(depth / spacing, 0, static_cast<float>(fnumbers.size() - 1)))];
    }
    /// Half height s of the strip of the beam that the line stands for, out of the slice plane, metres: the power of
    /// the strip falls as exp(-y^2 / s^2). 0 if none is given: the line stands for itself alone.
    INSONIFY_FN float strip(float depth) const { return interpolated(strips, depth); }
    /// How fast the phases of the scatterers of one place come apart as the line moves out of the slice: rms, rad/m.
    /// See `elevation_planes::phase_spread`. 0 if none is given: `height` alone decides.
    INSONIFY_FN float phase_spread(float depth) const { return interpolated(phase_spreads, depth); }

  private:
    INSONIFY_FN float interpolated(view<const float> values, float depth) const {
        if (values.empty()) return 0;
        const detail::table_place at{depth / spacing - 0.5F, values.size()};
        return values[at.above] + at.part * (values[at.below] - values[at.above]);
    }
};

/// Corrections for the width of the aperture at one point of a line: see `aperture_gains`.
struct aperture_gain {
    float surfaces = 1; ///< factor on the amplitude of the echoes of surfaces
    float speckle = 1;  ///< factor on the amplitude of speckle
    float deeper = 0;   ///< metres by which echoes are displayed deeper
};

/// Factors on the amplitude that arrives at a point and returns along the line alone, at equal steps of depth: sound
/// reaches it from the whole width of the aperture, also past an obstacle. Amplitudes below `min_amplitude` are taken
/// as `min_amplitude`. Empty: the line alone counts.
struct aperture_gains {
    static constexpr float min_amplitude = 1e-12F; ///< smallest amplitude that a factor belongs to

    view<const aperture_gain> at_steps{}; ///< element k at a distance of (k + 1) * spacing from the probe face
    float spacing = 1;                    ///< metres along the line

    /// The amplitude that arrives through the whole aperture. @param factor  `surfaces` or `speckle` of a gain
    INSONIFY_FN float amplitude(float along_line, float factor) const {
        return at_steps.empty() ? along_line : max(along_line, min_amplitude) * factor;
    }
};

namespace detail {

/// The `aperture_gains` of one layer, where it lay at the first pulse of a train. Steps within `clearance` of a surface
/// are left out, since rounding decides on which side they lie. At the first surface of the layer, those of the layer
/// above apply.
struct layer_gains {
    static constexpr float clearance = 2e-6F; ///< from the surfaces, metres
    /// Layers thinner than this, in metres of displayed depth, take the gains of the layer above, unless that is in
    /// shadow: what arrives in a needle comes through it, not past it. In steel that is 3.8 mm.
    static constexpr float thinnest = 1e-3F;

    view<const aperture_gain> at_steps{}; ///< those within the layer
    float first = 0;                      ///< where the first of them lies, metres
    float per_step = 1;                   ///< one over their spacing, 1/m
    aperture_gain before{};               ///< the last one above the layer

    /// At a distance from the probe face, metres.
    INSONIFY_FN aperture_gain at(float distance) const {
        if (at_steps.empty()) return before;
        const table_place place{(distance - first) * per_step, at_steps.size()};
        const aperture_gain &a = at_steps[place.above], &b = at_steps[place.below];
        return {a.surfaces + place.part * (b.surfaces - a.surfaces), a.speckle + place.part * (b.speckle - a.speckle),
                a.deeper + place.part * (b.deeper - a.deeper)};
    }
    INSONIFY_FN float min_deeper() const {
        float smallest = at_steps.empty() ? before.deeper : at_steps[0].deeper;
        for (const aperture_gain& gain : at_steps) smallest = min(smallest, gain.deeper);
        return smallest;
    }
    /// At the end of the layer.
    INSONIFY_FN const aperture_gain& last() const { return at_steps.empty() ? before : at_steps[at_steps.size() - 1]; }

    /// Those of the next layer, of a medium.
    INSONIFY_FN layer_gains next(const aperture_gains& all, const layer& here, const medium& m) const {
        layer_gains own{.per_step = 1 / all.spacing, .before = last()};
        const auto steps_above = [&](float distance) {
            return static_cast<std::size_t>(clamp(distance * own.per_step, 0, static_cast<float>(all.at_steps.size())));
        };
        const bool is_lit_above = own.before.surfaces > 0.5F && own.before.surfaces < 2;
        const float from = here.begin - here.moved.x, to = here.end - here.moved.y;
        if (is_lit_above && (to - from) * displayed_stretch(m) < thinnest) return own;
        const std::size_t begin = steps_above(from + clearance), end = steps_above(to - clearance);
        own.at_steps = {all.at_steps.data() + begin, begin < end ? end - begin : 0};
        own.first = static_cast<float>(begin + 1) * all.spacing;
        return own;
    }
};

} // namespace detail

/// One traced line, the input of an acoustic model: its layers, frame, pulse and aperture.
struct traced_line {
    view<const layer> layers{};                ///< from the probe face on, without gaps
    view<const medium> media{};                ///< of the scene, the background first
    float frequency = 0;                       ///< of the carrier, hertz
    view<const pose> places{};                 ///< object to world: of the background (identity), then of the objects
    view<const placed_structure> structures{}; ///< of the medium of each place; empty: none has any
    line_frame frame{};                        ///< in the world
    line_aperture aperture{};                  ///< of the receiving array
    std::uint32_t plane = 0;                   ///< of the frame's elevation planes, the middle one first
    float pulse_sigma = 0;  ///< standard deviation of the pulse envelope, metres of displayed depth; 0: of 2.5 cycles
    float bandwidth = 0;    ///< fractional, of the pulse under attenuation; 0: by `pulse_sigma`, or a single frequency
    aperture_gains gains{}; ///< corrections for the width of the aperture
    std::uint32_t frame_number = 0;                ///< speckle of flowing media depends on it
    view<const displacement_view> displacements{}; ///< of the tissue of each place; empty: all of it is at rest

    /// How the tissue of a place is displaced; null where it is at rest.
    INSONIFY_FN const displacement_view* displacement(std::uint32_t place) const {
        return place < displacements.size() && !displacements[place].nodes.empty() ? &displacements[place] : nullptr;
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
