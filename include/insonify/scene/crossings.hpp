#ifndef INSONIFY_SCENE_CROSSINGS_HPP
#define INSONIFY_SCENE_CROSSINGS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/scene/scene_view.hpp>
#include <cstddef>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// The objects that contain a point moving along a line, as ascending ranks in memory of fixed capacity. The first one's
/// medium applies.
struct media_stack {
    static constexpr std::uint32_t none = ~0U; ///< rank of the background

    view<std::uint32_t> ranks{}; ///< room for as many objects as may contain a point
    std::uint32_t count = 0;     ///< objects that do
    bool overflow = false;       ///< there were more than fit

    /// Outside all objects.
    INSONIFY_FN void clear() {
        count = 0;
        overflow = false;
    }

    /// The point crosses the surface of an object: enters it, or leaves it.
    INSONIFY_FN void toggle(std::uint32_t rank) {
        std::uint32_t place = 0;
        while (place < count && ranks[place] < rank) ++place;
        if (place < count && ranks[place] == rank) {
            --count;
            for (; place < count; ++place) ranks[place] = ranks[place + 1];
        } else if (count == ranks.size()) {
            overflow = true;
        } else {
            for (std::uint32_t i = count; i > place; --i) ranks[i] = ranks[i - 1];
            ranks[place] = rank;
            ++count;
        }
    }

    /// Whether the point is in this object.
    INSONIFY_FN bool contains(std::uint32_t rank) const {
        for (std::uint32_t i = 0; i < count; ++i)
            if (ranks[i] == rank) return true;
        return false;
    }

    /// Rank of the object whose medium applies; `none` outside all.
    INSONIFY_FN std::uint32_t top() const { return count > 0 ? ranks[0] : none; }

    /// Takes over the objects of another stack, not its memory.
    INSONIFY_FN void assign(const media_stack& other) {
        overflow = other.overflow || other.count > ranks.size();
        count = overflow ? 0 : other.count;
        for (std::uint32_t i = 0; i < count; ++i) ranks[i] = other.ranks[i];
    }
};

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

/// Collects the crossings of one line, in any order, wherever they come from.
///
/// An object contains the origin if the half line crosses its surface an odd number of times. The same crossings decide
/// both, so that the two never contradict each other, even where the probe touches a surface.
struct crossing_collector {
    const scene_view& scene;
    ray line{};      ///< in the world
    float depth = 0; ///< where it ends, metres
    line_crossings& found;

    INSONIFY_FN bool may_begin_in(std::uint32_t rank) const { return scene.objects[rank].box.contains(line.origin); }
    /// Adds a crossing at any distance in front of the origin. All of an object that the line may begin in are to be added.
    INSONIFY_FN void add(const crossing& one) const {
        if (may_begin_in(one.rank)) found.inside.toggle(one.rank);
        if (one.distance <= depth) found.add(one);
    }
    /// Visits those with the objects that are not skipped, by rays through their trees.
    /// @param skipped  of each object, by rank; empty: none is
    /// @param visit    visit(crossing), `add` or what calls it
    template <class Visit>
    INSONIFY_FN void trace(view<const std::uint8_t> skipped, const Visit& visit) const {
        scene.boxes.for_each_hit({line.origin, line.direction, 0, line.max_distance}, [&](const hit& box) {
            const std::uint32_t rank = box.primitive;
            if (!skipped.empty() && skipped[rank] != 0) return;
            const object_view& one = scene.objects[rank];
            ray local = one.local(line);
            if (may_begin_in(rank)) local.max_distance = FLT_MAX;
            one.tree.for_each_hit(local, crossing_of<Visit>{rank, visit});
        });
    }

  private:
    template <class Visit>
    struct crossing_of {
        std::uint32_t rank;
        const Visit& visit;

        INSONIFY_VISITS
        INSONIFY_FN void operator()(const hit& at) const { visit(crossing{at.distance, rank, at.primitive}); }
    };
};

} // namespace detail

/// Finds every crossing of a line from its origin to `depth` metres, nearest first, and the objects that contain its
/// origin, by a ray through the objects' trees, all of which must be up to date.
/// @return false where they do not fit into `found`
INSONIFY_FN inline bool find_crossings(const scene_view& scene, const ray& line, float depth, line_crossings& found) {
    found.clear();
    const detail::crossing_collector collector{scene, {line.origin, line.direction, 0, depth}, depth, found};
    collector.trace({}, [&](const crossing& one) { collector.add(one); });
    found.sort();
    return found.complete();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
