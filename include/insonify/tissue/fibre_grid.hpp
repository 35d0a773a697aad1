#ifndef INSONIFY_TISSUE_FIBRE_GRID_HPP
#define INSONIFY_TISSUE_FIBRE_GRID_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/tissue/fibre_chart.hpp>
#include <insonify/tissue/fibre_directions.hpp>
#include <insonify/tissue/structure_axes.hpp>
#include <cmath>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Coordinates in which the fibres of an object are straight.
///
/// Each coordinate c is the least-squares solution of grad c = t and, with a greater weight, of f . grad c = f . t in all cells
/// of a grid: f is the direction of the fibres, t for x is f, for z the flattest axis made orthogonal to f, for y orthogonal to
/// both. So sheets contain the fibres, as far as such sheets exist, and distances are kept as far as possible.
/// Source: conjugate gradients for least squares; Bjorck, Numerical Methods for Least Squares Problems, section 7.4.
class fibre_grid {
  public:
    fibre_grid() = default; ///< of straight fibres

    /// @param box   of the object
    /// @param axes  of the object: the last one where it is flattest
    fibre_grid(const fibre_directions& fibres, const aabb& box, const mat3& axes) {
        if (!fibres.varies() || box.empty()) return;
        const vec3 size = max(box.size(), vec3{1e-4F});
        spacing_ = std::fmax(std::cbrt(size.x * size.y * size.z / max_cells), 0.5e-3F);
        for (int i = 0; i < 3; ++i) count_[i] = static_cast<std::uint32_t>(std::ceil(size[i] / spacing_)) + 2;
        origin_ = box.centre() - 0.5F * spacing_ * vec3{count_ - 1U};
        std::vector<mat3> targets(cells());
        for (std::size_t cell = 0; cell < targets.size(); ++cell) {
            const vec3 centre = node_position(first_node(cell)) + vec3{0.5F * spacing_};
            const vec3 along = fibres(max(box.lower, min(centre, box.upper)));
            if (!is_finite(along) || !(length(along) > 0))
                throw geometry_error{
                    "scene: `fibres` of an object is a function that returns 0 or a direction that is not finite; "
                    "it must return a direction in the whole box around the object"};
            targets[cell] = aligned(axes, along);
        }
        nodes_.resize(std::size_t{count_.x} * count_.y * count_.z);
        for (int coordinate = 0; coordinate < 3; ++coordinate) solve(targets, coordinate);
    }

    /// As a view.
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
    /// The gradient at the middle of a cell, and what a field has besides that vanishes there: its twists, along two axes at a time
    /// and along all three.
    struct slope {
        vec3 gradient{0, 0, 0}, twist{0, 0, 0};
        float all = 0;
    };
    /// Calls of(node, slope of a field that is 1 at this node alone) for the corners of a cell.
    template <class Of>
    void for_corners(std::size_t cell, Of&& of) const {
        const std::size_t first = first_node(cell);
        const float each = 0.25F / spacing_;
        for (std::uint32_t corner = 0; corner < 8; ++corner) {
            const std::uint32_t i = corner & 1U, j = corner >> 1 & 1U, k = corner >> 2;
            const float x = i > 0 ? 1.0F : -1.0F, y = j > 0 ? 1.0F : -1.0F, z = k > 0 ? 1.0F : -1.0F;
            of(first + i + count_.x * (j + std::size_t{count_.y} * k),
               slope{each * vec3{x, y, z}, each * vec3{y * z, z * x, x * y}, each * x * y * z});
        }
    }
    static float product(const slope& a, const slope& b) {
        return dot(a.gradient, b.gradient) + dot(a.twist, b.twist) + a.all * b.all;
    }

    // Conjugate gradients on the normal equations, from the coordinates of the middle cell on.
    void solve(const std::vector<mat3>& targets, int coordinate) {
        const auto weighted = [&](std::size_t cell, slope of) { // the matrix of the equations, times its transpose
            const vec3 f = targets[cell][0];
            return slope{of.gradient + weight * dot(f, of.gradient) * f, damping * of.twist, damping * of.all};
        };
        const auto slope_of = [&](const std::vector<double>& field, std::size_t cell) {
            slope sum;
            for_corners(cell, [&](std::size_t node, const slope& of) {
                const auto value = static_cast<float>(field[node]);
                sum.gradient += value * of.gradient;
                sum.twist += value * of.twist;
                sum.all += value * of.all;
            });
            return sum;
        };
        const std::size_t size = nodes_.size();
        std::vector<double> solution(size, 0.0), residual(size, 0.0), direction, image(size);
        const vec3 start = targets[targets.size() / 2][coordinate];
        for (std::size_t cell = 0; cell < targets.size(); ++cell) {
            const slope wanted = weighted(cell, {.gradient = targets[cell][coordinate] - start});
            for_corners(cell, [&](std::size_t node, const slope& of) {
                residual[node] += static_cast<double>(product(of, wanted));
            });
        }
        const auto power = [](const std::vector<double>& a) {
            double sum = 0;
            for (const double value : a) sum += value * value;
            return sum;
        };
        direction = residual;
        double left = power(residual);
        const double enough = 1e-8 * left;
        for (int iteration = 0; iteration < 1000 && left > enough; ++iteration) {
            image.assign(size, 0.0);
            double along = 0;
            for (std::size_t cell = 0; cell < targets.size(); ++cell) {
                const slope own = slope_of(direction, cell), flow = weighted(cell, own);
                along += static_cast<double>(product(own, flow));
                for_corners(cell, [&](std::size_t node, const slope& of) {
                    image[node] += static_cast<double>(product(of, flow));
                });
            }
            if (!(along > 0)) break;
            const double step = left / along;
            for (std::size_t i = 0; i < size; ++i) {
                solution[i] += step * direction[i];
                residual[i] -= step * image[i];
            }
            const double now = power(residual), turn = now / left;
            left = now;
            for (std::size_t i = 0; i < size; ++i) direction[i] = residual[i] + turn * direction[i];
        }
        for (std::size_t node = 0; node < size; ++node)
            nodes_[node][coordinate] = static_cast<float>(solution[node]) + dot(start, node_position(node));
    }

    std::vector<vec3> nodes_{};
    uvec3 count_{0, 0, 0};
    vec3 origin_{0, 0, 0};
    float spacing_ = 1;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
