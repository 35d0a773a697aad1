#ifndef INSONIFY_SCENE_SCENE_HPP
#define INSONIFY_SCENE_SCENE_HPP

#include <insonify/core/error.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/point_bounds.hpp>
#include <algorithm>
#include <numeric>
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
    explicit scene(const medium& background = medium{}) : background_{background} {
        if (!is_valid(background)) throw usage_error{"scene: the background needs a density and a sound speed above 0"};
    }

    /// Takes over a closed surface. Call `build` before tracing.
    /// @throws geometry_error  for faces that name no vertex, vertices that are not finite, a pose that is not rigid
    /// @throws usage_error     for a medium that is none
    object_id add(mesh surface, const medium& inside, object_settings settings = {}) {
        const std::string named = "object '" + settings.name + "': ";
        if (!is_valid(inside)) throw usage_error{named + "its medium needs a density and a sound speed above 0"};
        if (!is_rigid(settings.at)) throw geometry_error{named + "its pose is no rigid motion; scale the mesh instead"};
        check_faces(surface, named);
        for (std::size_t i = 0; i < surface.positions.size(); ++i)
            if (!is_finite(surface.positions[i]))
                throw geometry_error{named + "vertex " + std::to_string(i) +
                                     " is not finite; repair the mesh (`validate` tells more)"};
        const object_id id{next_id_++};
        objects_.push_back({.id = id,
                            .name = std::move(settings.name),
                            .surface = std::move(surface),
                            .inside = inside,
                            .at = settings.at,
                            .priority = settings.priority});
        built_ = false;
        return id;
    }

    /// Takes an object out. Call `build` before tracing. @throws usage_error  for an unknown id
    INSONIFY_LAZY void remove(object_id id) {
        objects_.erase(objects_.begin() + (&object_of(id) - objects_.data()));
        built_ = false;
    }

    /// The object's vertices in its own coordinates, to be moved; call `update` afterwards, and ask again each frame.
    ///
    /// The span ends with `add`, `remove` or assignment. @throws usage_error  for an unknown id
    INSONIFY_LAZY std::span<vec3> positions(object_id id) {
        object& one = object_of(id);
        one.moved = true;
        return one.surface.positions;
    }
    std::span<const vec3> positions(object_id id) const { return object_of(id).surface.positions; }

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
    template <exec::policy Policy>
    scene& build(const Policy& policy, trees upkeep = trees::follow) & {
        media_ = {background_};
        places_ = {pose{}};
        for (object& one : objects_) {
            one.has_tree = false;
            take_positions(policy, one, upkeep);
            one.volume = static_cast<float>(std::fabs(enclosed_volume(one.surface)));
            places_.push_back(one.at);
            const auto known = std::find(media_.begin(), media_.end(), one.inside);
            one.medium_index = static_cast<std::uint32_t>(known - media_.begin());
            if (known == media_.end()) media_.push_back(one.inside);
        }
        by_rank_.resize(objects_.size());
        std::iota(by_rank_.begin(), by_rank_.end(), 0U);
        std::sort(by_rank_.begin(), by_rank_.end(), [this](std::uint32_t a, std::uint32_t b) {
            const object &one = objects_[a], &other = objects_[b];
            if (one.priority != other.priority) return one.priority > other.priority;
            if (one.volume != other.volume) return one.volume < other.volume;
            return one.id > other.id;
        });
        for (std::uint32_t rank = 0; rank < by_rank_.size(); ++rank) objects_[by_rank_[rank]].rank = rank;
        built_ = true;
        return *this;
    }
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
    /// @throws usage_error  where `build` was not called since the last `add` or `remove`
    template <exec::policy Policy>
    void update(const Policy& policy, trees upkeep = trees::follow) {
        require_built();
        for (object& one : objects_)
            if (one.moved || (upkeep == trees::follow && !one.tree_follows)) take_positions(policy, one, upkeep);
    }

    const medium& background() const { return background_; }

    /// All objects, in the order they were added.
    const std::vector<object>& objects() const { return objects_; }

    /// @throws usage_error  for an unknown id
    const object& operator[](object_id id) const { return object_of(id); }

    /// The first object of this name, if there is one.
    INSONIFY_LAZY std::optional<object_id> find(std::string_view name) const {
        for (const object& one : objects_)
            if (one.name == name) return one.id;
        return std::nullopt;
    }

    /// The different media, the background first; as built.
    view<const medium> media() const { return media_; }

    /// Where the background (the world itself) and then the objects are, in the order of `objects`; as built or placed.
    view<const pose> places() const { return places_; }

    /// The object of this rank; as built.
    const object& ranked(std::uint32_t rank) const { return objects_[by_rank_[rank]]; }

    /// The box around all objects, in the world; as built or updated.
    INSONIFY_LAZY aabb box() const {
        aabb whole;
        for (const object& one : objects_) whole = merged(whole, one.box);
        return whole;
    }

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
    // The positions of an object are new: moves its boxes and, unless it shall wait, its tree.
    template <class Policy>
    static void take_positions(const Policy& policy, object& one, trees upkeep) {
        const mesh_view surface{one.surface};
        one.moved = false;
        one.tree_follows = upkeep == trees::follow;
        if (one.tree_follows) {
            if (one.has_tree)
                one.tree.update(policy, surface);
            else
                one.tree.build(policy, surface);
            one.has_tree = true;
        } else if (one.groups.empty()) {
            one.groups = face_groups{surface};
        }
        one.local_box = one.tree_follows ? one.tree.box() : box_around(policy, surface.positions);
        one.box = placed_box(one.local_box, one.at);
    }

    template <class Policy>
    static aabb box_around(const Policy& policy, view<const vec3> points) {
        constexpr std::size_t parts = 16;
        aabb part[parts];
        const std::size_t share = std::max(points.size() / parts + 1, std::size_t{8192});
        exec::for_each_block(policy, points.size(), share, [&](std::size_t begin, std::size_t end) {
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
    std::vector<object> objects_{};
    std::vector<medium> media_{};
    std::vector<pose> places_{};
    std::vector<std::uint32_t> by_rank_{};
    std::uint32_t next_id_ = 0;
    bool built_ = false;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
