#ifndef INSONIFY_SCENE_SCENE_HPP
#define INSONIFY_SCENE_SCENE_HPP

#include <insonify/bvh/large_array.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/later.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/point_bounds.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What `build` and `update` do about the trees of objects that are new or moved.
enum class trees {
    follow, ///< bring them up to date: every tracer works
    wait,   ///< leave them: slices alone can be traced, until an update with `follow`
};

/// Closed surfaces with a medium inside each, in a background that fills the rest. A value: a copy is deep.
///
/// Objects may nest, overlap and touch. Of those that contain a point the one of highest priority gives the medium;
/// among equals the one that encloses less volume, then the one added later.
///
///     scene body{tissue::muscle};
///     const object_id bone = body.add(make_sphere({0, 0, 30_mm}, 10_mm, 5), tissue::bone);
///     body.build(exec::par);                       // once all is added
///     std::span<vec3> now = body.positions(bone);  // each frame: move vertices ...
///     body.update(exec::par);                      // ... and tell the scene
///
/// Const functions are safe to call from many threads at once.
class scene {
  public:
    /// @throws usage_error  for a background that is none: see `is_valid`
    INSONIFY_LAZY explicit scene(const medium& background = medium{}) : background_{background} {
        if (!is_valid(background))
            throw usage_error{
                "scene: the background needs a density and a sound speed above 0, and no value out of bounds"};
    }

    /// Takes over a closed surface. Call `build` before tracing.
    /// @throws geometry_error  for faces that name no vertex, vertices that are not finite, a pose that is not rigid
    /// @throws usage_error     for a medium that is none
    INSONIFY_LAZY object_id add(mesh surface, const medium& inside, object_settings settings = {}) {
        const std::string named = "object '" + settings.name + "': ";
        if (!is_valid(inside))
            throw usage_error{named +
                              "its medium needs a density and a sound speed above 0, and no value out of bounds"};
        if (!is_rigid(settings.at)) throw geometry_error{named + "its pose is no rigid motion; scale the mesh instead"};
        check_faces(surface, named);
        for (std::size_t i = 0; i < surface.positions.size(); ++i)
            if (!is_finite(surface.positions[i]))
                throw geometry_error{named + "vertex " + std::to_string(i) +
                                     " is not finite; repair the mesh (`validate` tells more)"};
        const object_id id{next_id_};
        object& one = later<Later>(objects_).emplace_back();
        one.id = id;
        one.name = std::move(settings.name);
        one.surface = std::move(surface);
        one.inside = inside;
        one.at = settings.at;
        one.priority = settings.priority;
        ++next_id_;
        built_ = false;
        return id;
    }

    /// Takes an object out. Call `build` before tracing. @throws usage_error  for an unknown id
    INSONIFY_LAZY void remove(object_id id) {
        auto& objects = later<Later>(objects_);
        objects.erase(objects.begin() + (&object_of(id) - objects.data()));
        built_ = false;
    }

    /// The object's vertices in its own coordinates, to be moved; call `update` afterwards, and ask again each frame.
    ///
    /// The span ends with `add`, `remove` or assignment. @throws usage_error  for an unknown id
    INSONIFY_LAZY later_t<Later, std::span<vec3>> positions(object_id id) {
        object& one = object_of(id);
        one.moved = true;
        return {one.surface.positions.data(), one.surface.positions.size()};
    }
    /// The same to be read. @throws usage_error  for an unknown id
    INSONIFY_LAZY later_t<Later, std::span<const vec3>> positions(object_id id) const {
        const object& one = object_of(id);
        return {one.surface.positions.data(), one.surface.positions.size()};
    }

    /// Puts the object where `at` says (object to world), instead of where it was. Counts at once.
    /// @throws usage_error  for an unknown id  @throws geometry_error  for a pose that is not rigid
    INSONIFY_LAZY void place(object_id id, const pose& at) {
        object& one = object_of(id);
        if (!is_rigid(at)) throw geometry_error{"place: the pose is no rigid motion (rotation and translation)"};
        one.at = at;
        one.box = placed_box(one.local_box, at);
        if (built_) places_[1 + static_cast<std::size_t>(&one - objects_.data())] = at;
    }

