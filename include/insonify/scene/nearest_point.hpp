#ifndef INSONIFY_SCENE_NEAREST_POINT_HPP
#define INSONIFY_SCENE_NEAREST_POINT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/traverse.hpp>
#include <insonify/geometry/mesh.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// The point of a triangle that is nearest to p. Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
INSONIFY_FN inline vec3 nearest_on(const triangle& t, vec3 p) {
    const vec3 ab = t.b - t.a, ac = t.c - t.a;
    const float d1 = dot(ab, p - t.a), d2 = dot(ac, p - t.a);
    if (d1 <= 0 && d2 <= 0) return t.a;
    const float d3 = dot(ab, p - t.b), d4 = dot(ac, p - t.b);
    if (d3 >= 0 && d4 <= d3) return t.b;
    const float d5 = dot(ab, p - t.c), d6 = dot(ac, p - t.c);
    if (d6 >= 0 && d5 <= d6) return t.c;
    const auto along = [](vec3 from, vec3 edge, float part, float whole) {
        return whole > 0 ? from + (part / whole) * edge : from;
    };
    const float by_c = d1 * d4 - d3 * d2, by_b = d5 * d2 - d1 * d6, by_a = d3 * d6 - d5 * d4;
    if (by_c <= 0 && d1 >= 0 && d3 <= 0) return along(t.a, ab, d1, d1 - d3);
    if (by_b <= 0 && d2 >= 0 && d6 <= 0) return along(t.a, ac, d2, d2 - d6);
    if (by_a <= 0 && d4 >= d3 && d5 >= d6) return along(t.b, t.c - t.b, d4 - d3, (d4 - d3) + (d5 - d6));
    const float sum = by_a + by_b + by_c;
    return sum > 0 ? t.a + (by_b / sum) * ab + (by_c / sum) * ac : t.a;
}

/// The point of a mesh that is nearest to another point.
struct nearest_point {
    float distance_squared = FLT_MAX; ///< m^2
    std::uint32_t primitive = ~0U;    ///< face; ~0 where there is none
    vec3 point{0, 0, 0};              ///< on the face
};

/// Squared distance from a point to a box; 0 inside.
INSONIFY_FN inline float distance_squared(const aabb& box, vec3 p) {
    const vec3 outside = p - min(max(p, box.lower), box.upper);
    return dot(outside, outside);
}

/// Searches a tree of triangles by branch and bound; of equally near faces the lowest. @param p  in the tree's coordinates
template <int Width>
INSONIFY_FN nearest_point find_nearest(const bvh_view<mesh_view, Width>& tree, vec3 p) {
    nearest_point best;
    if (tree.nodes.empty()) return best;
    std::uint32_t stack[max_stack<Width>], count = 0;
    float bound[max_stack<Width>];
    stack[count] = 0;
    bound[count++] = 0;
    while (count > 0) {
        const std::uint32_t code = stack[--count];
        if (bound[count] > best.distance_squared) continue;
        if ((code & leaf_bit) != 0) {
            for (const std::uint32_t face : tree.leaves[code ^ leaf_bit].primitive) {
                if (face == no_primitive) continue;
                const vec3 on = nearest_on(tree.range[face], p);
                const float squared = dot(p - on, p - on);
                if (squared < best.distance_squared || (squared == best.distance_squared && face < best.primitive))
                    best = {squared, face, on};
            }
            continue;
        }
        const std::uint32_t first = count;
        for (int i = 0; i < Width; ++i) {
            const std::uint32_t child = tree.nodes[code].child[i];
            const float squared = child == no_child ? FLT_MAX : distance_squared(tree.nodes[code].box(i), p);
            if (child == no_child || squared > best.distance_squared) continue;
            std::uint32_t place = count++; // sorted, so that the nearest child is visited next
            for (; place > first && bound[place - 1] < squared; --place) {
                bound[place] = bound[place - 1];
                stack[place] = stack[place - 1];
            }
            bound[place] = squared;
            stack[place] = child;
        }
    }
    return best;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
