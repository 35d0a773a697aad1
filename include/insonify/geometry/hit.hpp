#ifndef INSONIFY_GEOMETRY_HIT_HPP
#define INSONIFY_GEOMETRY_HIT_HPP

#include <insonify/core/config.hpp>
#include <cfloat>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Where a ray meets a primitive; converts to false where it meets none.
struct hit {
    float distance = FLT_MAX;      ///< along the ray, in units of its direction
    std::uint32_t primitive = ~0U; ///< index into the range that the tree was built over

    /// Whether anything was met.
    INSONIFY_FN constexpr explicit operator bool() const { return distance < FLT_MAX; }

    friend bool operator==(const hit&, const hit&) = default;
};

/// Nearest first; of equally near ones the lower index first.
INSONIFY_FN constexpr bool nearer(const hit& a, const hit& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.primitive < b.primitive);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
