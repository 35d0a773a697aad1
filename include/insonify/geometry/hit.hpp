#ifndef INSONIFY_GEOMETRY_HIT_HPP
#define INSONIFY_GEOMETRY_HIT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cfloat>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Intersection of a ray with a primitive; converts to false for a miss.
struct hit {
    float distance = FLT_MAX;      ///< along the ray, in units of its direction
    std::uint32_t primitive = ~0U; ///< index into the range that the BVH was built over

    /// False for a miss.
    INSONIFY_FN constexpr explicit operator bool() const { return distance < FLT_MAX; }

    friend bool operator==(const hit&, const hit&) = default;
};

/// Order of hits: by distance, then by index.
INSONIFY_FN constexpr bool nearer(const hit& a, const hit& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.primitive < b.primitive);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
