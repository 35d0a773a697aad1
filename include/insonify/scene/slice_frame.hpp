#ifndef INSONIFY_SCENE_SLICE_FRAME_HPP
#define INSONIFY_SCENE_SLICE_FRAME_HPP

#include <algorithm>
#include <insonify/bvh/node.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/pose.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Parallel slices, in the coordinates of whatever they cut: `across` and
/// `along` span them, `elevation` is their normal.
///
/// A point has the level n where n slices lie below it. One in a slice lies
/// below it, as if every slice stood an infinitesimal step higher.
struct slice_frame {
  static constexpr std::uint32_t most = 8;

  vec3 origin{0, 0, 0};
  vec3 across{1, 0, 0};
  vec3 elevation{0, 1, 0};
  vec3 along{0, 0, 1};
  std::uint32_t count = 0;
  float height[most] = {}; ///< of the slices over the origin, ascending, metres
  std::uint32_t number[most] = {}; ///< what the caller calls them

  slice_frame() = default;

  /// @param offsets  heights of the slices in the caller's order, `most` at
  /// most
  slice_frame(const pose &at, view<const float> offsets)
      : origin{at.translation}, across{at.rotation[0]},
        elevation{at.rotation[1]}, along{at.rotation[2]},
        count{static_cast<std::uint32_t>(offsets.size())} {
    for (std::uint32_t i = 0; i < count; ++i)
      number[i] = i;
    std::sort(number, number + count, [&](std::uint32_t a, std::uint32_t b) {
      return offsets[a] < offsets[b];
    });
    for (std::uint32_t i = 0; i < count; ++i)
      height[i] = offsets[number[i]];
  }

  /// The same slices as an object sees them that stands in the world as `at`
  /// says.
  slice_frame local(const pose &at) const {
    slice_frame l = *this;
    l.origin = at.local_point(origin);
    l.across = at.local_direction(across);
    l.elevation = at.local_direction(elevation);
    l.along = at.local_direction(along);
    return l;
  }

  /// Every copy of a point gets the very same result.
  float height_of(vec3 p) const { return component(elevation, p); }
  vec2 place_of(vec3 p) const {
    return {component(across, p), component(along, p)};
  }

  std::uint32_t level_of(float point_height) const {
    std::uint32_t level = 0;
    for (std::uint32_t i = 0; i < count; ++i)
      level += point_height > height[i];
    return level;
  }

private:
  float component(vec3 axis, vec3 p) const {
    const float x = p.x - origin.x, y = p.y - origin.y, z = p.z - origin.z;
    return multiply_add(axis.x, x, multiply_add(axis.y, y, axis.z * z));
  }
};

/// The part of the slices that lines run through: what lies beyond one of its
/// sides matters to none.
struct region_side {
  vec3 outwards{0, 0, 0};
  float limit =
      0; ///< dot(outwards, p - origin) of points within is at most this
};
struct slice_region {
  slice_frame frame{};
  region_side sides[4] = {};
  std::uint32_t side_count = 0;

  void add_side(vec2 outwards, float limit) {
    sides[side_count++] = {outwards.x * frame.across + outwards.y * frame.along,
                           limit};
  }

  /// The same region as an object sees it that stands in the world as `at`
  /// says.
  slice_region local(const pose &at) const {
    slice_region l = *this;
    l.frame = frame.local(at);
    for (region_side &s : l.sides)
      s.outwards = at.local_direction(s.outwards);
    return l;
  }
};

/// A bit for each box of a node that may reach into one of the slices within
/// the region; never 0 for one that does.
template <int Width>
INSONIFY_INLINE std::uint32_t overlaps(const slice_region &region,
                                       const node_bounds<Width> &bounds) {
  using floats = lanes<Width>;
  floats centre[3], half[3], room(0.0F);
  for (int axis = 0; axis < 3; ++axis) {
    const floats lower = load<Width>(bounds.side[0][axis]),
                 upper = load<Width>(bounds.side[1][axis]);
    const floats origin(region.frame.origin[axis]);
    centre[axis] = floats(0.5F) * lower + floats(0.5F) * upper - origin;
    half[axis] = floats(0.5F) * upper - floats(0.5F) * lower;
    room = room + absolute(origin) + absolute(centre[axis]) + half[axis];
  }
  room = floats(1e-6F) * room; // for the rounding of all that follows
  const auto distance = [&](vec3 n) {
    return floats(n.x) * centre[0] + floats(n.y) * centre[1] +
           floats(n.z) * centre[2];
  };
  const auto reach = [&](vec3 n) {
    const vec3 size = absolute(n);
    return floats(size.x) * half[0] + floats(size.y) * half[1] +
           floats(size.z) * half[2] + room;
  };
  const floats height = distance(region.frame.elevation),
               thickness = reach(region.frame.elevation);
  std::uint32_t met = 0;
  for (std::uint32_t i = 0; i < region.frame.count; ++i)
    met |=
        bits_of(absolute(height - floats(region.frame.height[i])) <= thickness);
  for (std::uint32_t i = 0; i < region.side_count && met != 0; ++i) {
    const region_side &s = region.sides[i];
    met &= bits_of(distance(s.outwards) - reach(s.outwards) <= floats(s.limit));
  }
  return met;
}

/// The same for one box.
inline bool overlaps(const slice_region &region, const aabb &box) {
  node_bounds<simd_width> one{};
  one.set_box(0, box);
  return !box.empty() && (overlaps(region, one) & 1U) != 0;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
