#ifndef INSONIFY_GEOMETRY_SMOOTH_NORMALS_HPP
#define INSONIFY_GEOMETRY_SMOOTH_NORMALS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/mesh.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The normals of a face that belongs to a curved surface: one at each corner, and linear interpolation between them.
struct face_normals {
    vec3 flat{0, 0, 1};    ///< of the plane of the face, outwards, length 1
    bool curved = false;   ///< some corner's normal differs from `flat`; else that is the normal everywhere
    vec3 corner[3] = {};   ///< at each corner, outwards, length 1
    vec3 gradient[3] = {}; ///< of each corner's barycentric coordinate along the face, 1/m
    vec3 third{0, 0, 0};   ///< the corner whose coordinate is 1 where the others' are 0

    /// The normal at a point of the face, outwards, not of length 1. Beyond the face, that of the face's border.
    INSONIFY_FN vec3 at(vec3 point) const {
        if (!curved) return flat;
        const vec3 from_third = point - third;
        const float u = clamp(dot(gradient[0], from_third), 0, 1), v = clamp(dot(gradient[1], from_third), 0, 1 - u);
        return u * corner[0] + v * corner[1] + (1 - u - v) * corner[2];
    }
    /// The change of `at` per metre in a direction along the face.
    INSONIFY_FN vec3 change(vec3 along) const {
        return dot(gradient[0], along) * corner[0] + dot(gradient[1], along) * corner[1] +
               dot(gradient[2], along) * corner[2];
    }
};

/// Normals that are continuous across the smooth edges of a mesh, in flat arrays. Trivially copyable.
struct smooth_normals_view {
    view<const uvec3> corners{};       ///< which normal the corners of each face have; empty: every face is flat
    view<const std::uint32_t> ends{};  ///< where the slots of each normal end, in `slots`
    view<const std::uint32_t> slots{}; ///< of all normals: 3 * face + corner, one after the other
    view<const vec3> normals{};        ///< empty where vertices have moved since: each is computed as it is needed

    /// One normal: the mean of those of the faces around a vertex, weighted by their angles there.
    INSONIFY_FN vec3 normal(const mesh_view& surface, std::uint32_t number) const {
        return normals.empty() ? computed(surface, number) : normals[number];
    }
    /// The same from where the vertices are now; {0, 0, 0} where no face has an area.
    INSONIFY_FN vec3 computed(const mesh_view& surface, std::uint32_t number) const {
        vec3 sum{0, 0, 0};
        for (std::size_t i = number == 0 ? 0 : ends[number - 1]; i < ends[number]; ++i) {
            const triangle t = surface[slots[i] / 3];
            const std::uint32_t corner = slots[i] % 3;
            const vec3 at = corner == 0 ? t.a : corner == 1 ? t.b : t.c;
            const vec3 to = (corner == 0 ? t.b : corner == 1 ? t.c : t.a) - at;
            const vec3 from = (corner == 0 ? t.c : corner == 1 ? t.a : t.b) - at;
            const float sides = std::sqrt(dot(to, to) * dot(from, from));
            if (sides > 0) sum += angle_of(dot(to, from) / sides) * unit_normal(t, {0, 0, 0});
        }
        const float size = length(sum);
        return size > 0 && is_finite(size) ? sum / size : vec3{0, 0, 0};
    }

    /// The normals of a face.
    /// @param otherwise  `flat` where the face has no area
    INSONIFY_FN face_normals of_face(const mesh_view& surface, std::uint32_t face, vec3 otherwise) const {
        const triangle t = surface[face];
        const vec3 area = area_vector(t);
        const float size = length(area);
        if (!(size > 0) || !is_finite(size)) return {.flat = otherwise};
        face_normals found{.flat = normalize(area)};
        if (corners.empty()) return found;
        const uvec3 number = corners[face];
        const std::uint32_t numbers[] = {number.x, number.y, number.z};
        for (int i = 0; i < 3; ++i) {
            found.corner[i] = normal(surface, numbers[i]);
            // Normals of a plane differ by rounding; they must not.
            if (!(dot(found.corner[i], found.flat) > 0)) found.corner[i] = found.flat; // a fold, or no normal
            const vec3 apart = found.corner[i] - found.flat;
            found.curved = found.curved || dot(apart, apart) > 1e-10F;
        }
        if (!found.curved) return found;
        const vec3 per_area = found.flat / size;
        found.gradient[0] = cross(per_area, t.c - t.b);
        found.gradient[1] = cross(per_area, t.a - t.c);
        found.gradient[2] = cross(per_area, t.b - t.a);
        found.third = t.c;
        return found;
    }

  private:
    // The angle of a cosine, radians, within 7e-5. Source: Abramowitz & Stegun, 4.4.45.
    INSONIFY_FN static float angle_of(float cosine) {
        const float x = min(std::fabs(cosine), 1);
        const float angle = std::sqrt(1 - x) * (1.5707288F + x * (-0.2121144F + x * (0.0742610F - x * 0.0187293F)));
        return cosine < 0 ? pi - angle : angle;
    }
};

