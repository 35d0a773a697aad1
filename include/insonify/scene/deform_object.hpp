#ifndef INSONIFY_SCENE_DEFORM_OBJECT_HPP
#define INSONIFY_SCENE_DEFORM_OBJECT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/check_object.hpp>
#include <insonify/scene/inverse_map.hpp>
#include <insonify/scene/inverse_tetrahedra.hpp>
#include <insonify/scene/object_state.hpp>
#include <atomic>

namespace insonify::inline INSONIFY_ABI::detail {

/// Moves the vertices of an object to where a map puts them, from rest.
/// @return  whether any is away from rest
/// @throws geometry_error  where the map folds over, as far as it is seen here, or is not finite
template <class Policy, deformation_map Map>
bool displace_vertices(const Policy& policy, const Map& map, const pose& at, view<const vec3> rest, located_vertices&,
                       view<vec3> now) {
    constexpr std::size_t block = 1024, checked = 8; // every eighth vertex is checked, as that takes three more points
    std::atomic<bool> displaced{false};
    exec::for_each_block(policy, rest.size(), block, 50, [&](std::size_t begin, std::size_t end) {
        bool any = false;
        for (std::size_t i = begin; i < end; ++i) {
            const vec3 from = at.point(rest[i]), to = deformed_point(map, from);
            if (i % checked == 0) check_map_at(map, from, to);
            now[i] = rest[i] + at.local_direction(to - from); // exactly at rest where the map is the identity
            any = any || to != from;
        }
        if (any) displaced.store(true, std::memory_order_relaxed);
    });
    return displaced.load(std::memory_order_relaxed);
}

/// Checks a map at points throughout a box in the world.
/// @throws geometry_error  where it folds over, or is not finite
template <class Policy, deformation_map Map>
void check_map(const Policy& policy, const Map& map, const aabb& box) {
    constexpr std::uint32_t points = 12; // along each axis
    if constexpr (requires { map.check(); }) map.check();
    if (box.empty()) return;
    exec::for_each_block(policy, points * points * points, points, 150, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const uvec3 cell{i % points, i / points % points, i / points / points};
            const vec3 rest = box.lower + (vec3{cell} + 0.5F) / static_cast<float>(points) * box.size();
            check_map_at(map, rest, deformed_point(map, rest));
        }
    });
}

/// Deforms an object from rest, or returns it to rest where there is no map.
/// @return  whether its vertices may have moved
template <class Policy, class Map>
bool deform_object(const Policy& policy, object& one, object_state& state, const Map* map) {
    std::vector<vec3>& now = one.surface.positions;
    if (map == nullptr && !state.follows) return false;
    if (state.rest.empty()) state.rest = now;
    state.follows = map != nullptr;
    state.rest_at = one.at;
    const bool was_displaced = std::exchange(state.displaced, map != nullptr); // also where the map throws
    if (map != nullptr)
        state.displaced = displace_vertices(policy, *map, one.at, state.rest, state.located, now);
    else
        std::copy(state.rest.begin(), state.rest.end(), now.begin());
    if (!state.displaced && !was_displaced && !state.moved) return false;
    if (!state.read(policy, one)) refuse_frame(one, find_not_finite(now));
    state.accept(one);
    return true;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
