#ifndef INSONIFY_SCENE_TETRAHEDRA_HPP
#define INSONIFY_SCENE_TETRAHEDRA_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/text.hpp>
#include <insonify/scene/inverse_map.hpp>
#include <insonify/scene/tetrahedral_mesh.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {
struct inverse_tetrahedra;
}

/// A body that is divided into tetrahedra, as finite-element engines have it: a map for `scene::deform`. It interpolates
/// linearly in the tetrahedra. What lies outside moves with the nearest point of their surface.
///
///     tetrahedra liver{nodes, cells};           // at rest, once: builds what locates points
///     std::ranges::copy(engine, liver.nodes().begin());
///     body.deform(exec::par, liver);            // each frame
///
/// The scene locates the vertices of its objects once, and again where they are placed elsewhere. A copy shares what does not
/// change.
class tetrahedra {
  public:
    /// @param rest   positions of the nodes at rest, in the world, metres
    /// @param cells  four nodes each, from 0, in either orientation
    /// @throws geometry_error  for a node that does not exist or is not finite, or a tetrahedron without volume
    tetrahedra(std::vector<vec3> rest, std::vector<std::array<std::uint32_t, 4>> cells)
        : mesh_{std::make_shared<const detail::tetrahedral_mesh>(std::move(rest), std::move(cells))},
          nodes_{mesh_->rest} {}

    /// Where the nodes are now, in the world, metres: to be written each frame.
    std::span<vec3> nodes() { return nodes_; }
    /// The same to be read.
    std::span<const vec3> nodes() const { return nodes_; }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const { return rest + displacement(mesh_->locate(rest)); }

    /// @throws geometry_error  for a node that is not finite, or a tetrahedron that is turned inside out
    void check() const {
        check_nodes();
        check_cells(0, mesh_->cells.size());
    }

  private:
    friend struct detail::inverse_tetrahedra;

    void check_nodes() const {
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            if (!is_finite(nodes_[i]))
                throw geometry_error{
                    detail::joined({"deform: node ", std::to_string(i), " of the tetrahedra is not finite"})};
    }
    void check_cells(std::size_t begin, std::size_t end) const {
        for (std::size_t i = begin; i < end; ++i)
            if (!(detail::signed_volume(nodes_, mesh_->cells[i]) * mesh_->orientation[i] > 0))
                throw geometry_error{detail::joined({"deform: tetrahedron ", std::to_string(i), " near ",
                                                     detail::point_text(nodes_[mesh_->cells[i][0]]),
                                                     " is turned inside out; take a smaller step in the engine"})};
    }

    vec3 displacement(const detail::tetrahedral_point& at) const {
        const std::array<std::uint32_t, 4>& cell = mesh_->cells[at.cell];
        vec3 sum{0, 0, 0};
        for (std::size_t i = 0; i < 4; ++i) sum += at.weight[i] * (nodes_[cell[i]] - mesh_->rest[cell[i]]);
        return sum;
    }

    std::shared_ptr<const detail::tetrahedral_mesh> mesh_;
    std::vector<vec3> nodes_;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
