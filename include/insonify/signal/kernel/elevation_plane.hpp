#ifndef INSONIFY_SIGNAL_KERNEL_ELEVATION_PLANE_HPP
#define INSONIFY_SIGNAL_KERNEL_ELEVATION_PLANE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// A plane in the coordinates of a probe, y = offset + slope z: the slice plane, or one above or below it that is tilted about
/// the lateral axis.
struct elevation_plane {
    float offset = 0; ///< metres out of the slice plane at z = 0
    float slope = 0;  ///< metres out of the slice plane per metre of depth

    /// Metres out of the slice plane at a depth in metres.
    INSONIFY_FN float height(float depth) const { return offset + slope * depth; }
};

} // namespace detail

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
