#ifndef INSONIFY_SCENE_CROSSINGS_HPP
#define INSONIFY_SCENE_CROSSINGS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/media_stack.hpp>
#include <insonify/scene/scene_view.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A point where a line crosses the surface of an object.
struct crossing {
    float distance = 0;          ///< metres from the origin of the line
    std::uint32_t rank = 0;      ///< of the object: index into `scene_view::objects`
    std::uint32_t primitive = 0; ///< face of the object's mesh

    friend bool operator==(const crossing&, const crossing&) = default;
    /// Nearest first; ties by rank, then by face.
    INSONIFY_FN friend bool operator<(const crossing& a, const crossing& b) {
        return a.distance != b.distance ? a.distance < b.distance
               : a.rank != b.rank       ? a.rank < b.rank
                                        : a.primitive < b.primitive;
    }
};

/// All crossings of one line and the objects that contain its origin, in memory of fixed capacity.
struct line_crossings {
    view<crossing> room{};   ///< for the crossings
    std::uint32_t count = 0; ///< of crossings
    bool overflow = false;   ///< there were more than fit
    media_stack inside{};    ///< the objects that contain the origin

    /// Removes all crossings and objects.
    INSONIFY_FN void clear() {
        count = 0;
        overflow = false;
        inside.clear();
    }
    /// Appends a crossing, or sets `overflow` where there is no room.
    INSONIFY_FN void add(const crossing& one) {
        if (count == room.size())
            overflow = true;
        else
            room[count++] = one;
    }
    /// Whether all crossings and containing objects fit.
    INSONIFY_FN bool complete() const { return !overflow && !inside.overflow; }

    /// Sorts the crossings, nearest first. Shell sort: fast for the nearly sorted, and available on a device.
    INSONIFY_FN void sort() {
        constexpr std::uint32_t gaps[] = {301, 57, 10, 1}; // of Ciura's sequence
        for (const std::uint32_t gap : gaps)
            for (std::uint32_t i = gap; i < count; ++i) {
                if (!(room[i] < room[i - gap])) continue;
                const crossing one = room[i];
                std::uint32_t place = i;
                for (; place >= gap && one < room[place - gap]; place -= gap) room[place] = room[place - gap];
                room[place] = one;
            }
    }
    /// The crossings, after `sort`.
    INSONIFY_FN view<const crossing> sorted() const { return {room.data(), count}; }
};

namespace detail {

/// Adds every crossing of a line with one object, from its origin to `depth` metres, in any order.
///
/// An object contains the origin if the half line crosses its surface an odd number of times. The same crossings decide
/// both, so that the two never contradict each other, even where the probe touches a surface.
INSONIFY_FN inline void add_crossings(const object_view& one, std::uint32_t rank, const ray& line, float depth,
                                      line_crossings& found) {
    const bool contains_origin = one.box.contains(line.origin);
    ray local = one.local(line);
    local.max_distance = contains_origin ? FLT_MAX : depth;
    one.tree.for_each_hit(local, [&](const hit& at) {
        if (contains_origin) found.inside.toggle(rank);
        if (at.distance <= depth) found.add({at.distance, rank, at.primitive});
    });
}

/// Adds every crossing of a line with the objects that are not skipped, from its origin to `depth` metres, in any order.
/// @param skipped  of each object, by rank; empty: none is
INSONIFY_FN inline void add_crossings(const scene_view& scene, const ray& line, float depth,
                                      view<const std::uint8_t> skipped, line_crossings& found) {
    scene.boxes.for_each_hit({line.origin, line.direction, 0, depth}, [&](const hit& at) {
        const std::uint32_t rank = at.primitive;
        if (skipped.empty() || skipped[rank] == 0) add_crossings(scene.objects[rank], rank, line, depth, found);
    });
}

} // namespace detail

/// Finds every crossing of a line from its origin to `depth` metres, nearest first, and the objects that contain its
/// origin, by a ray through the objects' trees, all of which must be up to date.
/// @return false where they do not fit into `found`
INSONIFY_FN inline bool find_crossings(const scene_view& scene, const ray& line, float depth, line_crossings& found) {
    found.clear();
    detail::add_crossings(scene, line, depth, {}, found);
    found.sort();
    return found.complete();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
