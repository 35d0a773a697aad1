#ifndef INSONIFY_SCENE_SCENE_VIEWS_HPP
#define INSONIFY_SCENE_SCENE_VIEWS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/any_policy.hpp>
#include <insonify/scene/flat_scene.hpp>
#include <mutex>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

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
