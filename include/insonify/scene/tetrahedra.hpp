#ifndef INSONIFY_SCENE_TETRAHEDRA_HPP
#define INSONIFY_SCENE_TETRAHEDRA_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/storage.hpp>
#include <insonify/scene/inverse_map.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

using tetrahedron = std::array<std::uint32_t, 4>;

struct tetrahedral_point {
    std::uint32_t cell = 0;                  ///< index of the tetrahedron
    std::array<float, 4> weight{1, 0, 0, 0}; ///< of its nodes; their sum is 1
};

inline float signed_volume(std::span<const vec3> nodes, const tetrahedron& cell) {
    const vec3 a = nodes[cell[0]];
    return dot(nodes[cell[1]] - a, cross(nodes[cell[2]] - a, nodes[cell[3]] - a)) / 6;
}

inline std::array<float, 4> barycentric(std::span<const vec3> nodes, const tetrahedron& cell, vec3 point) {
    const vec3 a = nodes[cell[0]];
    const vec3 part = inverse(mat3{nodes[cell[1]] - a, nodes[cell[2]] - a, nodes[cell[3]] - a}) * (point - a);
    return {1 - part.x - part.y - part.z, part.x, part.y, part.z};
}

/// Tetrahedra at rest, and what locates points in them.
template <class Deferred = void>
struct tetrahedral_mesh {
    std::vector<vec3> rest;              ///< nodes, metres
    std::vector<tetrahedron> cells;      ///< four nodes each
    std::vector<float> orientation{};    ///< of each: the sign of its volume
    mesh surface{};                      ///< the faces that belong to one tetrahedron only
    std::vector<std::uint32_t> behind{}; ///< the tetrahedron of each face of the surface

    /// @throws geometry_error  for a node that does not exist or is not finite, or a tetrahedron without volume
    tetrahedral_mesh(std::vector<vec3> nodes, std::vector<tetrahedron> of)
        : rest{std::move(nodes)}, cells{std::move(of)} {
        if (cells.empty()) throw geometry_error{"tetrahedra: there are none; give four nodes for each"};
        for (const vec3& node : rest)
            if (!is_finite(node)) throw geometry_error{"tetrahedra: a node at rest is not finite"};
        boxes_.reserve(cells.size());
        orientation.reserve(cells.size());
        for (std::size_t i = 0; i < cells.size(); ++i) {
            aabb box;
            for (const std::uint32_t node : cells[i]) {
                if (node >= rest.size())
                    throw geometry_error{"tetrahedra: tetrahedron ", i,           " names node ",        node,
                                         ", but there are ",         rest.size(), "; indices start at 0"};
                box = merged(box, rest[node]);
            }
            const float volume = signed_volume(rest, cells[i]);
            if (volume == 0) throw geometry_error{"tetrahedra: tetrahedron ", i, " has no volume at rest; remove it"};
            orientation.push_back(volume > 0 ? 1.0F : -1.0F);
            boxes_.push_back(box);
        }
        find_surface();
        inside_.build(exec::par, view<const aabb>{boxes_});
        around_.build(exec::par, mesh_view{surface});
    }

    /// The point itself, or the nearest one of the surface; in the tetrahedron that contains it most deeply.
    tetrahedral_point locate(vec3 point) const {
        constexpr float tolerance = 1e-5F;
        tetrahedral_point best;
        float deepest = -tolerance;
        bool found = false;
        inside_.view_of(view<const aabb>{boxes_}).for_each_overlap(aabb{point, point}, [&](std::uint32_t cell) {
            const std::array<float, 4> weight = barycentric(rest, cells[cell], point);
            const float depth = *std::min_element(weight.begin(), weight.end());
            if (depth < deepest || (found && depth == deepest && cell > best.cell)) return;
            best = {cell, weight};
            deepest = depth;
            found = true;
        });
        if (found) return best;
        const nearest_point near = find_nearest(around_.view_of(mesh_view{surface}), point);
        const std::uint32_t cell = behind[near.primitive];
        return {cell, barycentric(rest, cells[cell], near.point)};
    }

  private:
    void find_surface() {
        constexpr std::size_t sides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
        std::vector<std::pair<std::array<std::uint32_t, 3>, std::size_t>> faces; // nodes, and 4 * cell + side
        faces.reserve(4 * cells.size());
        for (std::size_t i = 0; i < 4 * cells.size(); ++i) {
            const auto& [a, b, c] = sides[i % 4];
            faces.push_back({{cells[i / 4][a], cells[i / 4][b], cells[i / 4][c]}, i});
            std::sort(faces.back().first.begin(), faces.back().first.end());
        }
        std::sort(faces.begin(), faces.end());
        surface.positions = rest;
        for (std::size_t i = 0; i < faces.size(); ++i) {
            const bool shared = (i > 0 && faces[i - 1].first == faces[i].first) ||
                                (i + 1 < faces.size() && faces[i + 1].first == faces[i].first);
            if (shared) continue;
            const std::size_t cell = faces[i].second / 4;
            const auto& [a, b, c] = sides[faces[i].second % 4];
            surface.faces.emplace_back(cells[cell][a], cells[cell][b], cells[cell][c]);
            behind.push_back(static_cast<std::uint32_t>(cell));
        }
    }

