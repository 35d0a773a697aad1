#ifndef INSONIFY_GEOMETRY_IMPLICIT_HPP
#define INSONIFY_GEOMETRY_IMPLICIT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/ray.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Optional arguments of `mesh_implicit`.
struct implicit_settings {
    /// Upper bound of the slope of the function, such as 1 for a distance in metres: where the function is too large
    /// for a surface nearby it is then not called, which is many times faster. 0: unknown.
    float max_slope = 0;
};

namespace detail {

/// A body-centred cubic lattice: the corners of cubes, and their middles. Four tetrahedra surround the line between the
/// middles of two cubes that share a face; all are congruent.
class implicit_lattice {
  public:
    implicit_lattice(const aabb& box, float cell, function_ref<float(vec3)> function)
        : box_{box}, cell_{cell}, function_{function} {
        constexpr double max_points = 1 << 27;
        double points = 2;
        for (int axis = 0; axis < 3; ++axis) {
            const double cubes = std::ceil(static_cast<double>(box.size()[axis]) / static_cast<double>(cell)) + 2;
            points *= cubes + 1;
            if (points > max_points)
                throw geometry_error{"mesh_implicit: a box of ",
                                     box.size().x,
                                     " x ",
                                     box.size().y,
                                     " x ",
                                     box.size().z,
                                     " m has too many cells of ",
                                     cell,
                                     " m; at most 2^26 are possible: give a larger `cell` or a smaller box"};
            count_[axis] = static_cast<std::uint32_t>(cubes) + 1;
        }
        // One layer of cubes around the box.
        origin_ = box.centre() - 0.5F * cell * vec3{count_ - 1U};
        step_[0] = 1;
        step_[1] = count_.x;
        step_[2] = std::size_t{count_.x} * count_.y;
        middles_ = step_[2] * count_.z;
    }

    /// The mesh of {f < 0}, f the function within the box and positive outside.
    mesh surface(float max_slope) {
        values_.assign(2 * middles_, cell_);
        for (std::uint32_t z = 0; z < count_.z; z += coarse)
            for (std::uint32_t y = 0; y < count_.y; y += coarse)
                for (std::uint32_t x = 0; x < count_.x; x += coarse) sample({x, y, z}, coarse, max_slope);

        newest_.assign(2 * middles_, none);
        for (std::uint32_t z = 0; z + 1 < count_.z; ++z)
            for (std::uint32_t y = 0; y + 1 < count_.y; ++y)
                for (std::uint32_t x = 0; x + 1 < count_.x; ++x) cut_cube({x, y, z});
        std::vector<vec3> on_edges;
        for (const cut& edge : cuts_) {
            on_edges.push_back(place_on(edge));
            result_.positions.push_back(leaves_box(edge) ? on_edges.back() : moved_to_surface(edge, on_edges.back()));
        }
        undo_folds(on_edges);
        return std::move(result_);
    }

  private:
    static constexpr std::uint32_t none = ~0U, coarse = 32, fine = 4;
    struct cut {
        std::size_t from = 0, to = 0; ///< lattice points
        std::uint32_t before = none;  ///< the cut made before it on an edge from the same point
    };

    std::size_t index_of(uvec3 at) const { return at.x + step_[1] * at.y + step_[2] * at.z; }
    vec3 position_of(std::size_t point) const {
        const bool middle = point >= middles_;
        const std::size_t corner = middle ? point - middles_ : point;
        const vec3 at{static_cast<float>(corner % count_.x), static_cast<float>(corner / count_.x % count_.y),
                      static_cast<float>(corner / step_[2])};
        return origin_ + cell_ * (at + vec3{middle ? 0.5F : 0.0F});
    }

    float value_of(vec3 p) const {
        const float value = function_(p);
        if (!is_finite(value))
            throw geometry_error{"mesh_implicit: the function gives NaN or an infinite value at {",
                                 p.x,
                                 ", ",
                                 p.y,
                                 ", ",
                                 p.z,
                                 "}; it must be finite in the whole box"};
        return value;
    }
    // Distance from the box, metres; below 0 inside.
    float border_at(vec3 p) const {
        const vec3 outside = max(box_.lower - p, p - box_.upper);
        return max(max(outside.x, outside.y), outside.z);
    }
    // Above 0 outside of the box, which cuts bodies off.
    float value_at(vec3 p) const {
        const float border = border_at(p);
        return border >= 0 ? max(border, 1e-6F * cell_) : value_of(p);
    }

