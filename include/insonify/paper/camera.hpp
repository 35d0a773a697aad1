#ifndef INSONIFY_PAPER_CAMERA_HPP
#define INSONIFY_PAPER_CAMERA_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/ray.hpp>
#include <concepts>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// A camera that views the slice, for `trace_pixels`: `size`, `through(pixel) -> ray`, `check()`.
///
/// Camera frame: x to the right of the image, y down, z into the scene, as `look_at` makes it. Pixel centres lie at half
/// integers; (0, 0) is the top left corner of the image.
template <class Camera>
concept camera = requires(const Camera& c, vec2 pixel) {
    { c.size } -> std::convertible_to<uvec2>;
    { c.through(pixel) } -> std::same_as<ray>;
    c.check();
};

namespace detail {

/// @throws usage_error  for an image without pixels or of more than 2^28, or a pose that is not rigid
inline void check_camera(uvec2 size, const pose& at) {
    const std::uint64_t pixels = std::uint64_t{size.x} * size.y;
    if (pixels == 0 || pixels > std::uint64_t{1} << 28U)
        throw usage_error{"camera: `size` must be at least 1 x 1 and at most 2^28 pixels in all"};
    if (!is_rigid(at))
        throw usage_error{
            "camera: its pose is not a rigid transform; make it with look_at, or mend it with orthonormalised"};
}

} // namespace detail

/// Parallel rays: the slice at scale.
struct orthographic_camera {
    pose at{};               ///< camera to world
    vec2 extent{0.1F, 0.1F}; ///< width and height of the image in the world, metres
    uvec2 size{512, 512};    ///< columns, rows

    /// The ray through a point of the image, in the world; its direction has length 1.
    INSONIFY_FN ray through(vec2 pixel) const {
        const vec2 fraction = pixel / vec2{size} - 0.5F;
        return {.origin = at.point({fraction.x * extent.x, fraction.y * extent.y, 0}),
                .direction = at.direction({0, 0, 1})};
    }
    /// @throws usage_error  naming the setting that is out of range
    void check() const {
        detail::check_camera(size, at);
        if (!is_finite(extent.x) || !is_finite(extent.y) || !(extent.x > 0) || !(extent.y > 0))
            throw usage_error{"camera: `extent` must be two finite lengths in metres above 0"};
    }
};

/// Rays from one point.
struct perspective_camera {
    pose at{};                    ///< camera to world
    float field_of_view = 60_deg; ///< across the image, radians
    uvec2 size{512, 512};         ///< columns, rows

    /// The ray through a point of the image, in the world; its direction has length 1.
    INSONIFY_FN ray through(vec2 pixel) const {
        const float scale = 2 * std::tan(0.5F * field_of_view) / static_cast<float>(size.x);
        const vec2 from_centre = pixel - 0.5F * vec2{size};
        return {.origin = at.translation,
                .direction = at.direction(normalize(vec3{scale * from_centre.x, scale * from_centre.y, 1}))};
    }
    /// @throws usage_error  naming the setting that is out of range
    void check() const {
        detail::check_camera(size, at);
        if (!(field_of_view > 0 && field_of_view < pi))
            throw usage_error{"camera: `field_of_view` must lie between 0 and 180 degrees, such as 60_deg"};
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
