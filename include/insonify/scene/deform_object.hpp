#ifndef INSONIFY_SCENE_DEFORM_OBJECT_HPP
#define INSONIFY_SCENE_DEFORM_OBJECT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/any_policy.hpp>
#include <insonify/scene/inverse_map.hpp>
#include <insonify/scene/inverse_tetrahedra.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/object_state.hpp>
#include <insonify/tissue/displacement_view.hpp>
#include <algorithm>
#include <atomic>
#include <memory>
#include <type_traits>
#include <vector>

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

/// The deformation map of a scene, of any type, as a value. Another map of the same type takes the memory of the former one.
class kept_map {
  public:
    kept_map() = default;
    kept_map(kept_map&&) = default;
    kept_map& operator=(kept_map&&) = default;
    kept_map(const kept_map& other) : map_{other.map_ ? other.map_->copy() : nullptr} {}
    kept_map& operator=(const kept_map& other) {
        if (this != &other) map_ = other.map_ ? other.map_->copy() : nullptr;
        return *this;
    }
    ~kept_map() = default;

    template <deformation_map Map>
    void assign(const Map& map) {
        if constexpr (std::is_copy_assignable_v<Map>) {
            if (map_ && map_->type() == type_of<Map>()) {
                static_cast<typed<Map>&>(*map_).map = map;
                return;
            }
        } else if constexpr (std::is_nothrow_copy_constructible_v<Map>) { // a lambda that captures
            if (map_ && map_->type() == type_of<Map>()) {
                Map& own = static_cast<typed<Map>&>(*map_).map;
                std::destroy_at(&own);
                std::construct_at(&own, map);
                return;
            }
        }
        map_ = std::make_unique<typed<Map>>(map);
    }
    void clear() { map_.reset(); }
    /// Whether there is none: all is at rest.
    bool empty() const { return map_ == nullptr; }

    /// See `invert_map`.
    void invert(const any_policy<false>& policy, const displacement_lattice& where, float* nodes) const {
        map_->invert_at(policy, where, nodes);
    }
    /// The point at rest of the tissue that is now at a point. @throws geometry_error  where the map folds over
    vec3 rest_of(vec3 now) const {
        vec3 rest = now;
        if (map_ && !map_->rest_at(now, rest)) throw_folded(now);
        return rest;
    }

  private:
    struct any_map {
        any_map() = default;
        any_map(const any_map&) = delete;
        any_map& operator=(const any_map&) = delete;
        virtual ~any_map() = default;
        virtual std::unique_ptr<any_map> copy() const = 0;
        virtual const void* type() const = 0;
        virtual void invert_at(const any_policy<false>& policy, const displacement_lattice& where,
                               float* nodes) const = 0;
        virtual bool rest_at(vec3 now, vec3& rest) const = 0;
    };
    template <class Map>
    static const void* type_of() {
        static constexpr char address = 0;
        return &address;
    }
    template <class Map>
    struct typed final : any_map {
        Map map;
        explicit typed(const Map& own) : map(own) {}
        std::unique_ptr<any_map> copy() const override { return std::make_unique<typed>(map); }
        const void* type() const override { return type_of<Map>(); }
        void invert_at(const any_policy<false>& policy, const displacement_lattice& where,
                       float* nodes) const override {
            invert_map(policy, map, where, nodes);
        }
        bool rest_at(vec3 now, vec3& rest) const override { return find_rest(map, now, rest); }
    };

    std::unique_ptr<any_map> map_{};
};

/// The displacements from now to rest at the nodes of a lattice, as the lines of each place read them: the background, then
/// the objects by rank. Empty where nothing is displaced.
inline view<const displacement_view>
displacements_at(const any_policy<false>& policy, const kept_map& map, const displacement_lattice& where,
                 const std::vector<object_state>& states, const std::vector<std::uint32_t>& by_rank,
                 std::vector<float>& nodes, std::vector<displacement_view>& places) {
    if (map.empty()) return {};
    nodes.resize(4 * where.count());
    map.invert(policy, where, nodes.data());
    if (std::all_of(nodes.begin(), nodes.end(), [](float one) { return one == 0; })) return {};
    const vec3& spacing = where.spacing;
    const displacement_view of_background{.nodes = nodes,
                                          .size = where.size,
                                          .per_spacing = 1.0F / spacing,
                                          .at = where.at,
                                          .straight_length = 2 * min(spacing.x, min(spacing.y, spacing.z))};
    places.assign(1, of_background);
    for (const std::uint32_t i : by_rank) {
        displacement_view of_object = of_background;
        of_object.at = inverse(states[i].rest_at) * where.at;
        places.push_back(states[i].follows ? of_object : displacement_view{});
    }
    return places;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
