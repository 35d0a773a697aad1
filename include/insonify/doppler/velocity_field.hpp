#ifndef INSONIFY_DOPPLER_VELOCITY_FIELD_HPP
#define INSONIFY_DOPPLER_VELOCITY_FIELD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/object.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// The background as an object whose tissue moves: see `velocity_field`. Its coordinates are those of the world.
inline constexpr object_id background_object{~0U};

/// The velocity of tissue and blood: a function object
///
///     vec3 operator()(object_id object, vec3 point, float time) const
///
/// of an object (`background_object` for the background), a point in it and a time in seconds. Point, in metres, and
/// velocity, in m/s, are in coordinates of the object. {0, 0, 0} where nothing moves. It is called from many threads.
///
/// Of a body that `scene::deform` deforms, the point is where the tissue was at rest, and the velocity is that at rest: a
/// field describes the body at rest, and follows every deformation. Tissue with the velocity V at rest then moves with F V,
/// where F is the gradient of the deformation, and blood with F V / det F, so that its volume flow through a vessel stays
/// that of the field where the vessel is narrowed.
template <class Field>
concept velocity_field = requires(const Field& field, object_id object, vec3 point, float time) {
    { field(object, point, time) } -> std::convertible_to<vec3>;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
