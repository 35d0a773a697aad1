#ifndef INSONIFY_SCENE_SLICE_CUT_HPP
#define INSONIFY_SCENE_SLICE_CUT_HPP

#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/scene/slice_frame.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Where a slice goes through a face: the straight way from one of its edges to
/// another, as far as lines cross it.
struct cut_segment {
  vec2 from{0, 0}, to{0, 0}; ///< in the coordinates of the fan
  std::uint32_t first = 0;   ///< the lines that cross it are [first, last)
  std::uint32_t last = 0;
  std::uint32_t slice = 0;     ///< its number
  std::uint32_t object = 0;    ///< index into `scene::objects`
  std::uint32_t primitive = 0; ///< face of the object's mesh
};

/// Where a slice at this height goes through the edge between two corners, one
/// below it or in it and one above.
///
/// Faces that share the edge get the very same point, whichever way they walk
/// it, because it is always walked upwards.
struct cut_corner {
  float height = 0;
  vec2 place{0, 0};
};
inline vec2 cut_edge(const cut_corner &below, const cut_corner &above,
                     float height) {
  const float rise = above.height - below.height;
  const float share =
      rise > 0 ? clamped((height - below.height) / rise, 0, 1) : 0.0F;
  return {multiply_add(share, above.place.x - below.place.x, below.place.x),
          multiply_add(share, above.place.y - below.place.y, below.place.y)};
}

/// Cuts one face by all slices that it reaches through: emit(slice number,
/// from, to).
template <class Emit>
void cut_face(const slice_frame &frame, const triangle &face, Emit &&emit) {
  const vec3 points[3] = {face.a, face.b, face.c};
  cut_corner corner[3];
  std::uint32_t level[3];
  for (int i = 0; i < 3; ++i) {
    corner[i].height = frame.height_of(points[i]);
    level[i] = frame.level_of(corner[i].height);
  }
  if (level[0] == level[1] && level[1] == level[2])
    return;
  for (int i = 0; i < 3; ++i)
    corner[i].place = frame.place_of(points[i]);
  const std::uint32_t lowest = std::min({level[0], level[1], level[2]});
  const std::uint32_t highest = std::max({level[0], level[1], level[2]});
  for (std::uint32_t slice = lowest; slice < highest; ++slice) {
    const bool above[3] = {level[0] > slice, level[1] > slice,
                           level[2] > slice};
    const int alone = above[1] == above[2] ? 0
                      : above[0] == above[2]
                          ? 1
                          : 2; // the corner on a side of its own
    const auto on_edge_to = [&](int other) {
      return above[alone]
                 ? cut_edge(corner[other], corner[alone], frame.height[slice])
                 : cut_edge(corner[alone], corner[other], frame.height[slice]);
    };
    const vec2 from = on_edge_to((alone + 1) % 3),
               to = on_edge_to((alone + 2) % 3);
    if (is_finite(from.x) && is_finite(from.y) && is_finite(to.x) &&
        is_finite(to.y))
      emit(frame.number[slice], from, to);
  }
}

/// All segments that the slices of a frame cut out of a scene. Keeps its memory
/// from frame to frame.
///
/// Objects whose trees are up to date are searched with the region that the
/// lines run through. Of the others every vertex is asked for its level and
/// every face whether those of its corners differ: two linear passes, whatever
/// the number of slices.
class slice_cut {
public:
  /// @param probe_at  the frame in whose plane y = 0 the lines of the fan run
  /// @param offsets   heights of the slices over that plane, metres
  /// @param reach     how far lines are followed, metres
  template <exec::policy Policy>
  void cut(const Policy &policy, const scene &body, const line_fan &fan,
           const pose &probe_at, view<const float> offsets, float reach) {
    plan(body, fan, probe_at, offsets, reach);
    for_each_index(policy, vertex_parts_.size(), [&](std::size_t i) {
      find_levels(body, vertex_parts_[i]);
    });
    const std::size_t grain =
        work_ < pays_for_threads ? face_parts_.size() + 1 : 1;
    exec::for_each_block(policy, face_parts_.size(), grain,
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t i = begin; i < end; ++i)
                             cut_part(body, fan, face_parts_[i], found_[i]);
                         });
  }

  /// Calls visit(segment) for each, in an order that depends on nothing but the
  /// arguments of `cut`.
  template <class Visit> void for_each_segment(Visit &&visit) const {
    for (std::size_t i = 0; i < face_parts_.size(); ++i)
      for (const cut_segment &segment : found_[i])
        visit(segment);
  }

