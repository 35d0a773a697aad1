#ifndef INSONIFY_TRACING_FIND_SLICE_CUT_HPP
#define INSONIFY_TRACING_FIND_SLICE_CUT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/leaf.hpp>
#include <insonify/bvh/traverse.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <algorithm>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

/// Slices in world or object coordinates. Each is the plane of `across` and `along`, displaced in elevation by an
/// offset and a tilt; positions in it are those in the plane before.
///
/// The level of a point has a bit for each slice below it. A point on a slice counts as below it, as if every slice
/// were shifted upwards by an infinitesimal step.
struct slice_frame {
    vec3 origin{0, 0, 0};
    vec3 across{1, 0, 0};
    vec3 along{0, 0, 1};
    std::uint32_t count = 0;
    vec3 normal[max_elevation_planes] =
        {}; ///< elevation less the slope of the slice times the depth axis: not of length 1
    float height[max_elevation_planes] = {}; ///< along its normal, of the points of a slice above the origin, metres

    slice_frame() = default;

    /// @param probe_at  whose coordinates the planes are in
    /// @param planes    at most `max_elevation_planes`
    /// @param fan       coordinates of positions in the slice plane, to those of the probe
    slice_frame(const pose& probe_at, view<const elevation_plane> planes, const pose& fan = {})
        : count{static_cast<std::uint32_t>(planes.size())} {
        const pose at = probe_at * fan;
        origin = at.translation;
        across = at.rotation[0];
        along = at.rotation[2];
        for (std::uint32_t i = 0; i < count; ++i) {
            normal[i] = at.rotation[1] - planes[i].slope * probe_at.rotation[2];
            height[i] = planes[i].height(fan.translation.z);
        }
    }

    /// The same slices in the coordinates of an object. @param at  object to world
    slice_frame local(const pose& at) const {
        slice_frame l = *this;
        l.origin = at.local_point(origin);
        l.across = at.local_direction(across);
        l.along = at.local_direction(along);
        for (vec3& n : l.normal) n = at.local_direction(n);
        return l;
    }

    /// Component along an axis of a point relative to the origin; bit-equal for every copy of a point, scalar or in
    /// SIMD.
    template <class Float>
    INSONIFY_INLINE Float component_of(vec3 axis, const Float& x, const Float& y, const Float& z) const {
        return multiply_add(Float(axis.x), x - Float(origin.x),
                            multiply_add(Float(axis.y), y - Float(origin.y), Float(axis.z) * (z - Float(origin.z))));
    }
    /// Height of a point along the normal of a slice.
    float height_of(std::uint32_t slice, vec3 p) const { return component_of(normal[slice], p.x, p.y, p.z); }
    vec2 place_of(vec3 p) const { return {component_of(across, p.x, p.y, p.z), component_of(along, p.x, p.y, p.z)}; }
};

/// A half space that bounds a region.
struct region_side {
    vec3 outwards{0, 0, 0};
    float limit = 0;     ///< upper bound of dot(outwards, p - origin) for points inside
    vec2 in_slice{0, 0}; ///< `outwards` across and along the slices
};
/// The part of the slices that lines cover: no line crosses what lies beyond one of its sides.
struct slice_region {
    slice_frame frame{};
    region_side sides[4] = {};
    std::uint32_t side_count = 0;

    slice_region() = default;

    /// Between the first and the last line, beyond their origins, of any depth.
    /// @param beside  metres by which it is larger, to all sides
    slice_region(const slice_frame& slices, const line_fan& fan, float beside = 0) : frame{slices} {
        if (!fan.is_wedge()) return;
        const auto &left = fan[0], &right = fan[fan.size() - 1];
        add_side({-left.along.y, left.along.x}, left.right({0, 0}) + beside);
        add_side({right.along.y, -right.along.x}, -right.right({0, 0}) + beside);
        add_side({0, -1}, -fan.extent().min.y + beside);
    }

    /// The same for lines of this length, metres.
    slice_region within(float length, const line_fan& fan) const {
        slice_region near_part = *this;
        near_part.add_side({0, 1}, fan.extent().max.y + length * fan.extent().max_cosine);
        return near_part;
    }

    void add_side(vec2 outwards, float limit) {
        sides[side_count++] = {outwards.x * frame.across + outwards.y * frame.along, limit, outwards};
    }

