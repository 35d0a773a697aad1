#ifndef INSONIFY_SCENE_OBJECT_ORDER_HPP
#define INSONIFY_SCENE_OBJECT_ORDER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/object_state.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The index of the object of each rank: of objects that contain a point the one of lowest rank gives the medium. Ordered
/// by priority, then by smaller enclosed volume, then the later first.
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
        const auto known = std::find(media.begin(), media.end(), objects[i].inside);
        states[i].medium = static_cast<std::uint32_t>(known - media.begin());
        if (known == media.end()) media.push_back(objects[i].inside);
    }
    return media;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
