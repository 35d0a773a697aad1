#ifndef INSONIFY_SCENE_CUT_FACE_HPP
#define INSONIFY_SCENE_CUT_FACE_HPP

#include <insonify/geometry/triangle.hpp>
#include <insonify/scene/slice_frame.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Where a slice at this height goes through the edge between two corners, one below it or in it and one above.
///
/// Faces that share the edge get the very same point, whichever way they walk it, because it is always walked upwards.
struct cut_corner {
    float height = 0;
    vec2 place{0, 0};
};
INSONIFY_LAZY vec2 cut_edge(const cut_corner& below, const cut_corner& above, float height) {
    const float rise = above.height - below.height;
    const float share = rise > 0 ? clamped((height - below.height) / rise, 0, 1) : 0.0F;
    return {multiply_add(share, above.place.x - below.place.x, below.place.x),
            multiply_add(share, above.place.y - below.place.y, below.place.y)};
}

/// Cuts one face by all slices that it reaches through: emit(slice number, from, to).
template <class Emit>
void cut_face(const slice_frame& frame, const triangle& face, Emit&& emit) {
    const vec3 points[3] = {face.a, face.b, face.c};
    cut_corner corner[3];
    std::uint32_t level[3];
    for (int i = 0; i < 3; ++i) {
        corner[i].height = frame.height_of(points[i]);
        level[i] = frame.level_of(corner[i].height);
    }
    if (level[0] == level[1] && level[1] == level[2]) return;
    for (int i = 0; i < 3; ++i) corner[i].place = frame.place_of(points[i]);
    const std::uint32_t lowest = std::min({level[0], level[1], level[2]});
    const std::uint32_t highest = std::max({level[0], level[1], level[2]});
    for (std::uint32_t slice = lowest; slice < highest; ++slice) {
        const bool above[3] = {level[0] > slice, level[1] > slice, level[2] > slice};
        const int alone = above[1] == above[2] ? 0 : above[0] == above[2] ? 1 : 2; // the corner on a side of its own
        const auto on_edge_to = [&](int other) {
            return above[alone] ? cut_edge(corner[other], corner[alone], frame.height[slice])
                                : cut_edge(corner[alone], corner[other], frame.height[slice]);
        };
        const vec2 from = on_edge_to((alone + 1) % 3), to = on_edge_to((alone + 2) % 3);
        if (is_finite(from.x) && is_finite(from.y) && is_finite(to.x) && is_finite(to.y))
            emit(frame.number[slice], from, to);
    }
}

} // namespace insonify::inline INSONIFY_ABI
#endif
