#ifndef INSONIFY_TRACING_FIND_SLICE_REGION_HPP
#define INSONIFY_TRACING_FIND_SLICE_REGION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/aabb.hpp>
#include <insonify/probe/line_fan.hpp>
#include <insonify/tracing/find/slice_frame.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// A half space that bounds a region.
struct region_side {
    vec3 outwards{0, 0, 0};
    float limit = 0; ///< upper bound of dot(outwards, p - origin) for points inside
};
/// The part of the slices that lines cover: no line crosses what lies beyond one of its sides.
struct slice_region {
    slice_frame frame{};
    region_side sides[4] = {};
    std::uint32_t side_count = 0;

    slice_region() = default;

    /// Between the first and the last line, beyond their origins, of any depth.
    /// @param beside  metres by which it is larger, to all sides
    slice_region(const slice_frame& slices, const detail::line_fan& fan, float beside = 0) : frame{slices} {
        if (!fan.is_wedge()) return;
        const auto &left = fan[0], &right = fan[fan.size() - 1];
        add_side({-left.along.y, left.along.x}, left.right({0, 0}) + beside);
        add_side({right.along.y, -right.along.x}, -right.right({0, 0}) + beside);
        add_side({0, -1}, -fan.extent().min.y + beside);
    }

    /// The same for lines of this length, metres.
    slice_region within(float length, const detail::line_fan& fan) const {
        slice_region near_part = *this;
        near_part.add_side({0, 1}, fan.extent().max.y + length * fan.extent().max_cosine);
        return near_part;
    }

    void add_side(vec2 outwards, float limit) {
        sides[side_count++] = {outwards.x * frame.across + outwards.y * frame.along, limit};
    }

    /// The same region in the coordinates of an object. @param at  object to world
    slice_region local(const pose& at) const {
        slice_region l = *this;
        l.frame = frame.local(at);
        for (region_side& s : l.sides) s.outwards = at.local_direction(s.outwards);
        return l;
    }
};

/// A bit for each box that may overlap one of the slices within the region. Conservative: rounding never misses one.
template <class Lanes>
INSONIFY_INLINE std::uint32_t overlaps(const slice_region& region, const Lanes (&lower)[3], const Lanes (&upper)[3]) {
    const float origin[3] = {region.frame.origin.x, region.frame.origin.y, region.frame.origin.z};
    Lanes centre[3], half[3], margin(0.0F);
    for (int axis = 0; axis < 3; ++axis) {
        half[axis] = Lanes(0.5F) * upper[axis] - Lanes(0.5F) * lower[axis];
        centre[axis] = Lanes(0.5F) * upper[axis] + Lanes(0.5F) * lower[axis] - Lanes(origin[axis]);
        margin = margin + abs(centre[axis]) + half[axis] + Lanes(std::fabs(origin[axis]));
    }
    margin = Lanes(1e-6F) * margin; // for rounding errors of what follows
    const auto distance = [&](vec3 n) {
        return Lanes(n.x) * centre[0] + Lanes(n.y) * centre[1] + Lanes(n.z) * centre[2];
    };
    const auto half_extent = [&](vec3 n) {
        return Lanes(std::fabs(n.x)) * half[0] + Lanes(std::fabs(n.y)) * half[1] + Lanes(std::fabs(n.z)) * half[2] +
               margin;
    };
    std::uint32_t overlapping = 0;
    for (std::uint32_t i = 0; i < region.frame.count; ++i) {
        const vec3 normal = region.frame.normal[i];
        overlapping |= bits_of(abs(distance(normal) - Lanes(region.frame.height[i])) <= half_extent(normal));
    }
    for (std::uint32_t i = 0; i < region.side_count && overlapping != 0; ++i) {
        const region_side& s = region.sides[i];
        overlapping &= bits_of(distance(s.outwards) - half_extent(s.outwards) <= Lanes(s.limit));
    }
    return overlapping;
}

/// The same for one box.
inline bool overlaps(const slice_region& region, const aabb& box) {
    using floats = lanes<simd_width>;
    const floats lower[3] = {floats(box.lower.x), floats(box.lower.y), floats(box.lower.z)};
    const floats upper[3] = {floats(box.upper.x), floats(box.upper.y), floats(box.upper.z)};
    return !box.empty() && overlaps(region, lower, upper) != 0;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
