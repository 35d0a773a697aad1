#ifndef INSONIFY_SCENE_SCENE_STATE_HPP
#define INSONIFY_SCENE_SCENE_STATE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/bvh.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/tetrahedra.hpp>
#include <insonify/tissue/fibres.hpp>
#include <algorithm>
#include <any>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <type_traits>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// What one pass over points finds.
struct point_bounds {
    aabb box{};         ///< around them, where all are finite
    bool finite = true; ///< whether all are
};

inline point_bounds merged(const point_bounds& a, const point_bounds& b) {
    return {merged(a.box, b.box), a.finite && b.finite};
}

/// Bounds points and copies them, in one pass. @param copy  as many; null: none is made
inline point_bounds bounds_of(view<const vec3> points, vec3* copy) {
    // Coordinates interleave in three registers: x y z x, y z x y, z x y z.
    constexpr int width = simd_width;
    using floats = lanes<width>;
    floats lower[3] = {floats(FLT_MAX), floats(FLT_MAX), floats(FLT_MAX)};
    floats upper[3] = {floats(-FLT_MAX), floats(-FLT_MAX), floats(-FLT_MAX)};
    bit_lanes<width> wild{};
    const std::size_t whole = points.size() / width * width;
    for (std::size_t begin = 0; begin < whole; begin += width) {
        const auto add = [&](std::ptrdiff_t k) {
            const floats p = load<width>(&points[begin].x + k * width);
            wild = wild | not_finite<width>(p);
            lower[k] = min(lower[k], p);
            upper[k] = max(upper[k], p);
            if (copy != nullptr) store(p, &copy[begin].x + k * width);
        };
        add(0), add(1), add(2); // not a loop, which g++ -O2 does not unroll
    }
    float lowest[3 * width], highest[3 * width];
    for (std::ptrdiff_t k = 0; k < 3; ++k) {
        store(lower[k], lowest + k * width);
        store(upper[k], highest + k * width);
    }
    point_bounds found;
    for (int lane = 0, i = 0; lane < width; ++lane, i += 3) {
        found.box = merged(
            found.box, aabb{{lowest[i], lowest[i + 1], lowest[i + 2]}, {highest[i], highest[i + 1], highest[i + 2]}});
        found.finite = found.finite && wild[lane] >> 31 == 0;
    }
    for (std::size_t i = whole; i < points.size(); ++i) {
        found = merged(found, {merged(aabb{}, points[i]), is_finite(points[i])});
        if (copy != nullptr) copy[i] = points[i];
    }
    return found;
}

/// World box around a box in object coordinates, enlarged by the rounding error of rays transformed to the object.
inline aabb placed_box(const aabb& local, const pose& at) {
    if (local.empty()) return {};
    const vec3 centre = at.point(local.centre()), half = 0.5F * local.size();
    const mat3& r = at.rotation;
    const vec3 extent = half.x * abs(r[0]) + half.y * abs(r[1]) + half.z * abs(r[2]);
    const vec3 margin = 1e-6F * (abs(centre) + abs(at.translation) + extent + vec3{length(local.centre())});
    return {centre - extent - margin, centre + extent + margin};
}

/// What the scene keeps of one object from build to build.
struct object_past {
    double volume = 0;            ///< enclosed when it was added, m^3; below 0 where faces point inwards
    std::vector<vec3> accepted{}; ///< positions after the last update; empty: they were never handed out
    std::vector<vec3> incoming{}; ///< those that `read` has read, before they are accepted
    std::vector<vec3> rest{};     ///< positions before the first deformation; empty: there was none
    located_vertices located{};   ///< of the vertices at rest in `tetrahedra`
    pose rest_at{};               ///< object to world, when it was last deformed
    bool follows = false;         ///< the map that deforms the scene
    bool displaced = false;       ///< some vertices are away from rest
};

/// What the scene derives from one object and keeps between frames.
struct object_state : object_past {
    bvh_storage<mesh_view> tree{};     ///< in object coordinates
    face_groups groups{};              ///< for slicing while the tree is out of date
    vertex_groups smooth{};            ///< corners of faces that share a normal, as built
    std::vector<vec3> normals{};       ///< of each group of `smooth`
    aabb local_box{};                  ///< in object coordinates, as built or updated
    aabb box{};                        ///< in the world
    std::uint32_t medium = 0;          ///< index into the scene's media
    std::uint32_t updates_at_rest = 0; ///< since the vertices last moved
    bool moved = false;                ///< the positions were handed out for writing since the last update
    aabb incoming_box{};               ///< around the positions that `read` has read
    bool tree_is_current = false;      ///< the tree and the normals fit the positions
    placed_structure structure{};      ///< of the medium, in the axes of the object as built
    fibre_grid<> fibres{};             ///< where they are curved