    /// Makes the scene ready to trace: builds all trees (with `trees::wait` none), orders the objects.
    ///
    /// Where it throws, as for lack of memory, the scene is what it was.
    template <exec::policy Policy>
    scene& build(const Policy& policy, trees upkeep = trees::follow) & {
        later_t<Policy, std::vector<structures>> made(objects_.size());
        large_array<medium> media(1 + objects_.size());
        large_array<pose> places(1 + objects_.size());
        media[0] = background_;
        places[0] = {};
        std::size_t different = 1; // media
        later_t<Policy, std::vector<std::uint32_t>> medium_index, by_rank(objects_.size());
        later_t<Policy, std::vector<float>> volume;
        for (std::size_t i = 0; i < objects_.size(); ++i) {
            const object& one = objects_[i];
            made[i] = structures_over(policy, one, upkeep);
            volume.push_back(static_cast<float>(std::fabs(enclosed_volume(one.surface))));
            places[1 + i] = one.at;
            const auto known = static_cast<std::size_t>(
                std::find(media.begin(), media.begin() + different, one.inside) - media.begin());
            medium_index.push_back(static_cast<std::uint32_t>(known));
            if (known == different) media[different++] = one.inside;
        }
        media.resize(different);
        for (std::uint32_t i = 0; i < by_rank.size(); ++i) by_rank[i] = i;
        std::sort(by_rank.begin(), by_rank.end(), [&](std::uint32_t a, std::uint32_t b) {
            const object &one = objects_[a], &other = objects_[b];
            if (one.priority != other.priority) return one.priority > other.priority;
            if (volume[a] != volume[b]) return volume[a] < volume[b];
            return one.id > other.id;
        });

        media_ = std::move(media); // from here on nothing throws
        places_ = std::move(places);
        by_rank_ = std::move(by_rank);
        for (std::uint32_t rank = 0; rank < by_rank_.size(); ++rank) objects_[by_rank_[rank]].rank = rank;
        for (std::size_t i = 0; i < objects_.size(); ++i) {
            object& one = objects_[i];
            one.volume = volume[i];
            one.medium_index = medium_index[i];
            one.has_tree = false;
            install(one, std::move(made[i]), upkeep);
            take_boxes(policy, one, upkeep);
        }
        built_ = true;
        return *this;
    }
    /// The same of a scene that is made on the spot: `const scene body = load_obj_scene(...).build(exec::par);`
    template <exec::policy Policy>
    scene build(const Policy& policy, trees upkeep = trees::follow) && {
        build(policy, upkeep);
        return std::move(*this);
    }

    /// Follows what moved since the last frame: refits trees, and rebuilds those that refitting has worn off (see
    /// `bvh_storage::update`).
    ///
    /// Cost: nothing for objects at rest; no allocation but where a tree is rebuilt. With `trees::wait` one pass over the
    /// vertices that moved: the cheapest frame of a deforming body, if `trace` can cut it into slices.
    /// Where it throws for lack of memory, objects wait as before: call it again.
    /// @throws usage_error  where `build` was not called since the last `add` or `remove`
    template <exec::policy Policy>
    void update(const Policy& policy, trees upkeep = trees::follow) {
        require_built();
        const auto waits = [upkeep](const object& one) {
            return one.moved || (upkeep == trees::follow && !one.tree_follows);
        };
        for (object& one : objects_) // first all that takes memory
            if (waits(one) && (upkeep == trees::follow ? !one.has_tree : one.groups.empty()))
                install(one, structures_over(policy, one, upkeep), upkeep);
        for (object& one : objects_) {
            if (!waits(one)) continue;
            if (upkeep == trees::follow) one.tree.update(policy, mesh_view{one.surface});
            take_boxes(policy, one, upkeep);
        }
    }

    /// What fills the space around the objects.
    const medium& background() const { return background_; }

    /// All objects, in the order they were added.
    const std::vector<object>& objects() const { return objects_; }