    std::vector<aabb> boxes_{};
    bvh_storage<view<const aabb>> inside_{};
    bvh_storage<mesh_view> around_{};
};

/// The vertices of an object, located in tetrahedra.
struct located_vertices {
    std::shared_ptr<const tetrahedral_mesh<>> mesh{}; ///< in which; null: not yet
    pose at{};                                        ///< of the object
    std::vector<tetrahedral_point> points{};          ///< of each vertex at rest
};

template <class Deferred>
struct inverse_tetrahedra;

} // namespace detail

/// A body that is divided into tetrahedra, as finite-element engines have it: a map for `scene::deform`. It
/// interpolates linearly in the tetrahedra. What lies outside moves with the nearest point of their surface.
///
///     tetrahedra liver{nodes, cells};           // at rest, once: builds what locates points
///     std::ranges::copy(engine, liver.nodes().begin());
///     body.deform(exec::par, liver);            // each frame
///
/// The scene locates the vertices of its objects once, and again where they are placed elsewhere. A copy shares what
/// does not change.
class tetrahedra {
  public:
    /// @param rest   positions of the nodes at rest, in the world, metres
    /// @param cells  four nodes each, from 0, in either orientation
    /// @throws geometry_error  for a node that does not exist or is not finite, or a tetrahedron without volume
    template <class Deferred = void>
    tetrahedra(std::vector<vec3> rest, std::vector<std::array<std::uint32_t, 4>> cells)
        : mesh_{std::make_shared<const detail::tetrahedral_mesh<>>(std::move(rest), std::move(cells))},
          nodes_{mesh_->rest} {}

    /// Where the nodes are now, in the world, metres: to be written each frame.
    std::span<vec3> nodes() { return nodes_; }
    /// The same to be read.
    std::span<const vec3> nodes() const { return nodes_; }

    /// Where a point at rest is now.
    template <class Deferred = void>
    vec3 operator()(vec3 rest) const {
        return rest + displacement(mesh_->locate(rest));
    }

    /// @throws geometry_error  for a node that is not finite, or a tetrahedron that is turned inside out
    template <class Deferred = void>
    void check() const {
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            if (!is_finite(nodes_[i])) throw geometry_error{"deform: node ", i, " of the tetrahedra is not finite"};
        for (std::size_t i = 0; i < mesh_->cells.size(); ++i)
            if (!(detail::signed_volume(nodes_, mesh_->cells[i]) * mesh_->orientation[i] > 0))
                throw geometry_error{"deform: tetrahedron ", i, " near ",
                                     detail::point_text(nodes_[mesh_->cells[i][0]]),
                                     " is turned inside out; take a smaller step in the engine"};
    }

  private:
    template <class>
    friend struct detail::inverse_tetrahedra;

    vec3 displacement(const detail::tetrahedral_point& at) const {
        const std::array<std::uint32_t, 4>& cell = mesh_->cells[at.cell];
        vec3 sum{0, 0, 0};
        for (std::size_t i = 0; i < 4; ++i) sum += at.weight[i] * (nodes_[cell[i]] - mesh_->rest[cell[i]]);
        return sum;
    }

    std::shared_ptr<const detail::tetrahedral_mesh<>> mesh_;
    std::vector<vec3> nodes_;
};

namespace detail {

/// What the scene does with `tetrahedra` in other ways than with other maps.
template <class Deferred = void>
struct inverse_tetrahedra {
    const tetrahedra& map;

    /// Moves vertices, after locating them where that was not done before.
    template <class Policy>
    bool displace(const Policy& policy, const pose& at, view<const vec3> rest, located_vertices& located,
                  view<vec3> now) const {
        if (located.mesh != map.mesh_ || !(located.at == at)) {
            located.points.resize(rest.size());
            exec::for_each_in_blocks(policy, rest.size(), 256, 1e3F,
                                     [&](std::size_t i) { located.points[i] = map.mesh_->locate(at.point(rest[i])); });
            located.mesh = map.mesh_;
            located.at = at;
        }
        exec::for_each_in_blocks(policy, rest.size(), 8192, 10, [&](std::size_t i) {
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
        const tetrahedral_mesh<>& mesh = *map.mesh_;
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

template <class Deferred = void>
void invert_map(const any_policy<false>& policy, const tetrahedra& map, const displacement_lattice& where,
                float* nodes) {
    inverse_tetrahedra<>{map}.invert(policy, where, nodes);
}
template <class Deferred = void>
bool find_rest(const tetrahedra& map, vec3 now, vec3& rest) {
    rest = inverse_tetrahedra<>{map}.rest_of(now);
    return true;
}
template <class Policy>
bool displace_vertices(const Policy& policy, const tetrahedra& map, const pose& at, view<const vec3> rest,
                       located_vertices& located, view<vec3> now) {
    return inverse_tetrahedra<>{map}.displace(policy, at, rest, located, now);
}
template <class Policy>
void check_map(const Policy&, const tetrahedra& map, const aabb&) {
    map.check();
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