    /// Builds the tree and the normals. @throws std::bad_alloc
    /// @param at_rest  the positions at rest, if these are others
    template <class Policy>
    void build(const Policy& policy, const object& of, view<const vec3> at_rest) {
        tree.build(policy, mesh_view{of.surface});
        if (of.crease_angle > 0) smooth = vertex_groups{mesh_view{of.surface}, of.crease_angle};
        compute_normals(policy, of);
        moved = false;
        local_box = tree.box();
        box = placed_box(local_box, of.at);
        if (is_curved(of)) fibres = {policy, of.fibres, of.layer_normal, surface_at_rest(of, at_rest), local_box};
        place_structure(of, at_rest);
    }

    /// Takes over what does not depend on the build from an earlier state, whose positions were read.
    void keep(object_state& of) {
        object_past::operator=(std::move(of));
        accepted.swap(incoming);
    }

    void place_structure(const object& of, view<const vec3> at_rest) {
        if (of.inside.structure.empty())
            structure = {};
        else
            structure = {of.inside.structure, is_curved(of) ? mat3{1} : own_axes(of, at_rest)};
    }
    /// The same, with a view of the fibres.
    placed_structure placed() const {
        placed_structure own = structure;
        own.chart = fibres.view_of();
        return own;
    }

    void hand_out(const object& of) {
        if (accepted.empty()) accepted = of.surface.positions;
        moved = true;
    }
    bool handed_out() const { return !accepted.empty(); }

    /// Reads the positions, which `accept` or `refuse` must follow. One pass. @return  whether all are finite
    template <class Policy>
    bool read(const Policy& policy, const object& of) {
        constexpr std::size_t parts = 16;
        const view<const vec3> points{of.surface.positions};
        incoming.resize(accepted.size());
        point_bounds part[parts];
        const std::size_t block = std::max(points.size() / parts + 1, std::size_t{8192});
        exec::for_each_block(policy, points.size(), block, 0.5F, [&](std::size_t begin, std::size_t end) {
            part[begin / block] =
                bounds_of({points.data() + begin, end - begin}, handed_out() ? incoming.data() + begin : nullptr);
        });
        point_bounds whole;
        for (const point_bounds& one : part) whole = merged(whole, one);
        incoming_box = whole.box;
        return whole.finite;
    }

    /// Follows the positions that were read, without touching the tree and the normals.
    void accept(const object& of) {
        if (groups.empty()) groups = face_groups{mesh_view{of.surface}};
        accepted.swap(incoming);
        local_box = incoming_box;
        box = placed_box(local_box, of.at);
        tree_is_current = moved = false;
        updates_at_rest = 0;
    }

    /// Returns the positions to where they were after the last update.
    void refuse(object& of) {
        std::copy(accepted.begin(), accepted.end(), of.surface.positions.begin());
        moved = false;
    }

    /// Refits the tree, or rebuilds it: see `bvh_storage::update`. Computes the normals.
    template <class Policy>
    void update_tree(const Policy& policy, const object& of) {
        if (tree_is_current) return;
        tree.update(policy, mesh_view{of.surface});
        compute_normals(policy, of);
    }

    /// The normals of smooth surfaces; while they are out of date each is computed as it is needed.
    smooth_normals_view normals_view() const {
        return {smooth.corners, smooth.ends, smooth.slots,
                tree_is_current ? view<const vec3>{normals} : view<const vec3>{}};
    }