    // The function at all points of a block of cubes; where no surface is near, that in its middle.
    void sample(uvec3 first, std::uint32_t size, float max_slope) {
        if (first.x >= count_.x || first.y >= count_.y || first.z >= count_.z) return;
        const uvec3 end{std::min(first.x + size, count_.x), std::min(first.y + size, count_.y),
                        std::min(first.z + size, count_.z)};
        if (max_slope > 0) {
            // Beyond the points of the block, the slope at a vertex needs its neighbours' values.
            const float radius = 0.8660254F * static_cast<float>(size) + 3;
            const vec3 middle = origin_ + cell_ * (vec3{first} + vec3{0.5F * static_cast<float>(size)});
            const vec3 inside = max(box_.lower, min(box_.upper, middle));
            const float extent = radius * cell_ + length(middle - inside), value = value_of(inside);
            // What is negative ends at the border of the box, which is then sampled.
            const vec3 to_border = min(middle - box_.lower, box_.upper - middle);
            const bool border_is_far = min(min(to_border.x, to_border.y), to_border.z) > extent;
            if (std::fabs(value) > max_slope * extent && (value > 0 || border_is_far)) {
                for (std::uint32_t z = first.z; z < end.z; ++z)
                    for (std::uint32_t y = first.y; y < end.y; ++y) {
                        const std::size_t row = index_of({0, y, z});
                        for (const std::size_t kind : {std::size_t{0}, middles_})
                            std::fill(values_.begin() + static_cast<std::ptrdiff_t>(kind + row + first.x),
                                      values_.begin() + static_cast<std::ptrdiff_t>(kind + row + end.x), value);
                    }
                return;
            }
            if (size > fine) {
                const std::uint32_t half = size / 2;
                for (std::uint32_t i = 0; i < 8; ++i)
                    sample(first + half * uvec3{i & 1U, i >> 1U & 1U, i >> 2U}, half, max_slope);
                return;
            }
        }
        for (std::uint32_t z = first.z; z < end.z; ++z)
            for (std::uint32_t y = first.y; y < end.y; ++y)
                for (std::uint32_t x = first.x; x < end.x; ++x)
                    for (const std::size_t kind : {std::size_t{0}, middles_}) {
                        const std::size_t point = kind + index_of({x, y, z});
                        values_[point] = value_at(position_of(point));
                    }
    }

    bool is_inside(std::size_t point) const { return values_[point] < 0; }

    // The tetrahedra around the three lines from the middle of a cube to those of the next ones.
    void cut_cube(uvec3 at) {
        const std::size_t corner = index_of(at), middle = middles_ + corner;
        for (int axis = 0; axis < 3; ++axis) {
            if (at[axis] + 2 >= count_[axis]) continue;
            const std::size_t next = middle + step_[axis], u = step_[(axis + 1) % 3], v = step_[(axis + 2) % 3];
            const std::size_t base = corner + step_[axis], square[4] = {base, base + u, base + u + v, base + v};
            const bool inside = is_inside(middle);
            if (inside == is_inside(next) && inside == is_inside(square[0]) && inside == is_inside(square[1]) &&
                inside == is_inside(square[2]) && inside == is_inside(square[3]))
                continue;
            for (int i = 0; i < 4; ++i) cut_tetrahedron({middle, next, square[i], square[(i + 1) % 4]});
        }
    }

    // Corners 1, 2 and 3 are counter-clockwise seen from the side away from corner 0.
    void cut_tetrahedron(std::array<std::size_t, 4> c) {
        int inside = 0;
        for (const std::size_t point : c) inside += is_inside(point) ? 1 : 0;
        if (inside == 0 || inside == 4) return;
        // Even permutations keep the orientation.
        const auto rotate_front = [&](int to_front) { // this corner becomes the first
            constexpr int even[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};
            const auto old = c;
            for (int i = 0; i < 4; ++i)
                c[static_cast<std::size_t>(i)] = old[static_cast<std::size_t>(even[to_front][i])];
        };
        if (inside != 2) {
            const bool sought = inside == 1;
            int single = 0;
            while (is_inside(c[static_cast<std::size_t>(single)]) != sought) ++single;
            rotate_front(single);
            const std::uint32_t a = vertex_on(c[0], c[1]), b = vertex_on(c[0], c[2]), d = vertex_on(c[0], c[3]);
            result_.faces.push_back(sought ? uvec3{a, b, d} : uvec3{a, d, b});
            return;
        }
        int first = 0;
        while (!is_inside(c[static_cast<std::size_t>(first)])) ++first;
        rotate_front(first);
        while (!is_inside(c[1])) { // the cyclic permutation of the other three is even
            const std::size_t moved = c[1];
            c[1] = c[2];
            c[2] = c[3];
            c[3] = moved;
        }
        const std::uint32_t p = vertex_on(c[0], c[2]), q = vertex_on(c[0], c[3]), r = vertex_on(c[1], c[3]),
                            s = vertex_on(c[1], c[2]);
        // The diagonal of the quadrilateral that the values place nearer to its middle.
        if (std::fabs(part_of({c[0], c[2]}) - part_of({c[1], c[3]})) <
            std::fabs(part_of({c[0], c[3]}) - part_of({c[1], c[2]})))
            result_.faces.insert(result_.faces.end(), {{p, q, r}, {p, r, s}});
        else
            result_.faces.insert(result_.faces.end(), {{p, q, s}, {q, r, s}});
    }

