#ifndef INSONIFY_TISSUE_FIBRES_HPP
#define INSONIFY_TISSUE_FIBRES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/tissue/structure.hpp>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// The direction of the fibres of an object, in its coordinates and of any length: one for all, or a function of the
/// point.
///
///     body.add(surface, tissue::muscle, {.fibres = {1, 0, 0}});
///     body.add(surface, tissue::muscle, {.fibres = [](vec3 p) { return vec3{1, 0, 4 * p.x}; }});
class fibre_directions {
  public:
    fibre_directions() = default;                   ///< none: the axis of the mesh
    fibre_directions(vec3 along) : along_{along} {} ///< one for all; 0: the axis of the mesh
    /// The same by its components.
    template <class X, class Y, class Z>
    fibre_directions(X x, Y y, Z z) : along_{x, y, z} {}
    /// A function of the point, metres. It must be continuous, and defined in the whole box around the object.
    template <class Function>
    fibre_directions(Function function) requires std::is_invocable_r_v<vec3, const Function&, vec3>
        : own_{std::make_shared<const Function>(std::move(function))}, call_{[](const void* own, vec3 point) -> vec3 {
            return (*static_cast<const Function*>(own))(point);
        }} {}

    /// Whether it is a function.
    bool varies() const { return call_ != nullptr; }
    /// At a point, in coordinates of the object.
    vec3 operator()(vec3 point) const { return varies() ? call_(own_.get(), point) : along_; }

  private:
    vec3 along_{0, 0, 0};
    std::shared_ptr<const void> own_{};
    vec3 (*call_)(const void*, vec3) = nullptr;
};

/// The layers of an object are parallel to its surface: see `layer_normals`.
struct own_surface {};

/// The direction across the layers of an object, the z of its `structure`, in its coordinates and of any length: one
/// for all, a function of the point, or the normal of its surface, continued smoothly inwards.
///
///     body.add(surface, tissue::fat, {.layer_normal = {0, 0, 1}});
///     body.add(surface, tissue::fat, {.layer_normal = own_surface{}}); // septa run around the limb
class layer_normals : public fibre_directions {
  public:
    using fibre_directions::fibre_directions;              ///< none, or 0: where the mesh is flattest
    layer_normals(own_surface) : follows_surface_{true} {} ///< of the surface of an object that is no thin sheet

    /// Whether it is that of the surface.
    bool follows_surface() const { return follows_surface_; }
    /// Whether it differs from point to point.
    bool varies() const { return follows_surface_ || fibre_directions::varies(); }

  private:
    bool follows_surface_ = false;
};

