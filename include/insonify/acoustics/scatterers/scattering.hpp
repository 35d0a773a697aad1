#ifndef INSONIFY_ACOUSTICS_SCATTERERS_SCATTERING_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_SCATTERING_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/tissue/displacement_view.hpp>
#include <insonify/tissue/structure.hpp>
#include <concepts>

/// Scatterer fields: position and amplitude of the scatterers along a line. Scatterers are fixed in the coordinates of
/// the object, so that speckle moves with the tissue.
namespace insonify::inline INSONIFY_ABI {

/// A line in coordinates of an object.
struct material_line {
    vec3 origin{0, 0, 0};        ///< metres
    vec3 along{0, 0, 1};         ///< metres travelled per metre of the line: `line_frame::path`
    vec3 elevation{0, 1, 0};     ///< normal of the slice plane
    std::uint32_t object = ~0U;  ///< id of the object, ~0 for the background
    float scatterer_density = 0; ///< of the medium, per m^3; 0: the field's default
    float height = 0;            ///< of the tissue that contributes to an echo, along `elevation`, metres; 0: unknown
    std::uint32_t plane = 0;     ///< of the frame's elevation planes
    float tilt = 0;              ///< see `line_frame::tilt`; wave fronts are not tilted
    float fnumber = 2;           ///< of the receiving aperture
    const placed_structure* structure = nullptr;     ///< of the medium; null: none
    vec2 surfaces{0, 0};                             ///< metres along the line at which its layer begins and ends
    object_surface own_begin{};                      ///< of the layer, in coordinates of the object
    object_surface own_end{};                        ///< likewise
    vec3 steering{0, 0, 0};                          ///< see `line_frame::steering`
    bool flowing = false;                            ///< the medium flows
    std::uint32_t frame_number = 0;                  ///< where the medium flows; 0 elsewhere
    const displacement_view* displacement = nullptr; ///< of the tissue from now to rest; null: it is at rest
    const line_aperture* aperture = nullptr;         ///< that receives; null: unknown
    vec2 displayed{0, 1}; ///< displayed depth of its origin, metres, and per metre of the line

    /// See `line_aperture::phase_spread`, at a distance along the line, metres.
    INSONIFY_FN float phase_spread(float distance) const {
        return aperture == nullptr ? 0.0F : aperture->phase_spread(displayed.x + distance * displayed.y);
    }
    /// The point at a distance along the line, metres.
    INSONIFY_FN vec3 at(float distance) const { return origin + distance * along; }

    /// The coordinates in which the fibres of its structure are straight; null where they are so already.
    INSONIFY_FN const fibre_chart* chart() const {
        return structure == nullptr || structure->chart.empty() ? nullptr : &structure->chart;
    }
    /// Where tissue that is now at a point was at rest.
    INSONIFY_FN vec3 rest(vec3 now) const { return displacement == nullptr ? now : displacement->rest(now); }
    /// Whether a straight line may have been a curve there, or may be one in the coordinates of its structure.
    INSONIFY_FN bool bends() const { return displacement != nullptr || chart() != nullptr; }
};

/// A line in coordinates of an object.
/// @param place  pose of the object: object to world
INSONIFY_FN inline material_line in_object(const line_frame& line, const pose& place, std::uint32_t object,
                                           float scatterer_density = 0) {
    return {place.local_point(line.origin), place.local_direction(line.path()), place.local_direction(line.elevation),
            object, scatterer_density};
}

/// Spacing of scatterers along a line, metres: 1.25 standard deviations of the pulse envelope. Wherever the pulse lies
/// between them, it sums their power within 2 exp(-pi^2 / 1.25^2) = 0.4 % of that of continuous tissue (Poisson's
/// summation formula).
/// @param pulse_sigma  standard deviation of the pulse envelope, metres
INSONIFY_FN constexpr float scatterer_spacing(float pulse_sigma) { return 1.25F * pulse_sigma; }
/// The most in media that flow, metres: an eighth of the wavelength c0 / f0. Blood that is sheared consists of layers
/// thinner than the pulse.
INSONIFY_FN constexpr float scatterer_spacing_in_flow(float frequency) { return display_speed / (8 * frequency); }

/// Scatterers at equal steps: scatterer i lies first + i * step metres along the line.
struct scatterer_run {
    float first = 0;                  ///< position of the first one, metres along the line
    float step = 0;                   ///< metres
    std::uint32_t count = 0;          ///< number of scatterers
    const float* real = nullptr;      ///< real parts of the amplitudes
    const float* imaginary = nullptr; ///< imaginary parts
    vec2 slope{0, 0};                 ///< change of depth per metre across the line: in the slice plane, out of it
};

/// A scatterer field. `scatter(line, begin, end, spacing, emit)` calls emit(run) for the scatterers of one object
/// between two distances along a line, metres. Their mean power is 1 per `spacing` metres of undeformed tissue, whose
/// places are those of `material_line::rest`.
///
/// `covariance(distance, angle)` is the covariance of the amplitudes on two lines in the slice plane, 1 at distance 0,
/// by their distance in metres and the angle between them in radians. In elevation planes it is the same by their
/// distance, unless the field is independent from plane to plane and has a member `independent_planes`.
template <class Field>
concept scattering_field = requires(const Field& field, const material_line& line, float x,
                                    void (*emit)(const scatterer_run&)) {
    field.scatter(line, x, x, x, emit);
    { field.covariance(x, x) } -> std::convertible_to<float>;
};

/// No speckle.
struct no_scatterers {
    /// Emits nothing.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line&, float, float, float, Emit&&) const {}
    /// 0.
    INSONIFY_FN float covariance(float, float) const { return 0; }

    friend bool operator==(const no_scatterers&, const no_scatterers&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