    /// Whether a segment, in coordinates of the slices, lies beyond one of the sides.
    bool is_outside(vec2 from, vec2 to) const {
        return std::any_of(sides, sides + side_count, [&](const region_side& s) {
            return dot(s.in_slice, from) > s.limit && dot(s.in_slice, to) > s.limit;
        });
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

/// One corner of each of N triangles, in the coordinates of a slice frame.
template <int N>
struct slice_corner {
    lanes<N> height{}, across{}, along{};
};

/// Lanes of `a` where the mask is set, of `b` elsewhere.
template <int N>
INSONIFY_INLINE slice_corner<N> select_corner(const lane_mask<N>& mask, const slice_corner<N>& a,
                                              const slice_corner<N>& b) {
    return {select(mask, a.height, b.height), select(mask, a.across, b.across), select(mask, a.along, b.along)};
}

/// The points of the edges from `below` to `above` at a height.
///
/// Edges are always interpolated upwards, so that faces that share an edge compute exactly the same point.
template <int N>
INSONIFY_INLINE slice_corner<N> cut_edges(const slice_corner<N>& below, const slice_corner<N>& above, float height) {
    const lanes<N> zero(0.0F), one(1.0F), rise = above.height - below.height;
    const lanes<N> fraction = (lanes<N>(height) - below.height) / select(zero < rise, rise, one);
    const lanes<N> within = min(max(fraction, zero), one);
    return {lanes<N>(height), multiply_add(within, above.across - below.across, below.across),
            multiply_add(within, above.along - below.along, below.along)};
}

/// Intersects the triangles of a leaf with the slices that separate their corners: emit(slice number, a bit for each
/// triangle that the slice cuts, from, to).
template <class Range, int Width, class Emit>
INSONIFY_INLINE void cut_faces(const slice_frame& frame, const leaf<Range, Width>& triangles, const Emit& emit) {
    using floats = lanes<Width>;
    slice_corner<Width> corner[3];
    const auto component = [&](int c, vec3 axis) {
        const auto row = [&](int k) { return load<Width>(triangles.corner[c][k]); };
        return frame.component_of(axis, row(0), row(1), row(2));
    };
    bool placed = false;
    for (std::uint32_t slice = 0; slice < frame.count; ++slice) {
        for (int c = 0; c < 3; ++c) corner[c].height = component(c, frame.normal[slice]);
        const floats here(frame.height[slice]);
        const auto a = here < corner[0].height, b = here < corner[1].height, c = here < corner[2].height;
        std::uint32_t mixed = ((bits_of(a) ^ bits_of(b)) | (bits_of(a) ^ bits_of(c))) & triangles.usable();
        if (mixed == 0) continue;
        if (!placed) {
            for (int k = 0; k < 3; ++k) {
                corner[k].across = component(k, frame.across);
                corner[k].along = component(k, frame.along);
            }
            placed = true;
        }
        // The corner that is alone on its side, and the two that follow it.
        const auto first = (b && c) || !(b || c), second = (a && c) || !(a || c);
        const auto turned = [&](int by) {
            return select_corner<Width>(first, corner[by],
                                        select_corner<Width>(second, corner[(by + 1) % 3], corner[(by + 2) % 3]));
        };
        const slice_corner<Width> alone = turned(0);
        const auto up = here < alone.height;
        const auto cut_towards = [&](const slice_corner<Width>& other) {
            return cut_edges(select_corner<Width>(up, other, alone), select_corner<Width>(up, alone, other),
                             frame.height[slice]);
        };
        const slice_corner<Width> from = cut_towards(turned(1)), to = cut_towards(turned(2));
        mixed &=
            bits_of(floats(0.0F) <= floats_of<Width>(not_finite<Width>(from.across) | not_finite<Width>(from.along) |
                                                     not_finite<Width>(to.across) | not_finite<Width>(to.along)));
        if (mixed != 0) emit(slice, mixed, from, to);
    }
}

/// The level of every point.
inline void find_levels(const slice_frame& frame, view<const vec3> points, std::uint8_t* levels) {
    const slice_frame own = frame; // a copy, which no store can alias
    for (std::size_t i = 0; i < points.size(); ++i) {
        unsigned level = 0;
        for (std::uint32_t slice = 0; slice < own.count; ++slice)
            level |= unsigned{own.height_of(slice, points[i]) > own.height[slice]} << slice;
        levels[i] = static_cast<std::uint8_t>(level);
    }
}

/// Calls visit(i) for the faces of the groups [begin, end) whose corners differ in level. Most groups are on one side
/// of all slices, so the branches predict well.
template <class Visit>
void for_each_mixed(view<const uvec3> faces, const face_groups_view& groups, std::size_t begin, std::size_t end,
                    const std::uint8_t* levels, Visit&& visit) {
    for (std::size_t group = begin; group < end; ++group) {
        const view<const std::uint32_t> vertices = groups[group];
        const unsigned first = levels[vertices[0]];
        unsigned different = 0;
        for (const std::uint32_t vertex : vertices) different |= levels[vertex] ^ first;
        if (different == 0) continue;
        const std::size_t last = std::min((group + 1) * face_groups_view::size, faces.size());
        for (std::size_t i = group * face_groups_view::size; i < last; ++i) {
            const uvec3 corner = faces[i];
            const unsigned a = levels[corner.x], b = levels[corner.y], c = levels[corner.z];
            if (((a ^ b) | (a ^ c)) != 0) visit(static_cast<std::uint32_t>(i));
        }
    }
}

/// Calls visit(child reference) for the children of a node that may overlap the region; see node.hpp.
template <class Range, int Width, class Visit>
INSONIFY_INLINE void for_each_child(const bvh_view<Range, Width>& tree, std::uint32_t node, const slice_region& region,
                                    Visit&& visit) {
    const float* const side = tree.nodes[node].sides;
    const auto row = [&](std::ptrdiff_t k) { return load<Width>(side + k * Width); };
    const lanes<Width> lower[3] = {row(0), row(1), row(2)}, upper[3] = {row(3), row(4), row(5)};
    for (std::uint32_t left = overlaps(region, lower, upper); left != 0; left &= left - 1) {
        const std::uint32_t child = tree.nodes[node].child[lowest_bit(left)];
        if (child != no_child) visit(child);
    }
}

/// Calls visit(leaf) for the leaves below a child reference that may overlap the region.
template <class Range, int Width, class Visit>
void for_each_leaf(const bvh_view<Range, Width>& tree, std::uint32_t code, const slice_region& region, Visit&& visit) {
    std::uint32_t stack[max_stack<Width>], count = 0;
    stack[count++] = code;
    while (count > 0) {
        const std::uint32_t next = stack[--count];
        if ((next & leaf_bit) != 0) {
            visit(tree.leaves[next ^ leaf_bit]);
            continue;
        }
        for_each_child(tree, next, region, [&](std::uint32_t child) {
            tree.prefetch(child);
            stack[count++] = child;
        });
    }
}

/// The intersection of a slice with a face: the segment from one of its edges to another, and the lines that cross it.
struct cut_segment {
    vec2 from{0, 0}, to{0, 0}; ///< in the coordinates of the fan
    std::uint32_t first = 0;   ///< the lines that cross it are [first, last)
    std::uint32_t last = 0;
    bool again = false;          ///< the same segment as the one before, with other lines
    std::uint32_t slice = 0;     ///< its number
    std::uint32_t object = 0;    ///< rank of the object
    std::uint32_t primitive = 0; ///< face of the object's mesh
};

/// A segment, to be sorted by depth, so that the crossings of each line are nearly sorted.
struct deep_segment {
    float depth = 0; ///< the sum of its ends'
    const cut_segment* segment = nullptr;

    explicit deep_segment(const cut_segment& one) : depth{one.from.y + one.to.y}, segment{&one} {}
    friend bool operator<(const deep_segment& a, const deep_segment& b) { return a.depth < b.depth; }
};

/// Which segments are kept beside those that the lines of a fan cross, for other lines: between the first and the last
/// of a wider fan, from the same point, shifted along the face by at most a distance.
struct outer_lines {
    bool keep_all = false;         ///< all between the first and the last line
    const line_fan* fan = nullptr; ///< the wider one; null: none
    float shift = 0;               ///< metres
};

/// All segments in which the slices of a frame intersect a scene. Keeps its memory from frame to frame.
///
/// Trees that are up to date are traversed with the region that the lines cover. For the other objects two linear
/// passes compute the level of every vertex and compare levels in every group of faces, whatever the number of slices.
class slice_cut {
  public:
    /// @param chosen    for each object, whether it is to be cut
    /// @param probe_at  the frame in whose plane y = 0 the lines of the fan run
    /// @param planes    the slices
    /// @param max_depth  how far lines are followed, metres
    /// @param beyond     lines that segments are kept for, too
    template <exec::policy Policy>
    void cut(const Policy& policy, const scene_view& scene, view<const std::uint8_t> chosen, const line_fan& fan,
             const pose& probe_at, view<const elevation_plane> planes, float max_depth, const outer_lines& beyond) {
        keep_all_ = beyond.keep_all;
        plan(scene, chosen, fan, probe_at, planes, max_depth, beyond);
        exec::for_each_block(policy, vertex_parts_.size(), 1, 0.5F * block, [&](std::size_t i, std::size_t) {
            const part& own = vertex_parts_[i];
            const object_view& one = scene.objects[own.object];
            find_levels(own.region->frame.local(one.at),
                        {one.surface.positions.data() + own.begin, own.end - own.begin},
                        levels_.data() + own.levels + own.begin);
        });
        const float nanoseconds = 5 * static_cast<float>(work_) / static_cast<float>(face_parts_.size() + 1);
        exec::for_each_block(policy, face_parts_.size(), 1, nanoseconds,
                             [&](std::size_t i, std::size_t) { cut_part(scene, fan, face_parts_[i], found_[i]); });
    }

    /// Calls visit(segment) for each segment, in an order that depends on the arguments of `cut` alone.
    template <class Visit>
    void for_each_segment(Visit&& visit) const {
        for (std::size_t i = 0; i < face_parts_.size(); ++i)
            for (const cut_segment& segment : found_[i]) visit(segment);
    }

  private:
    static constexpr std::uint32_t block = 8192; // vertices or faces that one thread processes at a time
    static constexpr std::uint32_t groups_of_block = block / face_groups_view::size;
    static constexpr std::size_t max_subtrees = 32; // that one object's tree is divided into, roughly

    // A work item: a subtree of an object, or a range of its vertices or groups of faces.
    struct part {
        const slice_region* region = nullptr;
        std::uint32_t object = 0;
        std::uint32_t begin = 0, end = 0; // the reference of the subtree in `begin`; or a range
        std::size_t levels = 0;           // offset of the object's vertex levels
    };

    // Collects the work items, in the order in which `for_each_segment` visits their results.
    void plan(const scene_view& scene, view<const std::uint8_t> chosen, const line_fan& fan, const pose& probe_at,
              view<const elevation_plane> planes, float max_depth, const outer_lines& beyond) {
        const float beside = beyond.shift;
        aabb face; // of the probe
        for (const elevation_plane& plane : planes)
            for (const float x : {fan.extent().min.x - beside, fan.extent().max.x + beside})
                for (const float y : {fan.extent().min.y - beside, fan.extent().max.y + beside}) {
                    const vec3 corner = fan.upright().point({x, 0, y});
                    face = merged(face, probe_at.point({corner.x, plane.height(corner.z), corner.z}));
                }
        const vec3 rounding = 1e-6F * (abs(face.lower) + abs(face.upper));
        face = {face.lower - rounding, face.upper + rounding};
        const line_fan& widest = beyond.fan != nullptr ? *beyond.fan : fan;
        unbounded_ = {slice_frame{probe_at, planes, fan.upright()}, widest, beside};
        within_depth_ = unbounded_.within(max_depth + beside, fan);

        vertex_parts_.clear();
        face_parts_.clear();
        work_ = 0;
        std::size_t levels = 0;
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
            if (chosen[i] == 0) continue;
            const object_view& one = scene.objects[i];
            // Lines that start inside an object are followed until they leave it.
            const slice_region& region = overlaps(face, one.box) ? unbounded_ : within_depth_;
            if (!overlaps(region, one.box)) continue;
            const auto vertices = static_cast<std::uint32_t>(one.surface.positions.size());
            const auto faces = static_cast<std::uint32_t>(one.surface.faces.size());
            if (one.tree_is_current) {
                add_subtrees(one, i, region);
                work_ += 16 * static_cast<std::size_t>(std::sqrt(static_cast<float>(faces)));
                continue;
            }
            for (std::uint32_t begin = 0; begin < vertices; begin += block)
                vertex_parts_.push_back({&region, i, begin, std::min(begin + block, vertices), levels});
            const auto groups = static_cast<std::uint32_t>(one.groups.count());
            for (std::uint32_t begin = 0; begin < groups; begin += groups_of_block)
                face_parts_.push_back({&region, i, begin, std::min(begin + groups_of_block, groups), levels});
            levels += vertices;
            work_ += faces;
        }
        levels_.resize(levels);
        if (found_.size() < face_parts_.size()) found_.resize(face_parts_.size());
    }

    // Divides the tree of an object, level by level, into subtrees for several threads.
    void add_subtrees(const object_view& one, std::uint32_t index, const slice_region& region) {
        const bvh_view<mesh_view>& tree = one.tree;
        if (tree.nodes.empty()) return;
        const slice_region local = region.local(one.at);
        subtrees_.assign(1, 0);
        bool divisible = one.surface.faces.size() >= block;
        while (divisible && subtrees_.size() < max_subtrees / 2) {
            divisible = false;
            below_.clear();
            for (const std::uint32_t code : subtrees_) {
                if ((code & leaf_bit) != 0) {
                    below_.push_back(code);
                    continue;
                }
                divisible = true;
                for_each_child(tree, code, local, [&](std::uint32_t child) { below_.push_back(child); });
            }
            subtrees_.swap(below_);
        }
        for (const std::uint32_t code : subtrees_) face_parts_.push_back({&region, index, code});
    }

    void cut_part(const scene_view& scene, const line_fan& fan, const part& own,
                  std::vector<cut_segment>& found) const {
        const object_view& one = scene.objects[own.object];
        const slice_region region = own.region->local(one.at);
        found.clear();
        const auto cut = [&](const auto& faces) {
            using corner = slice_corner<simd_width>;
            const auto keep = [&](std::uint32_t slice, std::uint32_t cut_ones, const corner& from, const corner& to) {
                float ends[4][simd_width];
                const lanes<simd_width>* const of_ends[4] = {&from.across, &from.along, &to.across, &to.along};
                for (int i = 0; i < 4; ++i) store(*of_ends[i], ends[i]);
                const auto places_from = fan.places_of(from.across, from.along);
                const auto places_to = fan.places_of(to.across, to.along);
                for (; cut_ones != 0; cut_ones &= cut_ones - 1) {
                    const std::uint32_t i = lowest_bit(cut_ones);
                    const vec2 p{ends[0][i], ends[1][i]}, q{ends[2][i], ends[3][i]};
                    cut_segment segment{
                        .from = p, .to = q, .slice = slice, .object = own.object, .primitive = faces.primitive[i]};
                    fan.for_each_crossed(p, fan.gap(places_from, i), q, fan.gap(places_to, i),
                                         [&](std::uint32_t first, std::uint32_t last) {
                                             segment.first = first;
                                             segment.last = last;
                                             found.push_back(segment);
                                             segment.again = true;
                                         });
                    // Not what the boxes of a tree may happen to bring along: it is the same with and without trees.
                    if (keep_all_ && !segment.again && !region.is_outside(p, q)) found.push_back(segment);
                }
            };
            cut_faces(region.frame, faces, keep);
        };
        if (one.tree_is_current) {
            for_each_leaf(one.tree, own.begin, region, cut);
        } else {
            const mesh_view& surface = one.surface;
            leaf<mesh_view, simd_width> faces;
            std::uint32_t slots[simd_width], held = 0;
            const auto cut_held = [&] {
                std::fill(slots + held, slots + simd_width, no_primitive);
                faces.fill(surface, slots);
                cut(faces);
                held = 0;
            };
            for_each_mixed(surface.faces, one.groups, own.begin, own.end, levels_.data() + own.levels,
                           [&](std::uint32_t primitive) {
                               slots[held++] = primitive;
                               if (held == simd_width) cut_held();
                           });
            if (held > 0) cut_held();
        }
    }

    bool keep_all_ = false;
    slice_region unbounded_{}, within_depth_{};
    std::vector<part> vertex_parts_, face_parts_;
    std::vector<std::uint32_t> subtrees_, below_;
    std::vector<std::uint8_t> levels_;
    std::vector<std::vector<cut_segment>> found_;
    std::size_t work_ = 0; // faces to be tested, roughly
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