    // The vertex of an edge, made where there is none yet: one for all tetrahedra around it.
    std::uint32_t vertex_on(std::size_t a, std::size_t b) {
        const std::size_t from = std::min(a, b), to = std::max(a, b);
        for (std::uint32_t known = newest_[from]; known != none; known = cuts_[known].before)
            if (cuts_[known].to == to) return known;
        const auto made = static_cast<std::uint32_t>(cuts_.size());
        cuts_.push_back({from, to, std::exchange(newest_[from], made)});
        return made;
    }

    // Where the surface cuts an edge. Not too near its ends: triangles there would have no area.
    float part_of(cut edge) const {
        constexpr float margin = 0.1F;
        const float a = values_[edge.from], b = values_[edge.to];
        return clamp(a / (a - b), margin, 1 - margin);
    }
    vec3 slope_at(std::size_t point) const {
        const std::size_t corner = point >= middles_ ? point - middles_ : point;
        const std::size_t at[3] = {corner % count_.x, corner / count_.x % count_.y, corner / step_[2]};
        vec3 slope{0, 0, 0};
        for (int axis = 0; axis < 3; ++axis) {
            const bool has_before = at[axis] > 0, has_after = at[axis] + 1 < count_[axis];
            const float before = values_[has_before ? point - step_[axis] : point];
            const float after = values_[has_after ? point + step_[axis] : point];
            slope[axis] = (after - before) / (cell_ * static_cast<float>(has_before + has_after));
        }
        return slope;
    }
    vec3 slope_of(cut edge) const {
        return slope_at(edge.from) + part_of(edge) * (slope_at(edge.to) - slope_at(edge.from));
    }
    bool leaves_box(cut edge) const {
        return border_at(position_of(edge.from)) >= 0 || border_at(position_of(edge.to)) >= 0;
    }
    // Where the surface cuts an edge, by linear interpolation. On an edge that leaves the box it lies before the box,
    // or on it where the box cuts a body off.
    vec3 place_on(cut edge) const {
        const vec3 a = position_of(edge.from), b = position_of(edge.to);
        if (!leaves_box(edge)) return a + part_of(edge) * (b - a);
        const float u = border_at(a), v = border_at(b);
        const vec3 inside = u < 0 ? a : b, on_box = a + u / (u - v) * (b - a);
        const float within = values_[u < 0 ? edge.from : edge.to], limit = value_of(on_box);
        return limit < 0 ? on_box : inside + within / (within - limit) * (on_box - inside);
    }
    // A step of Newton's method from the edge to the surface, along the slope of the sampled values. Where these do not
    // resolve the function, as in a part thinner than two cells, that slope contradicts the values along the edge.
    vec3 moved_to_surface(cut edge, vec3 start) const {
        constexpr float max_step = 0.3F;  // of a cell
        constexpr float max_error = 0.5F; // of the slope
        const float value = value_at(start);
        const vec3 slope = slope_of(edge), steepness = abs(slope);
        const float largest = max(max(steepness.x, steepness.y), steepness.z);
        if (!(largest > 0)) return start;
        const vec3 along = slope / largest; // its square neither overflows nor vanishes
        const vec3 across = position_of(edge.to) - position_of(edge.from);
        const float error = dot(along, across) - (values_[edge.to] - values_[edge.from]) / largest;
        if (!(std::fabs(error) <= max_error * length(along) * length(across))) return start;
        vec3 step = -value / largest / dot(along, along) * along;
        if (const float size = length(step); size > max_step * cell_) step *= max_step * cell_ / size;
        return std::fabs(value_at(start + step)) < std::fabs(value) ? start + step : start;
    }
    // Where the surface bends more sharply than the lattice resolves, the steps of neighbours can turn a face away from
    // the slope, so that it crosses others. Its vertices return to their edges: there, each tetrahedron contains its
    // own faces.
    void undo_folds(const std::vector<vec3>& on_edges) {
        constexpr float min_cosine = 0.65F; // of the angle between normal and slope
        std::vector<vec3> slopes;
        for (const cut& edge : cuts_) {
            const vec3 slope = slope_of(edge), steepness = abs(slope);
            const float largest = max(max(steepness.x, steepness.y), steepness.z);
            slopes.push_back(largest > 0 ? normalize(slope / largest) : vec3{0});
        }
        for (bool any = true; any;) {
            any = false;
            for (const uvec3 f : result_.faces) {
                const vec3 a = result_.positions[f.x], b = result_.positions[f.y], c = result_.positions[f.z];
                const dvec3 normal = cross(dvec3{b} - dvec3{a}, dvec3{c} - dvec3{a});
                const dvec3 slope{slopes[f.x] + slopes[f.y] + slopes[f.z]};
                if (dot(normal, slope) >= static_cast<double>(min_cosine) * length(normal) * length(slope)) continue;
                for (const std::uint32_t corner : {f.x, f.y, f.z}) {
                    any = any || result_.positions[corner] != on_edges[corner];
                    result_.positions[corner] = on_edges[corner];
                }
            }
        }
    }

