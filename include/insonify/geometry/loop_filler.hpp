#ifndef INSONIFY_GEOMETRY_LOOP_FILLER_HPP
#define INSONIFY_GEOMETRY_LOOP_FILLER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Triangulates a closed loop of points in space.
template <class Deferred = void>
class loop_filler {
  public:
    /// Three indices each into the loop; the index after its last point is that of its centre.
    using triangles = std::vector<std::array<std::uint32_t, 3>>;

    /// @param loop     at least three points; the triangles have its orientation
    /// @param is_free  is_free(i, j): whether points may be joined by an edge
    loop_filler(const std::vector<dvec3>& loop, function_ref<bool(std::uint32_t, std::uint32_t)> is_free)
        : loop_{loop}, is_free_{is_free}, rest_(loop.size()) {
        std::iota(rest_.begin(), rest_.end(), 0U);
    }

    /// Of the smallest area; of a loop with more than 200 points first the shortest ears are cut off.
    /// Source: Barequet & Sharir 1995, "Filling gaps in the boundary of a polyhedron".
    triangles fill() && {
        if (rest_.size() > max_exact) cut_ears();
        if (rest_.size() <= max_exact && fill_exactly()) return std::move(found_);
        found_.clear();
        const auto count = static_cast<std::uint32_t>(loop_.size());
        for (std::uint32_t i = 0; i < count; ++i) found_.push_back({i, (i + 1) % count, count});
        return std::move(found_);
    }

  private:
    static constexpr std::size_t max_exact = 200; // points; the time grows with their third power
    static constexpr double compactness = 1e-4;   // among fillings of equal area those of short edges are chosen
    static constexpr double impossible = 1e300;   // area

    static double square(const dvec3& v) { return dot(v, v); }

    bool fill_exactly() {
        const std::size_t count = rest_.size();
        std::vector<double> min_cost(count * count, 0.0); // cost of the polygon from i to j
        std::vector<std::uint32_t> apex(count * count, 0);
        const auto at = [&](std::size_t i) -> const dvec3& { return loop_[rest_[i]]; };
        for (std::size_t span = 2; span < count; ++span)
            for (std::size_t i = 0; i + span < count; ++i) {
                const std::size_t j = i + span;
                min_cost[i * count + j] = impossible;
                if (span + 1 < count && !is_free_(rest_[i], rest_[j])) continue;
                double best = impossible;
                const dvec3 to_j = at(j) - at(i);
                for (std::size_t k = i + 1; k < j; ++k) {
                    const dvec3 to_k = at(k) - at(i);
                    const double own =
                        length(cross(to_k, to_j)) + compactness * (square(to_j) + square(to_k) + square(to_j - to_k));
                    const double cost = min_cost[i * count + k] + min_cost[k * count + j] + own;
                    if (cost < best) {
                        best = cost;
                        apex[i * count + j] = static_cast<std::uint32_t>(k);
                    }
                }
                min_cost[i * count + j] = best;
            }
        if (!(min_cost[count - 1] < impossible)) return false;
        std::vector<std::pair<std::size_t, std::size_t>> open{{0, count - 1}};
        while (!open.empty()) {
            const auto [i, j] = open.back();
            open.pop_back();
            if (j - i < 2) continue;
            const std::size_t k = apex[i * count + j];
            found_.push_back({rest_[i], rest_[k], rest_[j]});
            open.emplace_back(i, k);
            open.emplace_back(k, j);
        }
        return true;
    }

    // Cuts off triangles of two sides of the loop, those of the shortest third side first, until few points are left:
    // as long as there are any, convex ones that contain no other point, seen along the normal of the loop.
    void cut_ears() {
        const auto count = static_cast<std::uint32_t>(loop_.size());
        std::vector<std::uint32_t> before(count), after(count);
        dvec3 normal{0, 0, 0};
        for (std::uint32_t i = 0; i < count; ++i) {
            before[i] = (i + count - 1) % count;
            after[i] = (i + 1) % count;
            normal += cross(loop_[i] - loop_[0], loop_[after[i]] - loop_[0]);
        }
        const auto side = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            return dot(normal, cross(loop_[b] - loop_[a], loop_[c] - loop_[a]));
        };
        std::vector<std::uint32_t> reflex; // a convex corner stays one
        for (std::uint32_t i = 0; i < count; ++i)
            if (!(side(before[i], i, after[i]) > 0)) reflex.push_back(i);
        std::vector<std::uint8_t> is_cut(count, 0);
        const auto is_ear = [&](std::uint32_t i) {
            const std::uint32_t a = before[i], c = after[i];
            return side(a, i, c) > 0 && std::none_of(reflex.begin(), reflex.end(), [&](std::uint32_t p) {
                       return p != a && p != i && p != c && !is_cut[p] && side(a, i, p) >= 0 && side(i, c, p) >= 0 &&
                              side(c, a, p) >= 0;
                   });
        };
        std::set<std::pair<double, std::uint32_t>> ears; // by length of the third side
        const auto ear_at = [&](std::uint32_t i) { return std::pair{square(loop_[after[i]] - loop_[before[i]]), i}; };
        std::size_t left = count;
        const auto cut_any = [&](bool is_strict) {
            const std::size_t before_pass = left;
            for (std::uint32_t i = 0; i < count; ++i)
                if (!is_cut[i]) ears.insert(ear_at(i));
            while (left > max_exact && !ears.empty()) {
                const std::uint32_t i = ears.extract(ears.begin()).value().second, a = before[i], c = after[i];
                if ((is_strict && !is_ear(i)) || !is_free_(a, c)) continue;
                found_.push_back({a, i, c});
                for (const std::uint32_t beside : {a, c}) ears.erase(ear_at(beside));
                is_cut[i] = 1;
                after[a] = c;
                before[c] = a;
                for (const std::uint32_t beside : {a, c}) ears.insert(ear_at(beside));
                --left;
            }
            return left < before_pass;
        };
        // An ear that was refused is tried again once others are gone; where no ear is one, any will do.
        for (const bool is_strict : {true, false})
            while (left > max_exact && cut_any(is_strict)) {
            }
        std::erase_if(rest_, [&](std::uint32_t i) { return is_cut[i] != 0; });
    }

    const std::vector<dvec3>& loop_;
    function_ref<bool(std::uint32_t, std::uint32_t)> is_free_;
    std::vector<std::uint32_t> rest_; // points of the loop that are not cut off
    triangles found_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
