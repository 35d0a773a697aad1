#ifndef INSONIFY_TRACING_FIND_MIXED_FACES_HPP
#define INSONIFY_TRACING_FIND_MIXED_FACES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/traverse.hpp>
#include <insonify/geometry/face_groups.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/tracing/find/slice_frame.hpp>
#include <insonify/tracing/find/slice_region.hpp>
#include <algorithm>
#include <cstddef>

/// Finds the faces that slices cut, those whose corners differ in level (see `slice_frame`), without a tree or with one.
namespace insonify::inline INSONIFY_ABI::detail {

/// The level of every point, in blocks, by plain loops that the compiler vectorises.
inline void find_levels(const slice_frame& frame, view<const vec3> points, std::uint8_t* levels) {
    constexpr std::size_t few = 512;
    const slice_frame own = frame;             // a copy, which no store can alias
    float x[few], y[few], z[few], height[few]; // from the origin
    for (std::size_t begin = 0; begin < points.size(); begin += few) {
        const std::size_t count = std::min(few, points.size() - begin);
        const vec3* const from = points.data() + begin;
        std::uint8_t* const to = levels + begin;
        for (std::size_t i = 0; i < count; ++i) height[i] = own.height_of(0, from[i]);
        const float first = own.height[0];
        for (std::size_t i = 0; i < count; ++i) to[i] = height[i] > first;
        if (own.count == 1) continue;
        for (std::size_t i = 0; i < count; ++i) {
            x[i] = from[i].x - own.origin.x;
            y[i] = from[i].y - own.origin.y;
            z[i] = from[i].z - own.origin.z;
        }
        for (std::uint32_t slice = 1; slice < own.count; ++slice) {
            const vec3 normal = own.normal[slice];
            for (std::size_t i = 0; i < count; ++i) height[i] = slice_frame::component(normal, x[i], y[i], z[i]);
            const float here = own.height[slice];
            const int bit = 1 << slice;
            for (std::size_t i = 0; i < count; ++i)
                to[i] = static_cast<std::uint8_t>(to[i] | (height[i] > here ? bit : 0));
        }
    }
}

/// Calls visit(i) for the faces of the groups [begin, end) whose corners differ in level. Most groups are on one side of all
/// slices, so the branches predict well.
template <class Visit>
void for_each_mixed(view<const uvec3> faces, const detail::face_groups_view& groups, std::size_t begin, std::size_t end,
                    const std::uint8_t* levels, Visit&& visit) {
    for (std::size_t group = begin; group < end; ++group) {
        const view<const std::uint32_t> vertices = groups[group];
        const unsigned first = levels[vertices[0]];
        unsigned different = 0;
        for (const std::uint32_t vertex : vertices) different |= levels[vertex] ^ first;
        if (different == 0) continue;
        const std::size_t last = std::min((group + 1) * detail::face_groups_view::size, faces.size());
        for (std::size_t i = group * detail::face_groups_view::size; i < last; ++i) {
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
        const std::uint32_t child = tree.nodes[node].child[detail::lowest_bit(left)];
        if (child != no_child) visit(child);
    }
}

/// Calls visit(leaf) for the leaves below a child reference that may overlap the region.
template <class Range, int Width, class Visit>
void for_each_leaf(const bvh_view<Range, Width>& tree, std::uint32_t code, const slice_region& region, Visit&& visit) {
    // So many references are prefetched before they are visited, unless the stack is long: then the traversal goes depth
    // first, where each level adds less than Width references.
    constexpr std::uint32_t prefetched = 8, long_stack = prefetched * Width;
    std::uint32_t stack[long_stack + prefetched * Width + max_stack<Width>], queue[prefetched];
    std::uint32_t count = 0, visited = 0, queued = 0;
    stack[count++] = code;
    for (;;) {
        for (; count > 0 && queued - visited < (count < long_stack ? prefetched : 1); ++queued) {
            const std::uint32_t child = queue[queued % prefetched] = stack[--count];
            tree.prefetch(child);
        }
        if (queued == visited) return;
        const std::uint32_t next = queue[visited++ % prefetched];
        if ((next & leaf_bit) != 0)
            visit(tree.leaves[next ^ leaf_bit]);
        else
            for_each_child(tree, next, region, [&](std::uint32_t child) { stack[count++] = child; });
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
