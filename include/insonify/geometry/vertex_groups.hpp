#ifndef INSONIFY_GEOMETRY_VERTEX_GROUPS_HPP
#define INSONIFY_GEOMETRY_VERTEX_GROUPS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/units.hpp>
#include <insonify/geometry/half_edge.hpp>
#include <insonify/geometry/mesh.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The faces around each vertex, in groups that are separated by creases: edges where two faces meet at more than a given
/// angle. Faces of one group share a normal at the vertex.
struct vertex_groups {
    std::vector<uvec3> corners{};       ///< group of the three corners of each face
    std::vector<std::uint32_t> ends{};  ///< where the slots of each group end, in `slots`
    std::vector<std::uint32_t> slots{}; ///< of all groups: 3 * face + corner, one after the other

    vertex_groups() = default;
    /// @param crease_angle  radians
    vertex_groups(const mesh_view& surface, float crease_angle) : corners(surface.size()), slots(3 * surface.size()) {
        constexpr float rounding = 1e-4F; // edges of exactly the angle are smooth
        min_cosine_ = std::cos(crease_angle) - rounding;
        // Of two faces that each make half the angle with a third.
        const float half_angle = std::cos(0.5F * crease_angle) + rounding;

        std::vector<vec3> normal(surface.size()); // {0, 0, 0}: no area, smooth with all
        for (std::size_t i = 0; i < normal.size(); ++i) normal[i] = unit_normal(surface[i], {0, 0, 0});
        std::vector<std::uint32_t> begin(surface.positions.size() + 1, 0); // of the slots of each vertex
        for (std::uint32_t slot = 0; slot < slots.size(); ++slot) ++begin[vertex_of(surface, slot) + 1];
        for (std::size_t i = 0; i + 1 < begin.size(); ++i) begin[i + 1] += begin[i];
        std::vector<std::uint32_t> end{begin.begin(), begin.end() - 1};
        for (std::uint32_t slot = 0; slot < slots.size(); ++slot) slots[end[vertex_of(surface, slot)]++] = slot;

        ends.reserve(surface.positions.size() + surface.positions.size() / 4);
        for (std::size_t vertex = 0; vertex + 1 < begin.size(); ++vertex) {
            std::uint32_t* const first = slots.data() + begin[vertex];
            const std::uint32_t count = begin[vertex + 1] - begin[vertex];
            if (count == 0) continue;
            const vec3 one = normal[first[0] / 3];
            const bool all_alike = std::all_of(
                first, first + count, [&](std::uint32_t slot) { return dot(one, normal[slot / 3]) >= half_angle; });
            if (all_alike)
                close_group(begin[vertex + 1]);
            else
                divide(surface, normal, first, count, begin[vertex]);
        }
        std::uint32_t slot = 0;
        for (std::uint32_t group = 0; group < ends.size(); ++group)
            for (; slot < ends[group]; ++slot) {
                uvec3& of_face = corners[slots[slot] / 3];
                const std::uint32_t corner = slots[slot] % 3;
                (corner == 0 ? of_face.x : corner == 1 ? of_face.y : of_face.z) = group;
            }
    }

  private:
    struct side { // of an edge at the vertex
        std::uint32_t other_end = 0;
        std::uint32_t local = 0; // number of the slot among those of the vertex
    };

    static std::uint32_t vertex_of(const mesh_view& surface, std::uint32_t slot) {
        return vertices_of_side(surface.faces[slot / 3], slot % 3).first;
    }

    void close_group(std::uint32_t end) { ends.push_back(end); }

    // Joins the faces across smooth edges, and sorts the slots of the vertex by what is joined.
    void divide(const mesh_view& surface, const std::vector<vec3>& normal, std::uint32_t* first, std::uint32_t count,
                std::uint32_t begin) {
        sides_.clear();
        joined_.resize(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const uvec3& face = surface.faces[first[i] / 3];
            const std::uint32_t corner = first[i] % 3;
            sides_.push_back({vertices_of_side(face, corner).second, i});
            sides_.push_back({vertices_of_side(face, (corner + 2) % 3).first, i});
            joined_[i] = {i, first[i]};
        }
        std::sort(sides_.begin(), sides_.end(), [](const side& a, const side& b) {
            return a.other_end != b.other_end ? a.other_end < b.other_end : a.local < b.local;
        });
        for (std::size_t i = 0; i + 1 < sides_.size(); ++i) {
            const side &a = sides_[i], &b = sides_[i + 1];
            if (a.other_end != b.other_end) continue;
            const vec3 &na = normal[first[a.local] / 3], &nb = normal[first[b.local] / 3];
            const bool without_area = na == vec3{0, 0, 0} || nb == vec3{0, 0, 0};
            if (!without_area && dot(na, nb) < min_cosine_) continue;
            const std::uint32_t of_a = root(a.local), of_b = root(b.local);
            joined_[std::max(of_a, of_b)].first = std::min(of_a, of_b);
        }
        for (std::uint32_t i = 0; i < count; ++i) joined_[i].first = root(i);
        std::sort(joined_.begin(), joined_.end());
        for (std::uint32_t i = 0; i < count; ++i) {
            first[i] = joined_[i].second;
            if (i + 1 == count || joined_[i + 1].first != joined_[i].first) close_group(begin + i + 1);
        }
    }

    std::uint32_t root(std::uint32_t i) {
        for (; joined_[i].first != i; i = joined_[i].first) joined_[i].first = joined_[joined_[i].first].first;
        return i;
    }

    float min_cosine_ = 1;
    std::vector<side> sides_{};
    std::vector<std::pair<std::uint32_t, std::uint32_t>> joined_{}; // representative of each slot's group, and the slot
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
