#ifndef INSONIFY_SCENE_FLAT_SCENE_HPP
#define INSONIFY_SCENE_FLAT_SCENE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/bvh.hpp>
#include <insonify/execution/any_policy.hpp>
#include <insonify/scene/object_state.hpp>
#include <insonify/scene/scene_view.hpp>
#include <insonify/tissue/structure.hpp>
#include <atomic>
#include <cstddef>
#include <mutex>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The arrays behind a `scene_view`. They point into the scene that they were made of, so that a copy starts out of date.
class flat_scene {
  public:
    flat_scene() = default;
    flat_scene(const flat_scene&) {}
    flat_scene& operator=(const flat_scene&) {
        expire();
        return *this;
    }

    /// The scene has changed.
    void expire() { current_.store(false, std::memory_order_relaxed); }
    /// Whether the arrays match the scene; if so, they may be read by any number of threads.
    bool current() const { return current_.load(std::memory_order_acquire); }

    /// Whether the trees of all objects were up to date.
    bool all_current() const { return all_current_; }

    /// @param by_rank     index of the object of each rank
    /// @param background  structure of its medium
    template <class Policy>
    void assign(const Policy& policy, const std::vector<object>& objects, const std::vector<object_state>& states,
                const std::vector<std::uint32_t>& by_rank, view<const medium> media,
                const placed_structure& background) {
        objects_.clear();
        boxes_.clear();
        places_.assign(1, pose{});
        structures_.assign(1, background);
        all_current_ = true;
        for (const std::uint32_t i : by_rank) {
            const object& one = objects[i];
            const object_state& state = states[i];
            const mesh_view surface{one.surface};
            objects_.push_back(
                {.surface = surface,
                 .tree = state.tree_is_current ? state.tree.view_of(surface) : bvh_view<mesh_view>{},
                 .groups = state.groups.view_of(),
                 .normals = state.tree_is_current ? state.normals.view_of() : state.normals.view_without_normals(),
                 .at = one.at,
                 .box = state.box,
                 .id = static_cast<std::uint32_t>(one.id),
                 .medium = state.medium,
                 .tree_is_current = state.tree_is_current});
            all_current_ = all_current_ && state.tree_is_current;
            boxes_.push_back({state.box});
            places_.push_back(one.at);
            structures_.push_back(state.placed());
        }
        const view<const detail::object_box> boxes{boxes_};
        if (tree_size_ == boxes_.size() && tree_size_ > 0)
            tree_.update(policy, boxes);
        else
            tree_.build(policy, boxes);
        tree_size_ = boxes_.size();
        media_ = media;
        current_.store(true, std::memory_order_release);
    }

    scene_view view_of() const {
        return {.objects = objects_,
                .boxes = tree_.view_of(view<const detail::object_box>{boxes_}),
                .media = media_,
                .places = places_,
                .structures = structures_,
                .displacements = {}};
    }

  private:
    std::vector<object_view> objects_{};
    std::vector<detail::object_box> boxes_{};
    std::vector<pose> places_{};
    std::vector<placed_structure> structures_{};
    bvh_storage<view<const detail::object_box>, simd_width, build_morton> tree_{};
    std::size_t tree_size_ = 0;
    view<const medium> media_{};
    bool all_current_ = true;
    std::atomic<bool> current_{false};
};

/// A mutex that a class may hold and still be copied: each copy has its own.
struct own_mutex : std::mutex {
    own_mutex() = default;
    own_mutex(const own_mutex&) {}
    own_mutex& operator=(const own_mutex&) { return *this; }
};

/// Counts uses by any number of threads.
class use_count {
  public:
    use_count() = default;
    use_count(const use_count&) {}
    use_count& operator=(const use_count&) {
        reset();
        return *this;
    }
    void reset() { count_.store(0, std::memory_order_relaxed); }
    /// @return the count, including this one
    std::uint32_t add() { return count_.fetch_add(1, std::memory_order_relaxed) + 1; }

  private:
    std::atomic<std::uint32_t> count_{0};
};

/// What a scene consists of, as its views see it.
struct scene_parts {
    const std::vector<object>& objects;
    std::vector<object_state>& states;         // of each object; trees follow when rays need them
    const std::vector<std::uint32_t>& by_rank; // index of the object of each rank
    const std::vector<medium>& media;
    const placed_structure& background;
};

/// The flat arrays of a scene, brought up to date when a const function needs them, by any number of threads. A copy starts
/// out of date.
class scene_views {
  public:
    /// The scene has changed.
    void expire() {
        for_slices_.expire();
        for_rays_.expire();
    }
    /// Vertices have moved: trees are out of date again.
    void reset_slices() { sliced_.reset(); }

    /// See `scene::view_for_slices`.
    scene_view for_slices(const any_policy<false>& policy, const scene_parts& of) {
        constexpr std::uint32_t slices_worth_a_tree = 3;
        const scene_view flat = flattened(policy, of);
        if (for_slices_.all_current() || sliced_.add() <= slices_worth_a_tree) return flat;
        return for_rays(policy, of);
    }

    /// See `scene::view_for_rays`.
    scene_view for_rays(const any_policy<false>& policy, const scene_parts& of) {
        const scene_view flat = flattened(policy, of);
        if (for_slices_.all_current()) return flat;
        if (!for_rays_.current()) {
            const std::lock_guard lock{mutex_};
            if (!for_rays_.current()) {
                exec::for_each_block(policy, of.objects.size(), 1, 20e3F, [&](std::size_t i, std::size_t) {
                    of.states[i].update_tree(policy, of.objects[i]);
                });
                for_rays_.assign(policy, of.objects, of.states, of.by_rank, of.media, of.background);
            }
        }
        return for_rays_.view_of();
    }

  private:
    scene_view flattened(const any_policy<false>& policy, const scene_parts& of) {
        if (!for_slices_.current()) {
            const std::lock_guard lock{mutex_};
            if (!for_slices_.current())
                for_slices_.assign(policy, of.objects, of.states, of.by_rank, of.media, of.background);
        }
        return for_slices_.view_of();
    }

    own_mutex mutex_{};
    flat_scene for_slices_{}, for_rays_{};
    use_count sliced_{}; // times, while trees were out of date
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