namespace detail {

/// Eigenvectors of a symmetric matrix as columns, by descending eigenvalue. Eigenvalues that are equal within the
/// rounding of vertices, as those of cubes and spheres are, do not turn the axes: compilers round differently.
/// Source: the cyclic Jacobi method; Golub & Van Loan, Matrix Computations, section 8.5.
template <class Deferred = void>
mat3 principal_axes(dmat3 m) {
    const double rounding = 1e-6 * (std::fabs(m[0][0]) + std::fabs(m[1][1]) + std::fabs(m[2][2])); // of float vertices
    dmat3 v{1};
    for (int sweep = 0; sweep < 12; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (std::fabs(m[q][p]) <= rounding) continue;
                const double angle = (m[q][q] - m[p][p]) / (2 * m[q][p]);
                const double t = (angle < 0 ? -1 : 1) / (std::fabs(angle) + std::sqrt(angle * angle + 1));
                const double c = 1 / std::sqrt(t * t + 1), s = t * c;
                const auto turn = [&](dmat3& columns) {
                    const dvec3 a = columns[p], b = columns[q];
                    columns[p] = c * a - s * b;
                    columns[q] = s * a + c * b;
                };
                for (int side = 0; side < 2; ++side) {
                    turn(m);
                    m = transpose(m);
                }
                turn(v);
            }
    int order[3] = {0, 1, 2};
    for (const int i : {0, 1, 0})
        if (m[order[i]][order[i]] + rounding < m[order[i + 1]][order[i + 1]]) std::swap(order[i], order[i + 1]);
    return mat3{vec3{v[order[0]]}, vec3{v[order[1]]}, vec3{v[order[2]]}};
}

/// Covariance of the volume that a closed surface encloses, times that volume. Each face adds its tetrahedron with the
/// middle of the box; outside the surface these cancel.
template <class Deferred = void>
dmat3 volume_covariance(const mesh_view& surface, const aabb& box) {
    dmat3 second{0};
    dvec3 first{0, 0, 0};
    double volume = 0;
    const dvec3 middle{box.centre()};
    for (std::size_t i = 0; i < surface.size(); ++i) {
        const triangle face = surface[i];
        const dvec3 a = dvec3{face.a} - middle, b = dvec3{face.b} - middle, c = dvec3{face.c} - middle, sum = a + b + c;
        const double own = dot(a, cross(b, c)) / 6;
        for (const dvec3& corner : {a, b, c, sum}) second += outerProduct(own / 20 * corner, corner);
        first += 0.25 * own * sum;
        volume += own;
    }
    if (volume != 0) second += outerProduct(-1 / volume * first, first);
    return volume < 0 ? -second : second;
}

/// The axes with the first one along `fibres`, if that is not 0, and the last one as it was, as far as possible.
inline mat3 aligned(const mat3& axes, vec3 fibres) {
    if (fibres == vec3{0, 0, 0}) return axes;
    const vec3 along = normalize(fibres);
    const vec3 flat = axes[2] - dot(axes[2], along) * along, other = axes[1] - dot(axes[1], along) * along;
    const vec3 upright = normalize(dot(flat, flat) > 0.1F ? flat : other);
    return mat3{along, cross(upright, along), upright};
}

/// The same, with the last axis along `normal`, if that is not 0. Without fibres the first one stays as it was, as far
/// as possible. The middle one never points against the one before, so that it is continuous around a limb.
inline mat3 aligned(const mat3& axes, vec3 fibres, vec3 normal) {
    if (normal == vec3{0, 0, 0}) return aligned(axes, fibres);
    const vec3 across = normalize(normal);
    const auto in_layer = [&](vec3 v) { return v - dot(v, across) * across; };
    const bool first_lies_in = dot(in_layer(axes[0]), in_layer(axes[0])) > 0.1F;
    mat3 own = aligned(mat3{axes[0], axes[1], across},
                       fibres != vec3{0, 0, 0} ? fibres : in_layer(first_lies_in ? axes[0] : axes[1]));
    if (dot(own[1], axes[1]) < 0) own[1] = -own[1];
    return own;
}

/// The axes of an object's moments of inertia, the longest first; of its box where it encloses nothing.
template <class Deferred = void>
mat3 axes_of(const mesh_view& surface, const aabb& box) {
    dmat3 moments = volume_covariance(surface, box);
    const double trace = moments[0][0] + moments[1][1] + moments[2][2];
    for (int i = 0; i < 3 && !(trace > 0 && trace < 1e30); ++i) {
        moments[i] = {0, 0, 0};
        moments[i][i] = box.empty() ? -i : static_cast<double>(box.size()[i]);
    }
    return principal_axes(moments);
}

/// Coordinates in which the fibres of an object are straight.
///
/// Each coordinate c is the least-squares solution of grad c = t and, with a greater weight, of f . grad c = f . t in
/// all cells of a grid: f is the direction of the fibres, t for x is f, for z the flattest axis made orthogonal to f,
/// for y orthogonal to both. So sheets contain the fibres, as far as such sheets exist, and distances are kept as far
/// as possible.
/// Source: conjugate gradients for least squares; Bjorck, Numerical Methods for Least Squares Problems, section 7.4.
template <class Deferred = void>
class fibre_grid {
  public:
    fibre_grid() = default; ///< of straight fibres

