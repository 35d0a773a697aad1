#ifndef INSONIFY_SCENE_SLICE_FRAME_HPP
#define INSONIFY_SCENE_SLICE_FRAME_HPP

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/pose.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Parallel slices, in the coordinates of whatever they cut: `across` and `along` span them, `elevation` is their
/// normal.
///
/// A point has the level n where n slices lie below it. One in a slice lies below it, as if every slice stood an
/// infinitesimal step higher.
struct slice_frame {
    static constexpr std::uint32_t most = 8;

    vec3 origin{0, 0, 0};
    vec3 across{1, 0, 0};
    vec3 elevation{0, 1, 0};
    vec3 along{0, 0, 1};
    std::uint32_t count = 0;
    float height[most] = {};         ///< of the slices over the origin, ascending, metres
    std::uint32_t number[most] = {}; ///< what the caller calls them

    slice_frame() = default;

    /// @param offsets  heights of the slices in the caller's order, `most` at most
    INSONIFY_LAZY slice_frame(const pose& at, view<const float> offsets)
        : origin{at.translation}, across{at.rotation[0]}, elevation{at.rotation[1]}, along{at.rotation[2]},
          count{static_cast<std::uint32_t>(offsets.size())} {
        for (std::uint32_t i = 0; i < count; ++i) { // sorted in where it belongs
            std::uint32_t place = i;
            for (; place > 0 && offsets[i] < height[place - 1]; --place) {
                height[place] = height[place - 1];
                number[place] = number[place - 1];
            }
            height[place] = offsets[i];
            number[place] = i;
        }
    }

    /// The same slices as an object sees them that stands in the world as `at` says.
    INSONIFY_LAZY slice_frame local(const pose& at) const {
        slice_frame l = *this;
        l.origin = at.local_point(origin);
        l.across = at.local_direction(across);
        l.elevation = at.local_direction(elevation);
        l.along = at.local_direction(along);
        return l;
    }

    /// Every copy of a point gets the very same result, also among others in SIMD.
    INSONIFY_LAZY float height_of(vec3 p) const { return height_of(p.x, p.y, p.z); }
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
    INSONIFY_LAZY vec2 place_of(vec3 p) const { return {across_of(p.x, p.y, p.z), along_of(p.x, p.y, p.z)}; }

  private:
    template <class Float>
    INSONIFY_INLINE Float component(vec3 axis, const Float& px, const Float& py, const Float& pz) const {
        const Float x = px - Float(origin.x), y = py - Float(origin.y), z = pz - Float(origin.z);
        return multiply_add(Float(axis.x), x, multiply_add(Float(axis.y), y, Float(axis.z) * z));
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
