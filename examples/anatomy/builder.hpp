#ifndef INSONIFY_EXAMPLES_ANATOMY_BUILDER_HPP
#define INSONIFY_EXAMPLES_ANATOMY_BUILDER_HPP

#include "media.hpp"
#include "region.hpp"
#include "shapes.hpp"
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace anatomy::detail {

/// A layer of a vessel's wall.
struct wall_layer {
    const char* name = "";
    const medium& inside;
    float thickness = 0; ///< metres
    float uneven = 0;    ///< fraction of the thickness by which it varies
};

/// The lumen of a vessel that is swept. @param count  of its sections
inline std::vector<tube_section> lumen_of(const swept& vein, float from, float to, int count) {
    std::vector<line_place> places;
    for (int i = 0; i < count; ++i) {
        const section here = vein.at(from + (to - from) * static_cast<float>(i) / static_cast<float>(count - 1));
        places.push_back({.centre = {here.centre.x, here.along, here.centre.y},
                          .first_axis = {std::cos(here.turn), 0, std::sin(here.turn)},
                          .radii = {here.half_width, here.half_thickness}});
    }
    return sections_of(places);
}

/// A body in the making.
struct builder {
    body made{.anatomy = scene{tissue::connective_tissue}, .views = {}, .vessels = {}};
    std::uint64_t seed = 0; ///< of all irregularities

    /// @param within  the name of the object in which it lies
    object_id add(mesh surface, const medium& inside, int priority, const std::string& name, const std::string& within,
                  const fibre_directions& fibres = {}, const layer_normals& layers = {}) {
        if (!within.empty()) made.nested.emplace_back(name, within);
        return made.anatomy.add(std::move(surface), inside,
                                {.priority = priority, .name = name, .fibres = fibres, .layer_normal = layers});
    }

    /// Adds a vessel with its walls, of lower priorities than the blood, so that branches join.
    /// @param layers    from inside to outside
    /// @param priority  of the outermost layer
    /// @param number    of its irregularities
    void add_vessel(mesh lumen, const std::vector<wall_layer>& layers, int priority, const std::string& name,
                    std::uint64_t number, const std::string& within) {
        mesh outer = lumen;
        const auto layer_name = [&](std::size_t i) {
            return i < layers.size() ? name + ": " + layers[i].name : within;
        };
        add(std::move(lumen), tissue::blood, priority + static_cast<int>(layers.size()), name, layer_name(0));
        for (std::size_t i = 0; i < layers.size(); ++i) {
            outer = grown(std::move(outer), layers[i].thickness, layers[i].uneven, 5_mm, seed + number + i);
            add(outer, layers[i].inside, priority + static_cast<int>(layers.size() - 1 - i), layer_name(i),
                layer_name(i + 1));
        }
    }
};

} // namespace anatomy::detail

#endif
