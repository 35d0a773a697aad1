#ifndef INSONIFY_SCENE_SLICE_REGION_HPP
#define INSONIFY_SCENE_SLICE_REGION_HPP

#include <insonify/geometry/aabb.hpp>
#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/slice_frame.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The part of the slices that lines run through: what lies beyond one of its sides matters to none.
struct region_side {
    vec3 outwards{0, 0, 0};
    float limit = 0; ///< dot(outwards, p - origin) of points within is at most this
};
struct slice_region {
    slice_frame frame{};
    region_side sides[4] = {};
    std::uint32_t side_count = 0;

    slice_region() = default;

    /// What lies between the first and the last line and before none of their origins, however far away.
    INSONIFY_LAZY slice_region(const slice_frame& slices, const line_fan& fan) : frame{slices} {
        if (!fan.is_wedge()) return;
        const auto &left = fan[0], &right = fan[fan.size() - 1];
        add_side({-left.along.y, left.along.x}, left.right({0, 0}));
        add_side({right.along.y, -right.along.x}, -right.right({0, 0}));
        add_side({0, -1}, -fan.extent().least.y);
    }

    /// The same, as far as lines of this length reach.
    INSONIFY_LAZY slice_region within(float reach, const line_fan& fan) const {
        slice_region near_part = *this;
        near_part.add_side({0, 1}, fan.extent().most.y + reach * fan.extent().straightest);
        return near_part;
    }

    INSONIFY_LAZY void add_side(vec2 outwards, float limit) {
        sides[side_count++] = {outwards.x * frame.across + outwards.y * frame.along, limit};
    }

    /// The same region as an object sees it that stands in the world as `at` says.
    INSONIFY_LAZY slice_region local(const pose& at) const {
        slice_region l = *this;
        l.frame = frame.local(at);
        for (region_side& s : l.sides) s.outwards = at.local_direction(s.outwards);
        return l;
    }
};

/// A bit for each box that may reach into one of the slices within the region; never 0 for one that does.
template <class Lanes>
INSONIFY_INLINE std::uint32_t overlaps(const slice_region& region, const Lanes (&lower)[3], const Lanes (&upper)[3]) {
    const float origin[3] = {region.frame.origin.x, region.frame.origin.y, region.frame.origin.z};
    Lanes centre[3], half[3], room(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
        half[axis] = Lanes(0.5F) * upper[axis] - Lanes(0.5F) * lower[axis];
        centre[axis] = Lanes(0.5F) * upper[axis] + Lanes(0.5F) * lower[axis] - Lanes(origin[axis]);
        room = room + absolute(centre[axis]) + half[axis] + Lanes(std::fabs(origin[axis]));
    }
    room = Lanes(1e-6F) * room; // for the rounding of all that follows
    const auto distance = [&](vec3 n) {
        return Lanes(n.x) * centre[0] + Lanes(n.y) * centre[1] + Lanes(n.z) * centre[2];
    };
    const auto reach = [&](vec3 n) {
        return Lanes(std::fabs(n.x)) * half[0] + Lanes(std::fabs(n.y)) * half[1] + Lanes(std::fabs(n.z)) * half[2] +
               room;
    };
    const Lanes height = distance(region.frame.elevation), thickness = reach(region.frame.elevation);
    std::uint32_t met = 0;
    for (std::uint32_t i = 0; i < region.frame.count; ++i)
        met |= bits_of(absolute(height - Lanes(region.frame.height[i])) <= thickness);
    for (std::uint32_t i = 0; i < region.side_count && met != 0; ++i) {
        const region_side& s = region.sides[i];
        met &= bits_of(distance(s.outwards) - reach(s.outwards) <= Lanes(s.limit));
    }
    return met;
}

/// The same for one box.
INSONIFY_LAZY bool overlaps(const slice_region& region, const aabb& box) {
    using floats = lanes<simd_width>;
    const floats lower[3] = {floats(box.lower.x), floats(box.lower.y), floats(box.lower.z)};
    const floats upper[3] = {floats(box.upper.x), floats(box.upper.y), floats(box.upper.z)};
    return !box.empty() && overlaps(region, lower, upper) != 0;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
