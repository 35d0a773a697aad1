#ifndef INSONIFY_SCENE_MIXED_FACES_HPP
#define INSONIFY_SCENE_MIXED_FACES_HPP

#include <insonify/bvh/traverse.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/scene/face_groups.hpp>
#include <insonify/scene/slice_frame.hpp>
#include <insonify/scene/slice_region.hpp>
#include <cstddef>

/// Which faces go through slices: those whose corners differ in level (see `slice_frame`).
namespace insonify::inline INSONIFY_ABI {

/// The level of every point, a few at a time, by plain loops that the compiler turns into SIMD.
INSONIFY_LAZY void find_levels(const slice_frame& frame, view<const vec3> points, std::uint8_t* levels) {
    constexpr std::size_t few = 512;
    const slice_frame own = frame; // which nothing else writes into
    float height[few];
    for (std::size_t begin = 0; begin < points.size(); begin += few) {
        const std::size_t count = std::min(few, points.size() - begin);
        const vec3* const from = points.data() + begin;
        std::uint8_t* const to = levels + begin;
        for (std::size_t i = 0; i < count; ++i) height[i] = own.height_of(from[i]);
        const float lowest = own.height[0];
        for (std::size_t i = 0; i < count; ++i) to[i] = height[i] > lowest;
        for (std::uint32_t slice = 1; slice < own.count; ++slice) {
            const float here = own.height[slice];
            for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<std::uint8_t>(to[i] + (height[i] > here));
        }
    }
}

/// Calls visit(i) for the faces of the groups [begin, end) whose corners differ in level: few, so that branches are
/// foreseen.
template <class Visit>
void for_each_mixed(view<const uvec3> faces, const face_groups& groups, std::size_t begin, std::size_t end,
                    const std::uint8_t* levels, Visit&& visit) {
    for (std::size_t group = begin; group < end; ++group) {
        const view<const std::uint32_t> vertices = groups[group];
        const unsigned first = levels[vertices[0]];
        unsigned different = 0;
        for (const std::uint32_t vertex : vertices) different |= levels[vertex] ^ first;
        if (different == 0) continue;
        const std::size_t last = std::min((group + 1) * face_groups::size, faces.size());
        for (std::size_t i = group * face_groups::size; i < last; ++i) {
            const uvec3 corner = faces[i];
            const unsigned a = levels[corner.x], b = levels[corner.y], c = levels[corner.z];
            if (((a ^ b) | (a ^ c)) != 0) visit(static_cast<std::uint32_t>(i));
        }
    }
}

/// The children of a node that may reach into the slices: visit(code), see node.hpp.
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

/// The leaves below `code` that may reach into the slices: visit(leaf).
template <class Range, int Width, class Visit>
void for_each_leaf(const bvh_view<Range, Width>& tree, std::uint32_t code, const slice_region& region, Visit&& visit) {
    // So many are asked for before they are looked at, unless many wait: then, one branch after the other, each level adds
    // less than Width to those that wait.
    constexpr std::uint32_t ahead = 8, many = ahead * Width;
    std::uint32_t stack[many + ahead * Width + most_waiting<Width>], coming[ahead];
    std::uint32_t waiting = 0, taken = 0, asked = 0;
    stack[waiting++] = code;
    for (;;) {
        for (; waiting > 0 && asked - taken < (waiting < many ? ahead : 1); ++asked) {
            const std::uint32_t child = coming[asked % ahead] = stack[--waiting];
            tree.prefetch(child);
        }
        if (asked == taken) return;
        const std::uint32_t next = coming[taken++ % ahead];
        if ((next & leaf_bit) != 0)
            visit(tree.leaves[next ^ leaf_bit]);
        else
            for_each_child(tree, next, region, [&](std::uint32_t child) { stack[waiting++] = child; });
    }
}

} // namespace insonify::inline INSONIFY_ABI
#endif