    aabb box_;
    float cell_ = 1;
    function_ref<float(vec3)> function_;
    uvec3 count_{0, 0, 0}; // of the corners of cubes; as many middles are stored, of which the last are not used
    vec3 origin_{0, 0, 0};
    std::size_t step_[3] = {};
    std::size_t middles_ = 0; // index of the first middle
    std::vector<float> values_{};
    std::vector<std::uint32_t> newest_{}; // of the cuts of edges that begin at a lattice point
    std::vector<cut> cuts_{};             // of each vertex
    mesh result_{};
};

} // namespace detail

/// The closed surface of {p in the box: function(p) < 0}, oriented outwards.
///
///     const mesh ball = mesh_implicit([](vec3 p) { return length(p) - 8_mm; }, {vec3{-9_mm}, vec3{9_mm}}, 1_mm,
///                                     {.max_slope = 1});
///
/// Where the function is negative at the border of the box the surface is closed by the box. Parts thinner than a cell
/// may be missed. The surface is found by marching tetrahedra on a body-centred cubic lattice, so every edge has two
/// faces whatever the function; each vertex is then moved onto it by one step of Newton's method, and is off by a
/// quantity of second order in the cell. Where the cells do not resolve the function, steps that would make faces cross
/// are left out. About 13 triangles for each square of the size of a cell.
/// @param function  float(vec3), continuous, finite in the whole box; best about a distance in metres
/// @param box       metres; the function is not called outside
/// @param cell      edge of the lattice's cubes, metres
/// @throws geometry_error  for a box that is empty or not finite, a cell that is not above 0, more than 2^26 cells, and
/// a value that is not finite
/// Source: Doi & Koide 1991, IEICE Trans. Inf. Syst. 74, 214 (tetrahedra); Treece, Prager & Gee 1999, Computers &
/// Graphics 23, 583 (on this lattice, without nearly empty triangles).
template <class Function>
mesh mesh_implicit(const Function& function, const aabb& box, float cell, const implicit_settings& settings = {}) {
    const vec3 size = box.size();
    if (!is_finite(box) || !(min(min(size.x, size.y), size.z) > 0) ||
        max(abs(box.lower), abs(box.upper)) != min(max(abs(box.lower), abs(box.upper)), vec3{1e6F}))
        throw geometry_error{
            "mesh_implicit: the box is empty or not finite; its `upper` must exceed its `lower`, within 1000 km of "
            "the origin"};
    if (!(cell > 0) || !is_finite(cell))
        throw geometry_error{"mesh_implicit: `cell` is ", cell, "; it must be a length above 0, such as 1_mm"};
    if (!(settings.max_slope >= 0) || !is_finite(settings.max_slope))
        throw geometry_error{"mesh_implicit: `max_slope` is ", settings.max_slope,
                             "; it must be 0 (unknown) or a bound of the slope, such as 1 for distances"};
    const auto called = [&function](vec3 p) { return static_cast<float>(function(p)); };
    return detail::implicit_lattice{box, cell, called}.surface(settings.max_slope);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