  private:
    template <class Policy>
    void compute_normals(const Policy& policy, const object& of) {
        normals.resize(smooth.ends.size());
        const smooth_normals_view to_compute{smooth.corners, smooth.ends, smooth.slots, {}};
        exec::for_each_block(policy, normals.size(), 1024, 100, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                normals[i] = to_compute.computed(mesh_view{of.surface}, static_cast<std::uint32_t>(i));
        });
        tree_is_current = true;
    }

    static bool is_curved(const object& of) { return of.fibres.varies() || of.layer_normal.varies(); }
    static mesh_view surface_at_rest(const object& of, view<const vec3> at_rest) {
        mesh_view surface{of.surface};
        if (!at_rest.empty()) surface.positions = at_rest;
        return surface;
    }
    mat3 own_axes(const object& of, view<const vec3> at_rest) const {
        return aligned(axes_of(surface_at_rest(of, at_rest), local_box), of.fibres({0, 0, 0}),
                       of.layer_normal({0, 0, 0}));
    }
};

/// The index of the object of each rank: of objects that contain a point the one of lowest rank gives the medium.
/// Ordered by priority, then by smaller enclosed volume, then the later first.
inline std::vector<std::uint32_t> ranked(const std::vector<object>& objects) {
    std::vector<float> volume;
    volume.reserve(objects.size());
    for (const object& one : objects) volume.push_back(static_cast<float>(std::fabs(enclosed_volume(one.surface))));
    std::vector<std::uint32_t> by_rank(objects.size());
    for (std::uint32_t i = 0; i < by_rank.size(); ++i) by_rank[i] = i;
    std::sort(by_rank.begin(), by_rank.end(), [&](std::uint32_t a, std::uint32_t b) {
        if (objects[a].priority != objects[b].priority) return objects[a].priority > objects[b].priority;
        if (volume[a] != volume[b]) return volume[a] < volume[b];
        return objects[a].id > objects[b].id;
    });
    return by_rank;
}

/// The different media, the background first; writes the index of each object's medium into its state.
inline std::vector<medium> distinct_media(const medium& background, const std::vector<object>& objects,
                                          std::vector<object_state>& states) {
    std::vector<medium> media{background};
    media.reserve(1 + objects.size());
    for (std::size_t i = 0; i < objects.size(); ++i) {
        std::uint32_t number = 0;
        while (number < media.size() && !(media[number] == objects[i].inside)) ++number;
        states[i].medium = number;
        if (number == media.size()) media.push_back(objects[i].inside);
    }
    return media;
}

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

/// The deformation map of a scene, of any type, as a value. Another map of the same type reuses the memory.
class kept_map {
  public:
    template <deformation_map Map>
    void assign(const Map& map) {
        if (Map* const own = std::any_cast<Map>(&map_)) {
            if constexpr (std::is_copy_assignable_v<Map>) {
                *own = map;
                return;
            } else if constexpr (std::is_nothrow_copy_constructible_v<Map>) { // a lambda that captures
                std::destroy_at(own);
                std::construct_at(own, map);
                return;
            }
        }
        map_ = map;
        invert_ = [](const std::any& own, const any_policy<false>& policy, const displacement_lattice& where,
                     float* nodes) { invert_map(policy, *std::any_cast<Map>(&own), where, nodes); };
        find_rest_ = [](const std::any& own, vec3 now, vec3& rest) {
            return find_rest(*std::any_cast<Map>(&own), now, rest);
        };
    }
    void clear() { map_.reset(); }
    /// Whether there is none: all is at rest.
    bool empty() const { return !map_.has_value(); }

    void invert(const any_policy<false>& policy, const displacement_lattice& where, float* nodes) const {
        invert_(map_, policy, where, nodes);
    }
    /// The point at rest of the tissue that is now at a point. @throws geometry_error  where the map folds over
    vec3 rest_of(vec3 now) const {
        vec3 rest = now;
        if (!empty() && !find_rest_(map_, now, rest)) throw_folded(now);
        return rest;
    }

  private:
    std::any map_{};
    void (*invert_)(const std::any&, const any_policy<false>&, const displacement_lattice&, float*) = nullptr;
    bool (*find_rest_)(const std::any&, vec3, vec3&) = nullptr;
};

/// What a scene consists of, as its views see it.
struct scene_parts {
    const std::vector<object>& objects;
    std::vector<object_state>& states;         // of each object; trees follow when rays need them
    const std::vector<std::uint32_t>& by_rank; // index of the object of each rank
    const std::vector<medium>& media;
    const placed_structure& background;
};

/// The arrays behind a `scene_view`, which point into the scene.
class flat_scene {
  public:
    /// The scene has changed.
    void expire() { current_.store(false, std::memory_order_relaxed); }
    /// Whether the arrays match the scene; if so, they may be read by any number of threads.
    bool current() const { return current_.load(std::memory_order_acquire); }
    /// Whether the trees of all objects were up to date.
    bool all_current() const { return all_current_; }

