#ifndef INSONIFY_TISSUE_DISPLACEMENT_VIEW_HPP
#define INSONIFY_TISSUE_DISPLACEMENT_VIEW_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/pose.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Displacements of tissue from its present position to rest, on a regular grid and trilinear in between, as lines in
/// one object read them. Beyond the grid they are those at its border. Trivially copyable.
struct displacement_view {
    view<const float> nodes{};     ///< x, y, z in axes of the grid and 0 of each node, metres; x first; empty: at rest
    uvec3 size{2, 2, 2};           ///< nodes along each axis, at least 2
    vec3 per_spacing{1, 1, 1};     ///< nodes per metre along each axis
    pose at{};                     ///< grid to object; the first node is at the origin of the grid
    float straight_length = 1e-3F; ///< metres over which a line counts as straight in tissue at rest
    vec3 offset{0, 0, 0};          ///< added to positions at rest, metres in coordinates of the object

    /// Position at rest of the tissue that is now at a point, both in coordinates of the object.
    INSONIFY_FN vec3 rest(vec3 now) const {
        const cell around = cell_of(now);
        return now + displacement(around.mean([&](unsigned node) { return around.at(node); })) + offset;
    }

    /// Derivative of `rest`: column k is the change of the position at rest along axis k of the object.
    INSONIFY_FN mat3 gradient(vec3 now) const {
        const cell around = cell_of(now);
        mat3 in_grid;
        for (int axis = 0; axis < 3; ++axis) {
            const unsigned next = 1U << axis;
            in_grid[axis] = displacement(around.mean(
                                [&](unsigned node) { return around.at(node | next) - around.at(node & ~next); })) *
                            per_spacing[axis];
        }
        return mat3{1} + in_grid * transpose(at.rotation);
    }

  private:
    using quad = lanes<4>;

    INSONIFY_FN INSONIFY_INLINE static quad mixed(const quad& a, const quad& b, float part) {
        return multiply_add(b - a, quad(part), a);
    }
    INSONIFY_FN INSONIFY_INLINE vec3 displacement(const quad& in_grid) const {
        float each[4];
        store(in_grid, each);
        return at.direction({each[0], each[1], each[2]});
    }

    // The nodes around a point.
    struct cell {
        const float* first;     // of its lowest node
        std::size_t row, layer; // floats from node to node along y and z
        vec3 part;              // of the point, 0 to 1

        // The displacement of a node: bits 0, 1 and 2 say whether it is the further one along x, y and z.
        INSONIFY_FN INSONIFY_INLINE quad at(unsigned node) const {
            return load<4>(first + std::size_t{node & 1U} * 4 + (node >> 1U & 1U) * row + (node >> 2U) * layer);
        }
        // Trilinear between the values of(node).
        template <class Of>
        INSONIFY_FN INSONIFY_INLINE quad mean(const Of& of) const {
            const auto along_x = [&](unsigned node) { return mixed(of(node), of(node + 1), part.x); };
            const auto in_plane = [&](unsigned node) { return mixed(along_x(node), along_x(node + 2), part.y); };
            return mixed(in_plane(0), in_plane(4), part.z);
        }
    };
    INSONIFY_FN INSONIFY_INLINE cell cell_of(vec3 now) const {
        const vec3 place = at.local_point(now) * per_spacing;
        std::size_t lowest[3];
        vec3 part;
        for (int axis = 0; axis < 3; ++axis) {
            const float within = clamp(place[axis], 0, static_cast<float>(size[axis] - 1));
            const auto below = static_cast<std::uint32_t>(within);
            lowest[axis] = below + 1 < size[axis] ? below : size[axis] - 2;
            part[axis] = within - static_cast<float>(lowest[axis]);
        }
        const std::size_t row = 4 * std::size_t{size.x}, layer = row * size.y;
        return {nodes.data() + lowest[2] * layer + lowest[1] * row + 4 * lowest[0], row, layer, part};
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
