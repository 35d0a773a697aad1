#ifndef INSONIFY_SCENE_SCENE_HPP
#define INSONIFY_SCENE_SCENE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/memo.hpp>
#include <insonify/scene/scene_state.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Closed surfaces with a medium inside each, in a background that fills the rest. A value: a copy is deep.
///
/// Objects may nest, overlap and touch. Of those that contain a point, the one of highest priority gives the medium;
/// among equals the one that encloses less volume (as built), then the one added later.
///
///     scene body{tissue::muscle};
///     const object_id bone = body.add(make_sphere({0, 0, 30_mm}, 10_mm, 5), tissue::bone);
///     body.build(exec::par);                       // once all objects are added
///     std::span<vec3> now = body.positions(bone);  // each frame: move vertices ...
///     body.update(exec::par);                      // ... and tell the scene
///
/// Const functions may be called from many threads at once.
class scene {
  public:
    /// @throws usage_error  for a background out of range: see `is_valid`
    explicit scene(const medium& background = medium{}) : background_{background} {
        detail::check_medium(background, "scene: the background");
    }

    /// Adds a closed surface. Call `build` before tracing.
    /// @throws geometry_error  for vertices out of range or not finite, or a pose that is not rigid
    /// @throws usage_error     for a medium or a crease angle out of range
    object_id add(mesh surface, const medium& inside, object_settings settings = {}) {
        const object_id id{next_id_};
        detail::check_object(surface, inside, settings, id);
        states_.resize(objects_.size() + 1);
        states_.back().volume = enclosed_volume(surface);
        objects_.push_back({std::move(settings), id, std::move(surface), inside});
        ++next_id_;
        built_ = false;
        return id;
    }

