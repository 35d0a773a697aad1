#ifndef INSONIFY_SCENE_INVERSE_MAP_HPP
#define INSONIFY_SCENE_INVERSE_MAP_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/policy.hpp>
#include <insonify/geometry/pose.hpp>
#include <concepts>
#include <cstddef>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// How a body deforms: a function from each point at rest to where it is now, both in the world, in metres. It must be
/// smooth and must not fold over, and is called from many threads at once.
template <class Map>
concept deformation_map = requires(const Map& map, vec3 rest) {
    { map(rest) } -> std::convertible_to<vec3>;
};

/// A map that brings its inverse, as those of the library do: `rest_of` gives the point at rest of one that is
/// displaced. It replaces Newton's method, and the check that the map does not fold over.
template <class Map>
concept invertible_map = deformation_map<Map> && requires(const Map& map, vec3 now) {
    { map.rest_of(now) } -> std::convertible_to<vec3>;
};

namespace detail {

/// A point as text, in millimetres.
inline std::string point_text(vec3 point) {
    return joined({"(", point.x * 1e3F, ", ", point.y * 1e3F, ", ", point.z * 1e3F, ") mm"});
}

[[noreturn]] inline void throw_folded(vec3 near) {
    throw geometry_error{"deform: the map folds over near ", point_text(near),
                         ": tissue would be turned inside out; displace it by less, or over a longer distance"};
}

/// Where the map puts a point. @throws geometry_error  for a result that is not finite
template <deformation_map Map>
vec3 deformed_point(const Map& map, vec3 rest) {
    const vec3 now = map(rest);
    if (!is_finite(now))
        throw geometry_error{"deform: the map gives a point that is not finite for ", point_text(rest),
                             "; check its formula"};
    return now;
}

/// Derivative of a map at a point at rest, by forward differences.
/// @param now  the point that the map gives
template <deformation_map Map>
mat3 derivative(const Map& map, vec3 rest, vec3 now) {
    constexpr float step = 0x1p-14F; // metres: 0.06 mm
    mat3 columns;
    for (int axis = 0; axis < 3; ++axis) {
        vec3 aside = rest;
        aside[axis] += step;
        columns[axis] = (map(aside) - now) / (aside[axis] - rest[axis]);
    }
    return columns;
}

/// @throws geometry_error  where the map folds over
template <deformation_map Map>
void check_map_at(const Map& map, vec3 rest, vec3 now) {
    if constexpr (!invertible_map<Map>)
        if (!(determinant(derivative(map, rest, now)) > 0)) throw_folded(now);
}

/// Newton's method for points that follow each other: while it converges quickly with the derivative at a former point,
/// none is computed, which takes three more points of the map.
template <deformation_map Map>
class newton_inverse {
  public:
    explicit newton_inverse(const Map& map) : map_{map} {}

    /// Finds the point at rest that the map takes to a point.
    /// @param rest  a guess, then the point
    /// @return      false where the map folds over, or is not finite
    bool operator()(vec3 now, vec3& rest) {
        const float tolerance = 2e-7F + 5e-7F * length(now);
        vec3 reached = map_(rest);
        float error = length(reached - now);
        const auto improve = [&](float part, float largest) { // whether the error is then less than `largest`
            const vec3 next = rest - part * (to_rest_ * (reached - now)), there = map_(next);
            const float remaining = length(there - now);
            if (!(remaining < largest)) return false;
            rest = next;
            reached = there;
            error = remaining;
            return true;
        };
        for (int iteration = 0; iteration < 20 && error > tolerance; ++iteration) {
            if (known_ && improve(1, max(0.25F * error, tolerance))) continue;
            const mat3 slope = derivative(map_, rest, reached);
            known_ = determinant(slope) > 0;
            if (!known_) return false;
            to_rest_ = inverse(slope);
            bool improved = false;
            for (float part = 1; part > 0.01F && !improved; part *= 0.5F) improved = improve(part, error);
            if (!improved) break;
        }
        return is_finite(rest) && error <= 10 * tolerance;
    }

  private:
    const Map& map_;
    mat3 to_rest_{1}; // inverse of the derivative
    bool known_ = false;
};

/// Finds the points at rest that a map takes to points, by its own inverse or by Newton's method: see `newton_inverse`.
template <deformation_map Map>
auto rest_finder(const Map& map) {
    if constexpr (invertible_map<Map>)
        return [&map](vec3 now, vec3& rest) {
            rest = map.rest_of(now);
            return is_finite(rest);
        };
    else
        return newton_inverse<Map>{map};
}
/// The same for a single point.
template <deformation_map Map>
bool find_rest(const Map& map, vec3 now, vec3& rest) {
    return rest_finder(map)(now, rest);
}

/// Nodes at which displacements are wanted: a box in axes of its own.
struct displacement_lattice {
    pose at{};             ///< lattice to world; the first node is at its origin
    vec3 spacing{1, 1, 1}; ///< metres from node to node
    uvec3 size{2, 2, 2};   ///< nodes along each axis, at least 2

    std::size_t count() const { return std::size_t{size.x} * size.y * size.z; }
    /// The nodes in order, x first, in the world.
    vec3 point(std::size_t node) const {
        const std::size_t row = node / size.x;
        return at.point(vec3{node % size.x, row % size.y, row / size.y} * spacing);
    }
};

/// Writes the displacements from now to rest at the nodes of a lattice, in its axes, as `displacement_view` reads them.
/// Where the map folds over, or is not finite, the fourth number of a node is 1, else 0.
template <class Policy, deformation_map Map>
void invert_map(const Policy& policy, const Map& map, const displacement_lattice& where, float* nodes) {
    const std::size_t rows = std::size_t{where.size.y} * where.size.z;
    exec::for_each_block(policy, rows, 4, 1e4F, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            auto find_rest = rest_finder(map);
            vec3 last{0, 0, 0}, change{0, 0, 0};
            for (std::uint32_t i = 0; i < where.size.x; ++i) {
                const vec3 now = where.point(row * where.size.x + i);
                vec3 rest = now + last + change;
                const bool found = find_rest(now, rest) || find_rest(now, rest = now);
                const vec3 displacement = found ? rest - now : last;
                change = i > 0 && found ? displacement - last : vec3{0, 0, 0};
                last = displacement;
                const vec3 own = where.at.local_direction(displacement);
                float* to = nodes + 4 * (row * where.size.x + i);
                to[0] = own.x, to[1] = own.y, to[2] = own.z, to[3] = found ? 0.0F : 1.0F;
            }
        }
    });
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
