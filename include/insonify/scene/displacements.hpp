#ifndef INSONIFY_SCENE_DISPLACEMENTS_HPP
#define INSONIFY_SCENE_DISPLACEMENTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/kept_map.hpp>
#include <insonify/scene/object_state.hpp>
#include <insonify/tissue/displacement_view.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The displacements from now to rest at the nodes of a lattice, as the lines of each place read them: the background, then
/// the objects by rank. Empty where nothing is displaced.
inline view<const displacement_view>
displacements_at(const any_policy<false>& policy, const kept_map& map, const displacement_lattice& where,
                 const std::vector<object_state>& states, const std::vector<std::uint32_t>& by_rank,
                 std::vector<float>& nodes, std::vector<displacement_view>& places) {
    if (map.empty()) return {};
    nodes.resize(4 * where.count());
    map.invert(policy, where, nodes.data());
    if (std::all_of(nodes.begin(), nodes.end(), [](float one) { return one == 0; })) return {};
    const vec3& spacing = where.spacing;
    const displacement_view of_background{.nodes = nodes,
                                          .size = where.size,
                                          .per_spacing = 1.0F / spacing,
                                          .at = where.at,
                                          .straight_length = 2 * min(spacing.x, min(spacing.y, spacing.z))};
    places.assign(1, of_background);
    for (const std::uint32_t i : by_rank) {
        displacement_view of_object = of_background;
        of_object.at = inverse(states[i].rest_at) * where.at;
        places.push_back(states[i].follows ? of_object : displacement_view{});
    }
    return places;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