    /// Removes an object. Call `build` before tracing. @throws usage_error  for an unknown id
    void remove(object_id id) {
        const std::size_t index = index_of(id);
        objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(index));
        states_.erase(states_.begin() + static_cast<std::ptrdiff_t>(index));
        built_ = false;
    }

    /// The object's vertices in object coordinates, to be moved. Call it each frame, and `update` afterwards.
    ///
    /// The span is valid until `add`, `remove` or assignment. @throws usage_error  for an unknown id
    std::span<vec3> positions(object_id id) {
        const std::size_t index = index_of(id);
        states_[index].hand_out(objects_[index]);
        return objects_[index].surface.positions;
    }
    /// The same to be read. @throws usage_error  for an unknown id
    std::span<const vec3> positions(object_id id) const { return (*this)[id].surface.positions; }

    /// Sets the object's pose (object to world) in place of the former one. Takes effect at once.
    /// @throws usage_error  for an unknown id  @throws geometry_error  for a pose that is not rigid
    void place(object_id id, const pose& at) {
        const std::size_t index = index_of(id);
        if (!is_rigid(at))
            throw geometry_error{"place: the pose is not a rigid transform (rotation and translation); make it with "
                                 "look_at, or mend it with orthonormalised"};
        objects_[index].at = at;
        states_[index].box = detail::placed_box(states_[index].local_box, at);
        expire();
    }

    /// Sets the axes of the structure of the background, in the world: along its fibres, and where it is flattest. By
    /// default x and z. @throws usage_error  for directions that are 0, parallel or not finite
    void set_background_fibres(vec3 along, vec3 flat = {0, 0, 1}) {
        if (!is_finite(along) || !is_finite(flat) || length(cross(along, flat)) <= 1e-3F * length(along) * length(flat))
            throw usage_error{"set_background_fibres: the directions must be finite, not 0 and not parallel, such as "
                              "{1, 0, 0} and {0, 0, 1}"};
        background_axes_ =
            detail::aligned(mat3{normalize(along), normalize(cross(flat, along)), normalize(flat)}, along);
        place_background();
    }

    /// Sets what fills an object. Takes effect at once; indices into `media()` may change.
    /// @throws usage_error  for an unknown id or a medium out of range
    void set_medium(object_id id, const medium& inside) {
        const std::size_t index = index_of(id);
        detail::check_medium(inside, "set_medium: the medium of " + detail::named(objects_[index].name, id));
        const medium before = std::exchange(objects_[index].inside, inside);
        try {
            if (built_) media_ = detail::distinct_media(background_, objects_, states_);
        } catch (...) {
            objects_[index].inside = before;
            throw;
        }
        if (built_) states_[index].place_structure(objects_[index], states_[index].rest);
        expire();
    }

    /// Makes the scene ready to trace: builds all trees and ranks the objects.
    ///
    /// Where it throws, as for lack of memory, the scene is unchanged.
    /// @throws geometry_error  for vertices that were moved and are not finite, see `update`, or a function of `fibres`
    ///                         that returns no direction
    template <exec::policy Policy>
    scene& build(const Policy& policy) & {
        rebuild(threads{policy});
        return *this;
    }
    /// The same for a temporary: `const scene body = load_obj_scene(...).build(exec::par);`
    template <exec::policy Policy>
    scene build(const Policy& policy) && {
        build(policy);
        return std::move(*this);
    }

    /// Follows the vertices that moved since the last frame.
    ///
    /// Cost: one pass over the vertices that moved, which also checks and copies them. Trees are not touched: slices
    /// need none, and the scene brings a tree up to date when rays first need it, or once its object has been at rest
    /// for a few updates. Allocates only where an object moves for the first time.
    /// @throws geometry_error  for a vertex that is not finite; then all objects are where the last update left them
    /// @throws usage_error     where `build` was not called since the last `add` or `remove`
    template <exec::policy Policy>
    void update(const Policy& policy) {
        follow(threads{policy});
    }

    /// Deforms the body: moves each vertex from rest to where a map puts it. Speckle, structure and fibres follow, also
    /// in the background.
    ///
    ///     body.deform(exec::par, [](vec3 rest) { return rest + vec3{0, 0, 0.1F * rest.z}; });
    ///
    /// The map takes a point at rest to where it is now, both in the world, in metres. Calls do not add up: each
    /// replaces the former one. Rest is where the vertices were at the first call, in the object's present pose. The
    /// scene keeps a copy of the map for its inverse, which each frame needs where its lines run: capture values, not
    /// references. If `deform` throws, the body is at rest. `update` is not needed.
    /// @throws geometry_error  where the map folds over, or gives a point that is not finite
    /// @throws usage_error     for an unknown id, or where `build` was not called since the last `add` or `remove`
    template <exec::policy Policy, deformation_map Map>
    void deform(const Policy& policy, const Map& map) {
        deform_those(threads{policy}, map, [](object_id) { return true; });
    }
    /// The same for some objects and the background; the other objects are at rest.
    /// @param only  the objects that follow
    template <exec::policy Policy, deformation_map Map>
    void deform(const Policy& policy, const Map& map, std::span<const object_id> only) {
        for (const object_id id : only) static_cast<void>(index_of(id));
        deform_those(threads{policy}, map,
                     [&](object_id id) { return std::find(only.begin(), only.end(), id) != only.end(); });
    }

    /// The object's vertices at rest, in object coordinates. @throws usage_error  for an unknown id
    std::span<const vec3> rest_positions(object_id id) const {
        const std::size_t index = index_of(id);
        return states_[index].rest.empty() ? objects_[index].surface.positions : states_[index].rest;
    }

    /// Where the tissue of an object, or of the background, that is now at a point was at rest; both in the world.
    /// @throws usage_error  for an unknown id or a point that is not finite
    /// @throws geometry_error  where the map of `deform` folds over
    vec3 rest_of(vec3 now, std::optional<object_id> of = std::nullopt) const {
        detail::check_point(now, "rest_of");
        if (!of) return deformation_.rest_of(now);
        const std::size_t index = index_of(*of);
        if (!states_[index].follows) return now;
        return deformation_.rest_of(states_[index].rest_at.point(objects_[index].at.local_point(now)));
    }

    /// What fills the space around the objects.
    const medium& background() const { return background_; }

    /// All objects, in the order they were added.
    const std::vector<object>& objects() const { return objects_; }

    /// One object. @throws usage_error  for an unknown id
    const object& operator[](object_id id) const { return objects_[index_of(id)]; }

    /// The first object of this name, if there is one.
    std::optional<object_id> find(std::string_view name) const {
        for (const object& one : objects_)
            if (one.name == name) return one.id;
        return std::nullopt;
    }

    /// The different media, the background first; as of the last `build` or `set_medium`.
    view<const medium> media() const { return media_; }

    /// The box around all objects, in the world; as built, updated or placed.
    aabb box() const {
        aabb whole;
        for (const detail::object_state& state : states_) whole = merged(whole, state.box);
        return whole;
    }
    /// The box around one object, in the world. @throws usage_error  for an unknown id
    aabb box(object_id id) const { return states_[index_of(id)].box; }

    /// Whether an object was turned inside out since it was added, as by a simulation that diverges: the volume inside
    /// its closed faces has changed its sign. One pass over the faces. @throws usage_error  for an unknown id
    bool is_inside_out(object_id id) const {
        const std::size_t index = index_of(id);
        const double was = states_[index].volume, now = enclosed_volume(objects_[index].surface);
        return was != 0 && std::fabs(now) > 0.01 * std::fabs(was) && (now < 0) != (was < 0); // flat ones are not
    }

    /// Whether `deform` has moved tissue from where it rests.
    bool is_deformed() const { return !deformation_.empty(); }
    /// Whether `build` was called since the last `add` or `remove`.
    bool is_built() const { return built_; }
    /// @throws usage_error  where it was not
    void require_built() const {
        if (!built_)
            throw usage_error{"scene: call build(policy) after the last add or remove, before tracing or update"};
    }
    /// Whether an object's positions were handed out for writing since the last `update`.
    /// @throws usage_error  for an unknown id
    bool awaits_update(object_id id) const { return states_[index_of(id)].moved; }

    /// The scene as flat arrays, for slices: the trees of objects that have moved may be out of date. After 16
    /// calls without further motion they are brought up to date.
    /// @throws usage_error  where `build` was not called since the last `add` or `remove`
    template <exec::policy Policy>
    scene_view view_for_slices(const Policy& policy) const {
        require_built();
        return views_.for_slices(threads{policy}, parts());
    }

    /// The scene as flat arrays, for rays: brings the trees of objects that have moved up to date first.
    /// @throws usage_error  where `build` was not called since the last `add` or `remove`
    template <exec::policy Policy>
    scene_view view_for_rays(const Policy& policy) const {
        require_built();
        return views_.for_rays(threads{policy}, parts());
    }

    /// The displacements of tissue from now to rest at the nodes of a lattice, for tracers: of the background, then of
    /// the objects by rank; empty where nothing is deformed. `nodes` and `places` are the memory of what is returned.
    template <exec::policy Policy>
    view<const displacement_view> displacements(const Policy& policy, const detail::displacement_lattice& where,
                                                std::vector<float>& nodes,
                                                std::vector<displacement_view>& places) const {
        if (deformation_.empty()) return {};
        // An object that was placed elsewhere since `deform` keeps what the map did to it: it has a lattice of its own.
        const auto placed_since = [&](std::uint32_t i) {
            return states_[i].follows && objects_[i].at != states_[i].rest_at;
        };
        const std::size_t count = 4 * where.count();
        nodes.resize(count *
                     static_cast<std::size_t>(1 + std::count_if(by_rank_.begin(), by_rank_.end(), placed_since)));
        float* next = nodes.data();
        const auto inverted_at = [&](const pose& at) {
            detail::displacement_lattice lattice = where;
            lattice.at = at;
            float* const first = std::exchange(next, next + count);
            deformation_.invert(threads{policy}, lattice, first);
            const vec3& spacing = where.spacing;
            return displacement_view{.nodes = {first, count},
                                     .size = where.size,
                                     .per_spacing = 1.0F / spacing,
                                     .at = at,
                                     .straight_length = 2 * min(spacing.x, min(spacing.y, spacing.z))};
        };
        places.assign(1, inverted_at(where.at));
        for (const std::uint32_t i : by_rank_) {
            const pose& rest_at = states_[i].rest_at;
            displacement_view of_object =
                placed_since(i) ? inverted_at(rest_at * inverse(objects_[i].at) * where.at) : places[0];
            of_object.at = inverse(rest_at) * of_object.at;
            places.push_back(states_[i].follows ? of_object : displacement_view{});
        }
        if (std::all_of(nodes.begin(), nodes.end(), [](float one) { return one == 0; })) return {};
        return places;
    }

  private:
    using threads = detail::any_policy<false>; // one instantiation for all policies

    // Reads the positions of some objects. @throws geometry_error  as `update`, with all of them back where they were
    template <class Which>
    void read_positions(const threads& policy, const Which& which) {
        const object* refused = nullptr;
        for (std::size_t i = 0; i < objects_.size(); ++i)
            if (which(states_[i]) && !states_[i].read(policy, objects_[i]) && refused == nullptr)
                refused = &objects_[i];
        if (refused == nullptr) return;
        const std::size_t vertex = detail::find_not_finite(refused->surface.positions);
        for (std::size_t i = 0; i < objects_.size(); ++i)
            if (which(states_[i])) states_[i].refuse(objects_[i]);
        detail::refuse_frame(*refused, vertex);
    }

    // The work of `update` and `build`.
    template <class Threads>
    void follow(const Threads& policy);
    template <class Threads>
    void rebuild(const Threads& policy);

    // The work of `deform`.
    template <class Map, class Follows>
    void deform_those(const threads& policy, const Map& map, const Follows& follows) {
        require_built();
        try {
            read_positions(policy, [](const detail::object_state& state) { return state.moved; });
            detail::check_map(policy, map, box());
            std::atomic<bool> any_moved{false};
            exec::for_each_block(policy, objects_.size(), 1, 100e3F, [&](std::size_t i, std::size_t) {
                if (detail::deform_object(policy, objects_[i], states_[i], follows(objects_[i].id) ? &map : nullptr))
                    any_moved.store(true, std::memory_order_relaxed);
            });
            if (any_moved.load(std::memory_order_relaxed)) views_.reset_slices();
            deformation_.assign(map);
        } catch (...) {
            for (std::size_t i = 0; i < objects_.size(); ++i)
                detail::deform_object<threads, Map>(policy, objects_[i], states_[i], nullptr);
            deformation_.clear();
            expire();
            throw;
        }
        expire();
    }

    void place_background() {
        background_structure_ = {background_.structure, background_axes_};
        expire();
    }

    detail::scene_parts parts() const { return {objects_, states_, by_rank_, media_, background_structure_}; }
    void expire() { views_.expire(); }

    // Ids ascend in the order of the objects.
    std::size_t index_of(object_id id) const {
        const auto found = std::lower_bound(objects_.begin(), objects_.end(), id,
                                            [](const object& one, object_id wanted) { return one.id < wanted; });
        if (found == objects_.end() || found->id != id)
            throw usage_error{"scene: no object has the id ", static_cast<std::uint32_t>(id),
                              "; use the id that `add` or `find` returned, of an object that was not removed"};
        return static_cast<std::size_t>(found - objects_.begin());
    }

    medium background_;
    mat3 background_axes_{1};
    placed_structure background_structure_{};
    std::vector<object> objects_{};
    mutable std::vector<detail::object_state> states_{}; // of each object; trees follow when rays need them
    std::vector<medium> media_{};
    std::vector<std::uint32_t> by_rank_{}; // index of the object of each rank
    std::uint32_t next_id_ = 0;
    detail::cleared_by_move<bool> built_{};
    detail::kept_map deformation_{};
    mutable detail::scene_views views_{}; // what const functions bring up to date
};

template <class Threads>
void scene::follow(const Threads& policy) {
    require_built();
    read_positions(policy, [](const detail::object_state& state) { return state.moved; });
    constexpr std::uint32_t updates_worth_a_tree = 2;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        detail::object_state& state = states_[i];
        if (state.moved) {
            state.accept(objects_[i]);
            views_.reset_slices();
        } else if (state.tree_is_current || ++state.updates_at_rest < updates_worth_a_tree) {
            continue;
        } else {
            state.update_tree(policy, objects_[i]);
        }
        expire();
    }
}

template <class Threads>
void scene::rebuild(const Threads& policy) {
    read_positions(policy, [](const detail::object_state& state) { return state.handed_out(); });
    std::vector<detail::object_state> states(objects_.size());
    for (std::size_t i = 0; i < objects_.size(); ++i) states[i].build(policy, objects_[i], states_[i].rest);
    std::vector<std::uint32_t> by_rank = detail::ranked(objects_);
    std::vector<medium> media = detail::distinct_media(background_, objects_, states);
    for (std::size_t i = 0; i < objects_.size(); ++i) states[i].keep(states_[i]);
    states_ = std::move(states);
    by_rank_ = std::move(by_rank);
    media_ = std::move(media);
    place_background();
    built_ = true;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