/// The faces around each vertex, in groups that are separated by creases: edges where two faces meet at more than a
/// given angle. Faces of one group share a normal at the vertex.
struct vertex_groups {
    std::vector<uvec3> corners{};       ///< group of the three corners of each face
    std::vector<std::uint32_t> ends{};  ///< where the slots of each group end, in `slots`
    std::vector<std::uint32_t> slots{}; ///< of all groups: 3 * face + corner, one after the other

    vertex_groups() = default;
    /// @param crease_angle  radians
    vertex_groups(const mesh_view& surface, float crease_angle) : corners(surface.size()), slots(3 * surface.size()) {
        const std::vector<std::uint32_t> number = joined_at_seams(surface);
        std::vector<uvec3> faces{surface.faces.begin(), surface.faces.end()}; // by the vertices that are joined
        for (uvec3& face : faces) face = {number[face.x], number[face.y], number[face.z]};
        constexpr float rounding = 1e-4F; // edges of exactly the angle are smooth
        min_cosine_ = std::cos(crease_angle) - rounding;
        // Of two faces that each make half the angle with a third.
        const float half_angle = std::cos(0.5F * crease_angle) + rounding;

        std::vector<vec3> normal(surface.size()); // {0, 0, 0}: no area, smooth with all
        for (std::size_t i = 0; i < normal.size(); ++i) normal[i] = unit_normal(surface[i], {0, 0, 0});
        std::vector<std::uint32_t> begin(surface.positions.size() + 1, 0); // of the slots of each vertex
        for (std::uint32_t slot = 0; slot < slots.size(); ++slot) ++begin[vertex_of(faces, slot) + 1];
        for (std::size_t i = 0; i + 1 < begin.size(); ++i) begin[i + 1] += begin[i];
        std::vector<std::uint32_t> end{begin.begin(), begin.end() - 1};
        for (std::uint32_t slot = 0; slot < slots.size(); ++slot) slots[end[vertex_of(faces, slot)]++] = slot;

        ends.reserve(surface.positions.size() + surface.positions.size() / 4);
        for (std::size_t vertex = 0; vertex + 1 < begin.size(); ++vertex) {
            std::uint32_t* const first = slots.data() + begin[vertex];
            const std::uint32_t count = begin[vertex + 1] - begin[vertex];
            if (count == 0) continue;
            const vec3 one = normal[first[0] / 3];
            const bool smooth = std::all_of(
                first, first + count, [&](std::uint32_t slot) { return dot(one, normal[slot / 3]) >= half_angle; });
            if (smooth)
                ends.push_back(begin[vertex + 1]);
            else
                divide(faces, normal, first, count, begin[vertex]);
        }
        std::uint32_t slot = 0;
        for (std::uint32_t group = 0; group < ends.size(); ++group)
            for (; slot < ends[group]; ++slot) corners[slots[slot] / 3][static_cast<int>(slots[slot] % 3)] = group;
    }

  private:
    using pair = std::pair<std::uint32_t, std::uint32_t>;

    static std::uint32_t vertex_of(const std::vector<uvec3>& faces, std::uint32_t slot) {
        return vertices_of_side(faces[slot / 3], slot % 3).first;
    }

    // Joins the faces across smooth edges, and sorts the slots of the vertex by what is joined.
    void divide(const std::vector<uvec3>& faces, const std::vector<vec3>& normal, std::uint32_t* first,
                std::uint32_t count, std::uint32_t begin) {
        sides_.clear();
        disjoint_sets joined{count};
        for (std::uint32_t i = 0; i < count; ++i) {
            const uvec3& face = faces[first[i] / 3];
            const std::uint32_t corner = first[i] % 3;
            sides_.push_back({vertices_of_side(face, corner).second, i});
            sides_.push_back({vertices_of_side(face, (corner + 2) % 3).first, i});
        }
        std::sort(sides_.begin(), sides_.end());
        for (std::size_t i = 0; i + 1 < sides_.size(); ++i) {
            const auto [end, a] = sides_[i];
            const auto [other_end, b] = sides_[i + 1];
            if (end != other_end) continue;
            const vec3 &na = normal[first[a] / 3], &nb = normal[first[b] / 3];
            const bool without_area = na == vec3{0, 0, 0} || nb == vec3{0, 0, 0};
            if (without_area || dot(na, nb) >= min_cosine_) joined.join(a, b);
        }
        groups_.clear();
        for (std::uint32_t i = 0; i < count; ++i) groups_.push_back({joined.find(i), first[i]});
        std::sort(groups_.begin(), groups_.end());
        for (std::uint32_t i = 0; i < count; ++i) {
            first[i] = groups_[i].second;
            if (i + 1 == count || groups_[i + 1].first != groups_[i].first) ends.push_back(begin + i + 1);
        }
    }

    float min_cosine_ = 1;
    std::vector<pair>
        sides_{}; // edges at the vertex: the other end, and the number of the slot among those of the vertex
    std::vector<pair> groups_{}; // the representative of each slot's group, and the slot
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
