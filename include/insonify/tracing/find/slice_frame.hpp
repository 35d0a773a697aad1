#ifndef INSONIFY_TRACING_FIND_SLICE_FRAME_HPP
#define INSONIFY_TRACING_FIND_SLICE_FRAME_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/signal/kernel/elevation_plane.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Slices in world or object coordinates. Each is the plane of `across` and `along`, displaced in elevation by an offset and a
/// tilt; positions in it are those in the plane before.
///
/// The level of a point has a bit for each slice below it. A point on a slice counts as below it, as if every slice were
/// shifted upwards by an infinitesimal step.
struct slice_frame {
    static constexpr std::uint32_t max_slices = 8;

    vec3 origin{0, 0, 0};
    vec3 across{1, 0, 0};
    vec3 along{0, 0, 1};
    std::uint32_t count = 0;
    vec3 normal[max_slices] = {};  ///< elevation less the slope of the slice times the depth axis: not of length 1
    float height[max_slices] = {}; ///< along its normal, of the points of a slice above the origin, metres

    slice_frame() = default;

    /// @param probe_at  whose coordinates the planes are in
    /// @param planes    at most `max_slices`
    /// @param fan       coordinates of positions in the slice plane, to those of the probe
    slice_frame(const pose& probe_at, view<const detail::elevation_plane> planes, const pose& fan = {})
        : count{static_cast<std::uint32_t>(planes.size())} {
        const pose at = probe_at * fan;
        origin = at.translation;
        across = at.rotation[0];
        along = at.rotation[2];
        for (std::uint32_t i = 0; i < count; ++i) {
            normal[i] = at.rotation[1] - planes[i].slope * probe_at.rotation[2];
            height[i] = planes[i].height(fan.translation.z);
        }
    }

    /// The same slices in the coordinates of an object. @param at  object to world
    slice_frame local(const pose& at) const {
        slice_frame l = *this;
        l.origin = at.local_point(origin);
        l.across = at.local_direction(across);
        l.along = at.local_direction(along);
        for (vec3& n : l.normal) n = at.local_direction(n);
        return l;
    }

    /// Component along an axis of a point relative to the origin; bit-equal for every copy of a point, scalar or in SIMD.
    template <class Float>
    INSONIFY_INLINE static Float component(vec3 axis, const Float& x, const Float& y, const Float& z) {
        return multiply_add(Float(axis.x), x, multiply_add(Float(axis.y), y, Float(axis.z) * z));
    }

    /// Height of a point along the normal of a slice.
    float height_of(std::uint32_t slice, vec3 p) const { return height_of(slice, p.x, p.y, p.z); }
    template <class Float>
    INSONIFY_INLINE Float height_of(std::uint32_t slice, const Float& x, const Float& y, const Float& z) const {
        return component_of(normal[slice], x, y, z);
    }
    template <class Float>
    INSONIFY_INLINE Float across_of(const Float& x, const Float& y, const Float& z) const {
        return component_of(across, x, y, z);
    }
    template <class Float>
    INSONIFY_INLINE Float along_of(const Float& x, const Float& y, const Float& z) const {
        return component_of(along, x, y, z);
    }
    vec2 place_of(vec3 p) const { return {across_of(p.x, p.y, p.z), along_of(p.x, p.y, p.z)}; }

  private:
    template <class Float>
    INSONIFY_INLINE Float component_of(vec3 axis, const Float& x, const Float& y, const Float& z) const {
        return component(axis, x - Float(origin.x), y - Float(origin.y), z - Float(origin.z));
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