    /// @param box  of the surface
    template <class Policy>
    fibre_grid(const Policy& policy, const fibre_directions& fibres, const layer_normals& layers,
               const mesh_view& surface, const aabb& box) {
        if (!(fibres.varies() || layers.varies()) || box.empty()) return;
        const vec3 size = max(box.size(), vec3{1e-4F});
        spacing_ = std::fmax(std::cbrt(size.x * size.y * size.z / max_cells), 0.5e-3F);
        for (int i = 0; i < 3; ++i) count_[i] = static_cast<std::uint32_t>(std::ceil(size[i] / spacing_)) + 2;
        origin_ = box.centre() - 0.5F * spacing_ * vec3{count_ - 1U};
        const mat3 axes = axes_of(surface, box);
        const std::vector<vec3> normals = layers.follows_surface() ? normals_inside(surface) : std::vector<vec3>{};
        std::vector<mat3> targets(cells());
        for (std::size_t cell = 0; cell < targets.size(); ++cell) {
            const vec3 centre = node_position(first_node(cell)) + vec3{0.5F * spacing_};
            const auto direction = [&](const fibre_directions& own, const char* name) {
                const vec3 found = own(max(box.lower, min(centre, box.upper)));
                if (!is_finite(found) || (own.varies() && !(length(found) > 0)))
                    throw geometry_error{
                        "scene: `", name,
                        "` of an object is a function that returns 0 or a direction that is not finite; it must "
                        "return a direction in the whole box around the object"};
                return found;
            };
            targets[cell] = aligned(axes, direction(fibres, "fibres"),
                                    normals.empty() ? direction(layers, "layer_normal") : normals[cell]);
        }
        nodes_.resize(std::size_t{count_.x} * count_.y * count_.z);
        const equations all = equations_of(targets);
        exec::for_each_block(policy, 3, 1, 1e8F, [&](std::size_t coordinate, std::size_t) {
            solve(all, start_of(targets, static_cast<int>(coordinate)), static_cast<int>(coordinate));
        });
    }

    fibre_chart view_of() const { return {nodes_, count_, origin_, spacing_}; }

  private:
    static constexpr float max_cells = 8000, weight = 100; // of the equation along the fibres
    static constexpr float damping = 0.1F;                 // of twists, which the equations do not determine

    std::size_t cells() const { return std::size_t{count_.x - 1} * (count_.y - 1) * (count_.z - 1); }
    std::size_t first_node(std::size_t cell) const {
        const std::size_t x = cell % (count_.x - 1), rest = cell / (count_.x - 1);
        return x + count_.x * (rest % (count_.y - 1) + count_.y * (rest / (count_.y - 1)));
    }
    vec3 node_position(std::size_t node) const {
        const std::size_t rest = node / count_.x;
        return origin_ + spacing_ * vec3{static_cast<float>(node % count_.x), static_cast<float>(rest % count_.y),
                                         static_cast<float>(rest / count_.y)};
    }
    // The normal of the surface at each cell: the mean of the normals of its faces, where there are any, and elsewhere
    // continued by Laplace's equation.
    std::vector<vec3> normals_inside(const mesh_view& surface) const {
        constexpr int sweeps = 60; // of Gauss-Seidel: three times the cells along one axis
        const uvec3 size = count_ - 1U;
        std::vector<vec3> normals(cells(), vec3{0, 0, 0});
        std::vector<float> areas(cells(), 0.0F);
        for (std::size_t i = 0; i < surface.size(); ++i) {
            const triangle face = surface[i];
            const vec3 place = ((face.a + face.b + face.c) / 3.0F - origin_) / spacing_;
            const uvec3 at{min(max(place, vec3{0}), vec3{size - 1U})};
            const std::size_t cell = at.x + size.x * (at.y + std::size_t{size.y} * at.z);
            normals[cell] += area_vector(face);
            areas[cell] += length(area_vector(face));
        }
        std::vector<std::uint8_t> is_given(cells());
        for (std::size_t cell = 0; cell < normals.size(); ++cell) {
            // Where both sides of a thin object lie in one cell their normals cancel.
            is_given[cell] = length(normals[cell]) > 0.5F * areas[cell];
            normals[cell] = is_given[cell] ? normalize(normals[cell]) : vec3{0, 0, 0};
        }
        for (int sweep = 0; sweep < sweeps; ++sweep)
            for (std::size_t cell = 0, z = 0; z < size.z; ++z)
                for (std::size_t y = 0; y < size.y; ++y)
                    for (std::size_t x = 0; x < size.x; ++x, ++cell) {
                        if (is_given[cell]) continue;
                        const auto beside = [&](std::size_t i, std::size_t count, std::size_t stride) {
                            return normals[i > 0 ? cell - stride : cell] +
                                   normals[i + 1 < count ? cell + stride : cell];
                        };
                        normals[cell] = (beside(x, size.x, 1) + beside(y, size.y, size.x) +
                                         beside(z, size.z, std::size_t{size.x} * size.y)) /
                                        6.0F;
                    }
        for (vec3& normal : normals) normal = length(normal) > 1e-6F ? normalize(normal) : vec3{0, 0, 0};
        return normals;
    }

