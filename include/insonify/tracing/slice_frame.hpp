#ifndef INSONIFY_TRACING_SLICE_FRAME_HPP
#define INSONIFY_TRACING_SLICE_FRAME_HPP

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/pose.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Parallel slices in world or object coordinates: `across` and `along` span them, `elevation` is their normal.
///
/// The level of a point is the number of slices below it. A point on a slice counts as below it, as if every slice were
/// shifted upwards by an infinitesimal step.
struct slice_frame {
    static constexpr std::uint32_t max_slices = 8;

    vec3 origin{0, 0, 0};
    vec3 across{1, 0, 0};
    vec3 elevation{0, 1, 0};
    vec3 along{0, 0, 1};
    std::uint32_t count = 0;
    float height[max_slices] = {};         ///< of the slices above the origin, ascending, metres
    std::uint32_t number[max_slices] = {}; ///< the caller's index of each slice

    slice_frame() = default;

    /// @param offsets  heights of the slices in the caller's order, at most `max_slices`
    slice_frame(const pose& at, view<const float> offsets)
        : origin{at.translation}, across{at.rotation[0]}, elevation{at.rotation[1]}, along{at.rotation[2]},
          count{static_cast<std::uint32_t>(offsets.size())} {
        for (std::uint32_t i = 0; i < count; ++i) { // insertion sort
            std::uint32_t place = i;
            for (; place > 0 && offsets[i] < height[place - 1]; --place) {
                height[place] = height[place - 1];
                number[place] = number[place - 1];
            }
            height[place] = offsets[i];
            number[place] = i;
        }
    }

    /// The same slices in the coordinates of an object. @param at  object to world
    slice_frame local(const pose& at) const {
        slice_frame l = *this;
        l.origin = at.local_point(origin);
        l.across = at.local_direction(across);
        l.elevation = at.local_direction(elevation);
        l.along = at.local_direction(along);
        return l;
    }

    /// Bit-equal for every copy of a point, scalar or in SIMD.
    float height_of(vec3 p) const { return height_of(p.x, p.y, p.z); }
    template <class Float>
    INSONIFY_INLINE Float height_of(const Float& x, const Float& y, const Float& z) const {
        return component(elevation, x, y, z);
    }
    template <class Float>
    INSONIFY_INLINE Float across_of(const Float& x, const Float& y, const Float& z) const {
        return component(across, x, y, z);
    }
    template <class Float>
    INSONIFY_INLINE Float along_of(const Float& x, const Float& y, const Float& z) const {
        return component(along, x, y, z);
    }
    vec2 place_of(vec3 p) const { return {across_of(p.x, p.y, p.z), along_of(p.x, p.y, p.z)}; }

  private:
    template <class Float>
    INSONIFY_INLINE Float component(vec3 axis, const Float& px, const Float& py, const Float& pz) const {
        const Float x = px - Float(origin.x), y = py - Float(origin.y), z = pz - Float(origin.z);
        return multiply_add(Float(axis.x), x, multiply_add(Float(axis.y), y, Float(axis.z) * z));
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
