#ifndef INSONIFY_SCENE_OBJECT_HPP
#define INSONIFY_SCENE_OBJECT_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/scene/face_groups.hpp>
#include <cstdint>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// Names an object of one scene, for good: ids are never used again.
enum class object_id : std::uint32_t {};

/// What `scene::add` is told beside surface and medium.
struct object_settings {
    int priority = 0;   ///< where objects overlap, the highest one's medium counts
    pose at{};          ///< object to world
    std::string name{}; ///< for reports, files and error messages
};

/// One closed surface and what is inside it.
struct object {
    object_id id{};                 ///< in its scene
    std::string name{};             ///< may be empty, need not be the only one
    mesh surface;                   ///< in the object's own coordinates
    medium inside{};                ///< what fills it
    pose at{};                      ///< object to world
    int priority = 0;               ///< the highest counts
    float volume = 0;               ///< m^3 enclosed, as built
    std::uint32_t medium_index = 0; ///< into the scene's media, as built
    std::uint32_t rank = 0;         ///< among all objects, as built; where they overlap the lowest rank's medium counts
    bool moved = false;             ///< its positions were handed out for writing since the last update
    bool has_tree = false;          ///< of these faces, though perhaps of former positions
    bool tree_follows = false;      ///< the tree fits the positions: rays can be traced
    aabb local_box{};               ///< in its own coordinates, as built or updated
    aabb box{};                     ///< in the world
    bvh_storage<mesh_view> tree;    ///< in its own coordinates
    face_groups groups;             ///< where the tree waits

    /// The tree over its surface, for rays in its own coordinates; good until the scene changes.
    INSONIFY_LAZY bvh_view<mesh_view> tree_view() const { return tree.view_of(mesh_view{surface}); }

    /// The ray in the object's own coordinates; distances along it stay.
    INSONIFY_LAZY ray local(const ray& r) const {
        return {at.local_point(r.origin), at.local_direction(r.direction), r.min_distance, r.max_distance};
    }
};

/// A box in the world around a box of the object, with room for the rounding of rays that are taken there and back.
INSONIFY_LAZY aabb placed_box(const aabb& local, const pose& at) {
    if (local.empty()) return {};
    const vec3 centre = at.point(local.centre()), half = 0.5F * local.size();
    const mat3& r = at.rotation;
    const vec3 reach = half.x * absolute(r[0]) + half.y * absolute(r[1]) + half.z * absolute(r[2]);
    const vec3 room = 1e-6F * (absolute(centre) + absolute(at.translation) + reach + vec3{length(local.centre())});
    return {centre - reach - room, centre + reach + room};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