    /// @throws usage_error  for an unknown id
    INSONIFY_LAZY const object& operator[](object_id id) const { return object_of(id); }

    /// The first object of this name, if there is one.
    INSONIFY_LAZY later_t<Later, std::optional<object_id>> find(std::string_view name) const {
        for (const object& one : objects_)
            if (one.name == name) return one.id;
        return std::nullopt;
    }

    /// The different media, the background first; as built.
    INSONIFY_LAZY view<const medium> media() const { return {media_.data(), media_.size()}; }

    /// Where the background (the world itself) and then the objects are, in the order of `objects`; as built or placed.
    INSONIFY_LAZY view<const pose> places() const { return {places_.data(), places_.size()}; }

    /// The object of this rank; as built.
    INSONIFY_LAZY const object& ranked(std::uint32_t rank) const { return objects_[by_rank_[rank]]; }

    /// The box around all objects, in the world; as built or updated.
    INSONIFY_LAZY aabb box() const {
        aabb whole;
        for (const object& one : objects_) whole = merged(whole, one.box);
        return whole;
    }

    /// Whether `build` was called since the last `add` or `remove`.
    bool is_built() const { return built_; }

    /// @throws usage_error  where the scene is not ready to trace
    INSONIFY_LAZY void require_built() const {
        if (!built_)
            throw usage_error{"scene: call build(policy) after the last add or remove, before tracing or update"};
    }

    /// @throws usage_error  where an object's tree waits, so that no ray can be traced
    INSONIFY_LAZY void require_trees() const {
        require_built();
        for (const object& one : objects_)
            if (!one.tree_follows)
                throw usage_error{"scene: the tree of object '" + one.name +
                                  "' waits; call update(policy) before tracing rays, or trace slices"};
    }

  private:
    // What is made of an object's faces: a tree or, where that waits, groups.
    struct structures {
        bvh_storage<mesh_view> tree;
        face_groups groups;
    };
    template <class Policy>
    static structures structures_over(const Policy& policy, const object& one, trees upkeep) {
        structures made;
        if (upkeep == trees::follow)
            made.tree.build(policy, mesh_view{one.surface});
        else
            made.groups = face_groups{mesh_view{one.surface}};
        return made;
    }
    INSONIFY_LAZY static void install(object& one, structures&& made, trees upkeep) {
        if (upkeep == trees::follow) {
            one.tree = std::move(made.tree);
            one.has_tree = true;
        } else {
            one.groups = std::move(made.groups);
        }
    }

    // The positions of an object are new, and its tree fits them unless it waits: moves its boxes.
    template <class Policy>
    static void take_boxes(const Policy& policy, object& one, trees upkeep) {
        one.moved = false;
        one.tree_follows = upkeep == trees::follow;
        one.local_box = one.tree_follows ? one.tree.box() : box_around(policy, one.surface.positions);
        one.box = placed_box(one.local_box, one.at);
    }

    template <class Policy>
    static aabb box_around(const Policy& policy, view<const vec3> points) {
        constexpr std::size_t parts = 16;
        aabb part[parts];
        const std::size_t share = std::max(points.size() / parts + 1, std::size_t{8192});
        exec::for_each_block(policy, points.size(), share, 0.5F, [&](std::size_t begin, std::size_t end) {
            part[begin / share] = bounds_of(view<const vec3>{points.data() + begin, end - begin});
        });
        aabb whole;
        for (const aabb& box : part) whole = merged(whole, box);
        return whole;
    }

    INSONIFY_LAZY const object& object_of(object_id id) const {
        for (const object& one : objects_)
            if (one.id == id) return one;
        throw usage_error{"scene: no object has the id " + std::to_string(static_cast<std::uint32_t>(id))};
    }
    INSONIFY_LAZY object& object_of(object_id id) {
        return objects_[static_cast<std::size_t>(&std::as_const(*this).object_of(id) - objects_.data())];
    }

    medium background_;
    std::vector<object> objects_;
    large_array<medium> media_;
    large_array<pose> places_;
    std::vector<std::uint32_t> by_rank_;
    std::uint32_t next_id_ = 0;
    bool built_ = false;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
