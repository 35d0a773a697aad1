#ifndef INSONIFY_SCENE_MEDIA_STACK_HPP
#define INSONIFY_SCENE_MEDIA_STACK_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
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

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