    template <class Policy>
    void assign(const Policy& policy, const scene_parts& of) {
        objects_.clear();
        boxes_.clear();
        places_.assign(1, pose{});
        structures_.assign(1, of.background);
        all_current_ = true;
        for (const std::uint32_t i : of.by_rank) {
            const object& one = of.objects[i];
            const object_state& state = of.states[i];
            const mesh_view surface{one.surface};
            objects_.push_back({.surface = surface,
                                .tree = state.tree_is_current ? state.tree.view_of(surface) : bvh_view<mesh_view>{},
                                .groups = state.groups.view_of(),
                                .normals = state.normals_view(),
                                .at = one.at,
                                .box = state.box,
                                .id = static_cast<std::uint32_t>(one.id),
                                .medium = state.medium,
                                .tree_is_current = state.tree_is_current});
            all_current_ = all_current_ && state.tree_is_current;
            boxes_.push_back(state.box);
            places_.push_back(one.at);
            structures_.push_back(state.placed());
        }
        const view<const aabb> boxes{boxes_};
        if (tree_size_ == boxes_.size() && tree_size_ > 0)
            tree_.update(policy, boxes);
        else
            tree_.build(policy, boxes);
        tree_size_ = boxes_.size();
        media_ = of.media;
        current_.store(true, std::memory_order_release);
    }

    scene_view view_of() const {
        return {.objects = objects_,
                .boxes = tree_.view_of(view<const aabb>{boxes_}),
                .media = media_,
                .places = places_,
                .structures = structures_,
                .displacements = {}};
    }

  private:
    std::vector<object_view> objects_{};
    std::vector<aabb> boxes_{};
    std::vector<pose> places_{};
    std::vector<placed_structure> structures_{};
    bvh_storage<view<const aabb>, simd_width, build_morton> tree_{};
    std::size_t tree_size_ = 0;
    view<const medium> media_{};
    bool all_current_ = true;
    std::atomic<bool> current_{false};
};

/// The flat arrays of a scene, brought up to date when a const function needs them, by any thread. Copies are stale.
class scene_views {
  public:
    scene_views() = default;
    scene_views(const scene_views&) {}
    scene_views& operator=(const scene_views&) {
        expire();
        reset_slices();
        return *this;
    }

    /// The scene has changed.
    void expire() {
        for_slices_.expire();
        for_rays_.expire();
    }
    /// Vertices have moved: trees are out of date again.
    void reset_slices() { sliced_.store(0, std::memory_order_relaxed); }

    template <class Threads>
    scene_view for_slices(const Threads& policy, const scene_parts& of);
    template <class Threads>
    scene_view for_rays(const Threads& policy, const scene_parts& of);

  private:
    scene_view flattened(const any_policy<false>& policy, const scene_parts& of) {
        if (!for_slices_.current()) {
            const std::lock_guard lock{mutex_};
            if (!for_slices_.current()) for_slices_.assign(policy, of);
        }
        return for_slices_.view_of();
    }

    std::mutex mutex_{};
    flat_scene for_slices_{}, for_rays_{};
    std::atomic<std::uint32_t> sliced_{0}; // times, while trees were out of date
};

template <class Threads>
scene_view scene_views::for_slices(const Threads& policy, const scene_parts& of) {
    constexpr std::uint32_t slices_worth_a_tree = 16; // refitting one takes as long
    const scene_view flat = flattened(policy, of);
    if (for_slices_.all_current() || sliced_.fetch_add(1, std::memory_order_relaxed) < slices_worth_a_tree) return flat;
    return for_rays(policy, of);
}

template <class Threads>
scene_view scene_views::for_rays(const Threads& policy, const scene_parts& of) {
    const scene_view flat = flattened(policy, of);
    if (for_slices_.all_current()) return flat;
    if (!for_rays_.current()) {
        const std::lock_guard lock{mutex_};
        if (!for_rays_.current()) {
            exec::for_each_block(policy, of.objects.size(), 1, 20e3F,
                                 [&](std::size_t i, std::size_t) { of.states[i].update_tree(policy, of.objects[i]); });
            for_rays_.assign(policy, of);
        }
    }
    return for_rays_.view_of();
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