    static constexpr int width = max_simd_width; // cells at a time, one after the other along x
    using floats = lanes<width>;
    using field = std::vector<float>; // by node, with room for the corners of the last register of cells

    // The values of a field at the corners of a cell, of which bit 0 is the side along x, bit 1 along y and bit 2 along
    // z, and their differences between the two sides: those along x, y and z, entries 1, 2 and 4, are its gradient in
    // the middle; those along several axes at a time are its twists, which vanish there. One is the transpose of the
    // other (the Walsh-Hadamard transform, but for its signs).
    using cell_values = std::array<floats, 8>;
    template <class Pair>
    static void for_sides(cell_values& v, const Pair& pair) {
        pair(v[0], v[1]), pair(v[2], v[3]), pair(v[4], v[5]), pair(v[6], v[7]);
        pair(v[0], v[2]), pair(v[1], v[3]), pair(v[4], v[6]), pair(v[5], v[7]);
        pair(v[0], v[4]), pair(v[1], v[5]), pair(v[2], v[6]), pair(v[3], v[7]);
    }
    static void to_differences(cell_values& v) {
        for_sides(v, [](floats& a, floats& b) {
            const floats sum = a + b;
            b = b - a;
            a = sum;
        });
    }
    static void to_corners(cell_values& v) {
        for_sides(v, [](floats& a, floats& b) {
            const floats difference = a - b;
            b = b + a;
            a = difference;
        });
    }

    // The equations of all cells, each at the node that is its first corner. The last nodes along an axis begin no
    // cell: there all is 0.
    struct equations {
        field weight;       // 1 where a cell begins
        field fibre[3];     // f, by axis
        field wanted[3][3]; // t less what coordinates begin with: by coordinate, then by axis
    };
    std::array<std::size_t, 8> corners() const {
        const std::size_t row = count_.x, layer = row * count_.y;
        return {0, 1, row, row + 1, layer, layer + 1, layer + row, layer + row + 1};
    }
    equations equations_of(const std::vector<mat3>& targets) const {
        const field zeros(nodes_.size() + corners()[7] + width, 0.0F);
        equations all{
            zeros, {zeros, zeros, zeros}, {{zeros, zeros, zeros}, {zeros, zeros, zeros}, {zeros, zeros, zeros}}};
        for (std::size_t cell = 0; cell < targets.size(); ++cell) {
            const std::size_t node = first_node(cell);
            all.weight[node] = 1;
            for (int axis = 0; axis < 3; ++axis) {
                all.fibre[axis][node] = targets[cell][0][axis];
                for (int i = 0; i < 3; ++i)
                    all.wanted[i][axis][node] = targets[cell][i][axis] - start_of(targets, i)[axis];
            }
        }
        return all;
    }
    // Coordinates begin with those of the middle cell everywhere.
    static vec3 start_of(const std::vector<mat3>& targets, int coordinate) {
        return targets[targets.size() / 2][coordinate];
    }

