#ifndef INSONIFY_SCENE_QUERIES_HPP
#define INSONIFY_SCENE_QUERIES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/scene/crossings.hpp>
#include <insonify/scene/nearest_point.hpp>
#include <insonify/scene/scene.hpp>
#include <concepts>
#include <cstdint>
#include <optional>

/// Queries for contact, collision and placement. Distances are metres, points and directions in the world.
///
/// All may be called from many threads at once. The first query after objects have moved refits their trees.
namespace insonify::inline INSONIFY_ABI {

/// A point on the surface of an object.
struct surface_point {
    object_id object{};     ///< whose surface it is
    std::uint32_t face = 0; ///< index into `object::surface.faces`
    float distance = 0;     ///< from the origin of the ray, in units of its direction, or from the point of the query
    vec3 point{0, 0, 0};    ///< in the world
    vec3 normal{0, 0, 1};   ///< of the face, outwards, length 1
};

/// Accepts every object.
struct any_object {
    /// Always true.
    constexpr bool operator()(object_id) const { return true; }
};

namespace detail {

inline surface_point surface_point_at(const object_view& one, std::uint32_t face, float distance, vec3 point) {
    const vec3 normal = unit_normal(one.surface[face], {0, 0, 1});
    return {object_id{one.id}, face, distance, point, one.at.direction(normal)};
}

/// Whether an object contains a point: a half line from there crosses its surface an odd number of times.
inline bool contains(const object_view& one, vec3 point) {
    bool inside = false;
    one.tree.for_each_hit(one.local({.origin = point}), [&](const hit&) { inside = !inside; });
    return inside;
}

/// The object whose medium applies at a point; null in the background.
inline const object_view* top_at(const scene_view& flat, vec3 point) {
    std::uint32_t top = media_stack::none;
    flat.boxes.for_each_overlap(aabb{point, point}, [&](std::uint32_t rank) {
        if (rank < top && contains(flat.objects[rank], point)) top = rank;
    });
    return top == media_stack::none ? nullptr : &flat.objects[top];
}

/// @throws usage_error  for a ray that would miss everything
inline void check_ray(const ray& r, const char* caller) {
    const vec3 along = abs(r.direction);
    if (!is_finite(r.origin) || !is_finite(r.direction) || !(max(along.x, max(along.y, along.z)) > 1e-30F) ||
        !is_number(r.min_distance) || !is_number(r.max_distance))
        throw usage_error{std::string{caller} +
                          ": the ray needs a finite origin, a finite direction that is not 0, and "
                          "limits that are not NaN"};
}

} // namespace detail

/// The object that gives the medium at a point; none in the background.
/// @throws usage_error  for a point that is not finite, or a scene that was not built
inline std::optional<object_id> object_at(const scene& body, vec3 point) {
    detail::check_point(point, "object_at");
    const object_view* one = detail::top_at(body.view_for_rays(exec::par), point);
    return one == nullptr ? std::nullopt : std::optional{object_id{one->id}};
}

/// The medium at a point: that of `object_at`, or the background's.
/// @throws usage_error  for a point that is not finite, or a scene that was not built
inline medium medium_at(const scene& body, vec3 point) {
    detail::check_point(point, "medium_at");
    const scene_view flat = body.view_for_rays(exec::par);
    const object_view* one = detail::top_at(flat, point);
    return flat.media[one == nullptr ? 0 : one->medium];
}

/// The first surface along a ray, within its limits, from either side; none where there is none.
///
///     const auto skin = first_surface(body, {.origin = tip, .direction = {0, 0, 1}}, [&](object_id id) { return id != needle; });
///
/// Of surfaces that touch, any may be reported: their distances differ by rounding errors.
/// @param accepts  bool(object_id): objects for which it returns false are passed through
/// @throws usage_error  for an origin or a direction that is not finite, a direction of length 0, a limit that is NaN, or a
///                      scene that was not built
template <std::predicate<object_id> Filter = any_object>
std::optional<surface_point> first_surface(const scene& body, const ray& r, const Filter& accepts = {}) {
    detail::check_ray(r, "first_surface");
    const scene_view flat = body.view_for_rays(exec::par);
    hit first;
    std::uint32_t rank = 0;
    flat.boxes.for_each_hit(r, [&](const hit& box) {
        const object_view& one = flat.objects[box.primitive];
        if (box.distance > first.distance || !accepts(object_id{one.id})) return;
        ray local = one.local(r);
        local.max_distance = min(local.max_distance, first.distance);
        const hit found = one.tree.closest(local);
        if (!found || (first && !(found.distance < first.distance || box.primitive < rank))) return;
        first = found;
        rank = box.primitive;
    });
    if (!first) return std::nullopt;
    return detail::surface_point_at(flat.objects[rank], first.primitive, first.distance, r.at(first.distance));
}

/// The point of an object's surface that is nearest to a point; none for an object without faces.
/// @throws usage_error  for an unknown id, a point that is not finite, or a scene that was not built
inline std::optional<surface_point> nearest_surface(const scene& body, object_id id, vec3 point) {
    detail::check_point(point, "nearest_surface");
    static_cast<void>(body[id]); // throws for an unknown id
    const scene_view flat = body.view_for_rays(exec::par);
    for (const object_view& one : flat.objects) {
        if (one.id != static_cast<std::uint32_t>(id)) continue;
        const detail::nearest_point found = detail::find_nearest(one.tree, one.at.local_point(point));
        if (found.primitive == detail::nearest_point{}.primitive) return std::nullopt;
        return detail::surface_point_at(one, found.primitive, std::sqrt(found.distance_squared),
                                        one.at.point(found.point));
    }
    return std::nullopt;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