private:
  static constexpr std::uint32_t block =
      8192; // vertices or faces that one thread takes at a time
  static constexpr std::size_t pays_for_threads =
      16384; // faces looked at: below that one thread is faster

  // Work that one thread does: an object's whole tree, or a stretch of its
  // vertices or faces.
  struct part {
    std::uint32_t object = 0;
    std::uint32_t begin = 0, end = 0;
    std::size_t levels = 0; // where those of the object's vertices begin
  };

  void plan(const scene &body, const line_fan &fan, const pose &probe_at,
            view<const float> offsets, float reach) {
    const vec2 apex = fan.apex(), axis = fan.axis();
    const pose upright{
        mat3{{axis.y, 0, -axis.x}, {0, 1, 0}, {axis.x, 0, axis.y}},
        {apex.x, 0, apex.y}};
    region_ = slice_region{.frame = slice_frame{probe_at * upright, offsets}};
    aabb face;
    float nearest = FLT_MAX, furthest = -FLT_MAX;
    for (std::uint32_t i = 0; i < fan.size(); ++i) {
      const auto &line = fan[i];
      nearest = lesser(nearest, line.origin.y);
      furthest = greater(furthest, line.origin.y + reach * line.along.y);
      for (const float offset : offsets)
        face = merged(
            face,
            (probe_at * upright).point({line.origin.x, offset, line.origin.y}));
    }
    const vec3 rounding = 1e-6F * (absolute(face.lower) + absolute(face.upper));
    face = {face.lower - rounding, face.upper + rounding};
    if (fan.is_wedge()) {
      const auto &left = fan[0], &right = fan[fan.size() - 1];
      region_.add_side({-left.along.y, left.along.x}, left.right({0, 0}));
      region_.add_side({right.along.y, -right.along.x}, -right.right({0, 0}));
      region_.add_side({0, -1}, -nearest);
    }
    slice_region above_reach = region_;
    above_reach.add_side({0, 1}, furthest);

    vertex_parts_.clear();
    face_parts_.clear();
    work_ = 0;
    std::size_t levels = 0;
    for (std::uint32_t i = 0; i < body.objects().size(); ++i) {
      const object &one = body.objects()[i];
      // Lines that begin in an object are followed to where they leave it.
      if (!overlaps(overlaps(face, one.box) ? region_ : above_reach, one.box))
        continue;
      const auto vertices =
          static_cast<std::uint32_t>(one.surface.positions.size());
      const auto faces = static_cast<std::uint32_t>(one.surface.faces.size());
      if (one.tree_follows) {
        face_parts_.push_back({.object = i, .end = faces});
        work_ += 256 + 16 * static_cast<std::size_t>(
                                std::sqrt(static_cast<float>(faces)));
        continue;
      }
      for (std::uint32_t begin = 0; begin < vertices; begin += block)
        vertex_parts_.push_back(
            {i, begin, std::min(begin + block, vertices), levels});
      for (std::uint32_t begin = 0; begin < faces; begin += block)
        face_parts_.push_back(
            {i, begin, std::min(begin + block, faces), levels});
      levels += vertices;
      work_ += faces;
    }
    levels_.resize(levels);
    if (found_.size() < face_parts_.size())
      found_.resize(face_parts_.size());
  }

  void find_levels(const scene &body, const part &own) {
    const object &one = body.objects()[own.object];
    const slice_frame frame = region_.frame.local(one.at);
    for (std::size_t begin = own.begin; begin < own.end; begin += few) {
      const std::size_t count = std::min<std::size_t>(few, own.end - begin);
      float height[few];
      heights_of(frame, one.surface.positions.data() + begin, count, height);
      std::uint8_t *const levels = levels_.data() + own.levels + begin;
      for (std::uint32_t slice = 0; slice < frame.count; ++slice)
        add_levels(height, frame.height[slice], slice, count, levels);
    }
  }

  // Plain loops over a few points at a time, which the compiler turns into
  // SIMD.
  static constexpr std::size_t few = 512;
  static void heights_of(const slice_frame frame, const vec3 *points,
                         std::size_t count, float *height) {
    for (std::size_t i = 0; i < count; ++i)
      height[i] = frame.height_of(points[i]);
  }
  static void add_levels(const float *height, float slice_height,
                         std::uint32_t below, std::size_t count,
                         std::uint8_t *levels) {
    if (below == 0)
      for (std::size_t i = 0; i < count; ++i)
        levels[i] = height[i] > slice_height;
    else
      for (std::size_t i = 0; i < count; ++i)
        levels[i] =
            static_cast<std::uint8_t>(levels[i] + (height[i] > slice_height));
  }

  void cut_part(const scene &body, const line_fan &fan, const part &own,
                std::vector<cut_segment> &found) const {
    const object &one = body.objects()[own.object];
    const slice_region region = region_.local(one.at);
    const mesh_view surface{one.surface};
    found.clear();
    const auto cut = [&](std::uint32_t primitive) {
      cut_face(region.frame, surface[primitive],
               [&](std::uint32_t slice, vec2 from, vec2 to) {
                 fan.for_each_crossed(
                     from, to, [&](std::uint32_t first, std::uint32_t last) {
                       found.push_back({from, to, first, last, slice,
                                        own.object, primitive});
                     });
               });
    };
    if (one.tree_follows)
      for_each_leaf(one.tree_view(), region, cut);
    else
      for_each_mixed(surface.faces, own, cut);
  }

  // Faces whose corners differ in level: few, so that the branch is foreseen.
  template <class Visit>
  void for_each_mixed(view<const uvec3> faces, const part &own,
                      Visit &&visit) const {
    const std::uint8_t *const levels = levels_.data() + own.levels;
    for (std::size_t i = own.begin; i < own.end; ++i) {
      const uvec3 corner = faces[i];
      const unsigned a = levels[corner.x], b = levels[corner.y],
                     c = levels[corner.z];
      if (((a ^ b) | (a ^ c)) != 0)
        visit(static_cast<std::uint32_t>(i));
    }
  }

  template <class Tree, class Visit>
  static void for_each_leaf(const Tree &tree, const slice_region &region,
                            Visit &&visit) {
    if (tree.nodes.empty())
      return;
    std::uint32_t stack[Tree::stack_size];
    std::uint32_t waiting = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
      const std::uint32_t node = stack[--waiting];
      for (std::uint32_t left = overlaps(region, tree.bounds_of[node]);
           left != 0; left &= left - 1) {
        const std::uint32_t child = tree.nodes[node].child[lowest_bit(left)];
        if (child == no_child)
          continue;
        if ((child & leaf_bit) == 0) {
          stack[waiting++] = child;
          continue;
        }
        const std::uint32_t *slot =
            tree.slots.first + std::size_t{child ^ leaf_bit} * simd_width;
        for (int k = 0; k < simd_width && slot[k] != no_primitive; ++k)
          visit(slot[k]);
      }
    }
  }

  slice_region region_{};
  std::vector<part> vertex_parts_{}, face_parts_{};
  std::vector<std::uint8_t> levels_{};
  std::vector<std::vector<cut_segment>> found_{};
  std::size_t work_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
