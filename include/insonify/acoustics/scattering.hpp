#ifndef INSONIFY_ACOUSTICS_SCATTERING_HPP
#define INSONIFY_ACOUSTICS_SCATTERING_HPP

#include <insonify/acoustics/layer.hpp>
#include <concepts>

/// The texture of tissue: where along a line its scatterers are, and how strong. They are anchored in the coordinates of
/// the object, so that speckle follows the tissue.
namespace insonify::inline INSONIFY_ABI {

/// A line in an object's own coordinates. Axes of length 1.
struct material_line {
    vec3 origin{0, 0, 0};        ///< metres
    vec3 along{0, 0, 1};         ///< the way of the sound
    vec3 elevation{0, 1, 0};     ///< out of the slice
    std::uint32_t object = ~0U;  ///< its id; ~0: the background
    float scatterer_density = 0; ///< of the medium: see there

    /// The point so many metres along it.
    INSONIFY_FN vec3 at(float distance) const { return origin + distance * along; }
};

/// A line of the world in the coordinates of an object that stands at `place`.
INSONIFY_FN inline material_line in_object(const line_frame& line, const pose& place, std::uint32_t object,
                                           float scatterer_density = 0) {
    return {place.local_point(line.origin), place.local_direction(line.along), place.local_direction(line.elevation),
            object, scatterer_density};
}

/// Scatterers at equal steps: number i stands at first + i * step metres along the line.
struct scatterer_run {
    float first = 0;                  ///< metres along the line
    float step = 0;                   ///< metres
    std::uint32_t count = 0;          ///< of scatterers
    const float* real = nullptr;      ///< of the complex amplitudes
    const float* imaginary = nullptr; ///< as many
    vec2 slope{0, 0}; ///< on lines beside this one each stands deeper by so many metres a metre: in plane, out of it
};

/// Something to emit to, for the check below.
struct any_emit {
    /// Does nothing.
    INSONIFY_FN void operator()(const scatterer_run&) const {}
};

/// What a scattering field must do: emit(run) for the scatterers of one object between two distances along a line.
///
/// `spacing` metres of tissue at rest hold a mean power of 1, whatever the field; `covariance` says how alike the
/// amplitudes on two lines are that lie so many metres apart and differ in direction by so many radians, 1 to 0.
template <class Field>
concept scattering_field = requires(const Field& field, const material_line& line, float x) {
    field.scatter(line, x, x, x, any_emit{});
    { field.covariance(x, x) } -> std::convertible_to<float>;
};

/// No texture at all.
struct no_scatterers {
    /// Emits nothing.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line&, float, float, float, Emit&&) const {}
    /// Of nothing: 0.
    INSONIFY_FN float covariance(float, float) const { return 0; }

    friend bool operator==(const no_scatterers&, const no_scatterers&) = default;
};

/// Points of an object stay where they are: the map of tissue that moves rigidly, or not at all.
struct undeformed {
    /// The point itself.
    INSONIFY_FN vec3 operator()(std::uint32_t, vec3 point) const { return point; }

    friend bool operator==(const undeformed&, const undeformed&) = default;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