    // Conjugate gradients on the normal equations.
    void solve(const equations& all, vec3 start, int coordinate) {
        const std::size_t size = nodes_.size();
        const std::array<std::size_t, 8> corner = corners();
        const float each = 0.25F / spacing_; // of a difference
        // Adds the transpose of the equations times their weights, of differences in the cells from a node on.
        const auto add = [&](std::size_t first, cell_values& v, field& to) {
            const auto at = [&](const field& values) { return load<width>(values.data() + first); };
            const floats f[3] = {at(all.fibre[0]), at(all.fibre[1]), at(all.fibre[2])},
                         part = at(all.weight) * floats(each), twist = part * floats(damping),
                         along = (v[1] * f[0] + v[2] * f[1] + v[4] * f[2]) * floats(weight);
            v = {floats(0.0F),
                 part * (v[1] + along * f[0]),
                 part * (v[2] + along * f[1]),
                 twist * v[3],
                 part * (v[4] + along * f[2]),
                 twist * v[5],
                 twist * v[6],
                 twist * v[7]};
            to_corners(v);
            for (std::size_t i = 0; i < v.size(); ++i) {
                float* const there = to.data() + first + corner[i];
                store(load<width>(there) + v[i], there);
            }
        };
        const auto product = [&](const field& a, const field& b) {
            floats sum(0.0F);
            for (std::size_t i = 0; i < size; i += width)
                sum = multiply_add(load<width>(a.data() + i), load<width>(b.data() + i), sum);
            float parts[width];
            store(sum, parts);
            return std::accumulate(parts, parts + width, 0.0F);
        };
        // a + factor b
        const auto combine = [&](const field& a, float factor, const field& b, field& to) {
            for (std::size_t i = 0; i < size; i += width)
                store(multiply_add(floats(factor), load<width>(b.data() + i), load<width>(a.data() + i)),
                      to.data() + i);
        };

        field solution(all.weight.size(), 0.0F), residual = solution, image;
        for (std::size_t i = 0; i < size; i += width) {
            const auto wanted = [&](int axis) { return load<width>(all.wanted[coordinate][axis].data() + i); };
            const floats zero(0.0F);
            cell_values v{zero, wanted(0), wanted(1), zero, wanted(2), zero, zero, zero};
            add(i, v, residual);
        }
        field direction = residual;
        float left = product(residual, residual);
        const float enough = 1e-8F * left;
        for (int iteration = 0; iteration < 1000 && left > enough; ++iteration) {
            image.assign(direction.size(), 0.0F);
            for (std::size_t i = 0; i < size; i += width) {
                cell_values v;
                for (std::size_t k = 0; k < v.size(); ++k)
                    v[k] = load<width>(direction.data() + i + corner[k]) * floats(each);
                to_differences(v);
                add(i, v, image);
            }
            const float along = product(direction, image);
            if (!(along > 0)) break;
            combine(solution, left / along, direction, solution);
            combine(residual, -left / along, image, residual);
            const float now = product(residual, residual);
            combine(residual, now / left, direction, direction);
            left = now;
        }
        for (std::size_t node = 0; node < size; ++node)
            nodes_[node][coordinate] = solution[node] + dot(start, node_position(node));
    }

    std::vector<vec3> nodes_{};
    uvec3 count_{0, 0, 0};
    vec3 origin_{0, 0, 0};
    float spacing_ = 1;
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
