#ifndef INSONIFY_SCENE_INVERSE_TETRAHEDRA_HPP
#define INSONIFY_SCENE_INVERSE_TETRAHEDRA_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/any_policy.hpp>
#include <insonify/scene/tetrahedra.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// What the scene does with `tetrahedra` in other ways than with other maps.
struct inverse_tetrahedra {
    const tetrahedra& map;

    /// The same as `tetrahedra::check`.
    template <class Policy>
    void check(const Policy& policy) const {
        map.check_nodes();
        exec::for_each_block(policy, map.mesh_->cells.size(), 8192, 10,
                             [&](std::size_t begin, std::size_t end) { map.check_cells(begin, end); });
    }

    /// Moves vertices, after locating them where that was not done before.
    template <class Policy>
    bool displace(const Policy& policy, const pose& at, view<const vec3> rest, located_vertices& located,
                  view<vec3> now) const {
        if (located.mesh != map.mesh_ || !(located.at == at)) {
            located.points.resize(rest.size());
            exec::for_each_block(policy, rest.size(), 256, 1e3F, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) located.points[i] = map.mesh_->locate(at.point(rest[i]));
            });
            located.mesh = map.mesh_;
            located.at = at;
        }
        exec::for_each_block(policy, rest.size(), 8192, 10, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                now[i] = rest[i] + at.local_direction(map.displacement(located.points[i]));
        });
        return map.nodes_ != map.mesh_->rest;
    }

    /// Writes displacements at the nodes of a lattice: see `invert_map`. Each tetrahedron fills the nodes inside of it.
    void invert(const any_policy<false>& policy, const displacement_lattice& where, float* nodes) const {
        const std::size_t layer = std::size_t{where.size.x} * where.size.y, layers = (where.size.z + 3U) / 4U;
        exec::for_each_block(policy, where.size.z, layers, 1e6F, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin * layer; i < end * layer; ++i) nodes[4 * i + 3] = empty;
            for (std::size_t i = 0; i < map.mesh_->cells.size(); ++i)
                fill(i, where, static_cast<float>(begin), static_cast<float>(end) - 1, nodes);
        });
        extend(where, nodes);
    }

    /// Finds where tissue was at rest: see `find_rest`.
    vec3 rest_of(vec3 now) const {
        const tetrahedral_mesh& mesh = *map.mesh_;
        tetrahedral_point best;
        float deepest = -FLT_MAX;
        for (std::uint32_t i = 0; i < mesh.cells.size(); ++i) {
            const std::array<float, 4> weight = barycentric(map.nodes_, mesh.cells[i], now);
            const float depth = *std::min_element(weight.begin(), weight.end());
            if (depth > deepest) best = {i, weight}, deepest = depth;
        }
        if (deepest < -1e-5F) best = nearest_of_surface(now);
        return now - map.displacement(best);
    }

  private:
    static constexpr float empty = -1; // the fourth number of a node that has no displacement yet

    void fill(std::size_t number, const displacement_lattice& where, float first, float last, float* nodes) const {
        const tetrahedron& cell = map.mesh_->cells[number];
        vec3 corner[4];
        for (std::size_t k = 0; k < 4; ++k)
            corner[k].z = dot(where.at.rotation[2], map.nodes_[cell[k]] - where.at.translation) / where.spacing.z;
        const auto [low, high] = std::minmax({corner[0].z, corner[1].z, corner[2].z, corner[3].z});
        if (high < first || low > last) return;
        for (std::size_t k = 0; k < 4; ++k) corner[k] = where.at.local_point(map.nodes_[cell[k]]) / where.spacing;
        vec3 lower = min(min(corner[0], corner[1]), min(corner[2], corner[3])),
             upper = max(max(corner[0], corner[1]), max(corner[2], corner[3]));
        lower = max(lower, vec3{0, 0, first});
        upper = min(upper, vec3{static_cast<float>(where.size.x - 1), static_cast<float>(where.size.y - 1), last});
        if (upper.x < lower.x || upper.y < lower.y) return;
        vec3 moved[4]; // from now to rest, in axes of the lattice
        for (std::size_t k = 0; k < 4; ++k)
            moved[k] = where.at.local_direction(map.mesh_->rest[cell[k]] - map.nodes_[cell[k]]);
        const mat3 to_weights = inverse(mat3{corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0]});
        const auto above = [](float value) { return static_cast<std::uint32_t>(std::ceil(value)); };
        const auto below = [](float value) { return static_cast<std::uint32_t>(std::floor(value)); };
        for (std::uint32_t z = above(lower.z); z <= below(upper.z); ++z)
            for (std::uint32_t y = above(lower.y); y <= below(upper.y); ++y)
                for (std::uint32_t x = above(lower.x); x <= below(upper.x); ++x) {
                    constexpr float tolerance = -1e-5F;
                    const vec3 weight = to_weights * (vec3{x, y, z} - corner[0]);
                    const float rest = 1 - weight.x - weight.y - weight.z;
                    if (weight.x < tolerance || weight.y < tolerance || weight.z < tolerance || rest < tolerance)
                        continue;
                    float* to = nodes + 4 * ((std::size_t{z} * where.size.y + y) * where.size.x + x);
                    if (to[3] != empty) continue; // on a face: the tetrahedron of the lowest index
                    write(to, rest * moved[0] + weight.x * moved[1] + weight.y * moved[2] + weight.z * moved[3]);
                }
    }

    static void write(float* to, vec3 displacement) {
        to[0] = displacement.x, to[1] = displacement.y, to[2] = displacement.z, to[3] = 0;
    }

    // Gives the other nodes the displacements of their neighbours, forwards and backwards.
    static void extend(const displacement_lattice& where, float* nodes) {
        const std::size_t strides[] = {1, where.size.x, std::size_t{where.size.x} * where.size.y};
        const std::size_t count = where.count();
        for (const bool forwards : {true, false})
            for (std::size_t step = 0; step < count; ++step) {
                const std::size_t i = forwards ? step : count - 1 - step;
                if (nodes[4 * i + 3] != empty) continue;
                vec3 sum{0, 0, 0};
                float found = 0;
                for (int axis = 0; axis < 3; ++axis) {
                    const std::size_t place = i / strides[axis] % where.size[axis];
                    if (forwards ? place == 0 : place + 1 == where.size[axis]) continue;
                    const float* from = nodes + 4 * (forwards ? i - strides[axis] : i + strides[axis]);
                    if (from[3] == empty) continue;
                    sum += vec3{from[0], from[1], from[2]};
                    found += 1;
                }
                if (found > 0) write(nodes + 4 * i, sum / found);
            }
        for (std::size_t i = 0; i < count; ++i)
            if (nodes[4 * i + 3] == empty) write(nodes + 4 * i, {0, 0, 0});
    }

    tetrahedral_point nearest_of_surface(vec3 now) const {
        const mesh_view surface{map.nodes_, map.mesh_->surface.faces};
        nearest_point best;
        for (std::uint32_t face = 0; face < surface.size(); ++face) {
            const vec3 on = nearest_on(surface[face], now);
            if (const float squared = dot(now - on, now - on); squared < best.distance_squared)
                best = {squared, face, on};
        }
        const std::uint32_t cell = map.mesh_->behind[best.primitive];
        return {cell, barycentric(map.nodes_, map.mesh_->cells[cell], best.point)};
    }
};

inline void invert_map(const any_policy<false>& policy, const tetrahedra& map, const displacement_lattice& where,
                       float* nodes) {
    inverse_tetrahedra{map}.invert(policy, where, nodes);
}
inline bool find_rest(const tetrahedra& map, vec3 now, vec3& rest) {
    rest = inverse_tetrahedra{map}.rest_of(now);
    return true;
}
template <class Policy>
bool displace_vertices(const Policy& policy, const tetrahedra& map, const pose& at, view<const vec3> rest,
                       located_vertices& located, view<vec3> now) {
    return inverse_tetrahedra{map}.displace(policy, at, rest, located, now);
}
template <class Policy>
void check_map(const Policy& policy, const tetrahedra& map, const aabb&) {
    inverse_tetrahedra{map}.check(policy);
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
