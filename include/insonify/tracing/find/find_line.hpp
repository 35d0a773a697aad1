#ifndef INSONIFY_TRACING_FIND_FIND_LINE_HPP
#define INSONIFY_TRACING_FIND_FIND_LINE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/scene/layers.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Where the crossings of a line come from: slices have found those with some objects, rays find those with the others.
struct crossing_source {
    view<const crossing> sliced{};  ///< at any distances
    view<const std::uint8_t> cut{}; ///< of each object, by rank, whether slices have cut it; empty: none
    bool rays = true;               ///< whether there are others

    /// Calls visit(crossing) for those in front of the origin.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each(const crossing_collector& collector, const Visit& visit) const {
        for (const crossing& one : sliced)
            if (one.distance >= 0) visit(one);
        if (rays) collector.trace(cut, visit);
    }
};

/// Memory of fixed capacity in which the layers of one line are found.
struct line_room {
    line_crossings found{};            ///< its crossings, and the objects that contain its origin
    view<layer> layers{};              ///< room for its layers
    view<std::uint32_t> behind_face{}; ///< room for ranks of objects
};

/// The same on the host: grows until the line fits.
struct line_memory {
    std::vector<crossing> crossings = std::vector<crossing>(64);
    std::vector<std::uint32_t> inside = std::vector<std::uint32_t>(16), behind_face = std::vector<std::uint32_t>(16);
    std::vector<layer> layers = std::vector<layer>(32);

    line_room room() { return {{.room = crossings, .inside = {.ranks = inside}}, layers, behind_face}; }

    void grow() {
        crossings.resize(2 * crossings.size());
        inside.resize(2 * inside.size());
        behind_face.resize(2 * behind_face.size());
        layers.resize(2 * layers.size());
    }

    /// Calls attempt(room), in larger and larger memory, until it returns true.
    template <class Attempt>
    void fit(const Attempt& attempt) {
        while (!attempt(room())) grow();
    }
};

/// What lies along a line, in the memory in which it was found.
struct found_line {
    view<const layer> layers{}; ///< none: the memory was too small
    view<const std::uint32_t>
        behind_face{}; ///< ranks of the objects that contain its origin, behind the face; ascending
};

/// Finds what lies along a straight line.
/// @param max_depth  how far it is followed, metres
/// @param incident   whether to compute how it intersects surfaces: see `stack_layers`
INSONIFY_FN inline found_line find_line(const scene_view& scene, const line_frame& line, float max_depth, bool incident,
                                        const crossing_source& from, line_room room) {
    room.found.clear();
    const crossing_collector collector{scene, {line.origin, line.path(), 0, max_depth}, max_depth, room.found};
    from.for_each(collector, [&](const crossing& one) { collector.add(one); });
    room.found.sort();
    if (!room.found.complete()) return {};
    media_stack behind_face{.ranks = room.behind_face};
    behind_face.assign(room.found.inside);
    for (const crossing& one : room.found.sorted()) {
        if (one.distance > touching_distance) break;
        behind_face.toggle(one.rank);
    }
    if (behind_face.overflow) return {};
    return {stack_layers(scene, line, max_depth, room.found, room.layers, incident),
            {behind_face.ranks.data(), behind_face.count}};
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
