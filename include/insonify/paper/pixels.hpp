#ifndef INSONIFY_PAPER_PIXELS_HPP
#define INSONIFY_PAPER_PIXELS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/image/image.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/tracing/trace.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// A camera that views the slice, for `trace_pixels`: `size`, `through(pixel) -> ray`, `check()`.
///
/// Camera frame: x to the right of the image, y down, z into the scene, as `look_at` makes it. Pixel centres lie at
/// half integers; (0, 0) is the top left corner of the image.
template <class Camera>
concept camera = requires(const Camera& c, vec2 pixel) {
    { c.size } -> std::convertible_to<uvec2>;
    { c.through(pixel) } -> std::same_as<ray>;
    c.check();
};

namespace detail {

/// The paper's two secondary rays of one point on the slice: r2 towards the transducer, for what reaches the point, and
/// r3 away from it, for an interface within `reflection_length`. The crossings get their depths along the beam.
///
/// @param line   the beam through the point, in the world
/// @param depth  of the point along it, metres
/// @return       false where the crossings do not fit
INSONIFY_FN inline bool find_pixel_crossings(const scene_view& scene, const ray& line, float depth,
                                             float reflection_length, line_crossings& found) {
    found.clear();
    const float end = depth + reflection_length;
    const crossing_collector all{scene, {line.origin, line.direction, 0, end}, end, found};
    scene.boxes.for_each_hit(all.line, [&](const hit& box) {
        const std::uint32_t rank = box.primitive;
        const object_view& one = scene.objects[rank];
        const auto cast = [&](vec3 direction, float range, float sign) {
            one.tree.for_each_hit(one.local({.origin = line.at(depth), .direction = direction, .max_distance = range}),
                                  [&](const hit& at) {
                                      all.add({depth + sign * at.distance, rank, at.primitive});
                                  });
        };
        cast(-line.direction, depth, -1);
        cast(line.direction, all.may_begin_in(rank) ? FLT_MAX : reflection_length, 1);
    });
    found.sort();
    return found.complete();
}

/// Intensity at `depth` metres along a beam in the world: a slow reference for `trace`.
inline float intensity_at(const scene_view& scene, const law2011& model, float frequency, const ray& line, float depth,
                          line_memory& memory) {
    float intensity = 0;
    memory.fit([&](line_room room) {
        if (!find_pixel_crossings(scene, line, depth, model.reflection_length, room.found)) return false;
        const line_frame frame{.origin = line.origin, .along = line.direction};
        const view<const layer> layers =
            stack_layers(scene, frame, depth + model.reflection_length, room.found, room.layers, false);
        if (layers.empty()) return false;
        intensity = model.at({.layers = layers, .media = scene.media, .frequency = frequency}, depth);
        return true;
    });
    return intensity;
}

/// A (fractional) line of a probe in the world.
template <transducer Probe>
ray world_beam(const Probe& probe, const pose& at, float line) {
    const ray local = probe.beam(line);
    return {.origin = at.point(local.origin), .direction = at.direction(local.direction)};
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
    /// @throws usage_error     naming the setting that is out of range
    /// @throws geometry_error  for a pose that is not rigid
    void check() const {
        detail::check_size(size, "camera");
        detail::check_rigid(at, "camera");
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
    /// @throws usage_error     naming the setting that is out of range
    /// @throws geometry_error  for a pose that is not rigid
    void check() const {
        detail::check_size(size, "camera");
        detail::check_rigid(at, "camera");
        if (!(field_of_view > 0 && field_of_view < pi))
            throw usage_error{"camera: `field_of_view` must lie between 0 and 180 degrees, such as 60_deg"};
    }
};

/// The paper's algorithm to the letter, on the probe's own grid: the same values as `trace`, within rounding.
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe>
scan_lines trace_pixels(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                        const law2011& model, const acquisition& settings) {
    const std::uint32_t samples = detail::check_acquisition(body, probe, at, model, settings);
    const scene_view scene = body.view_for_rays(policy);
    scan_lines lines{probe.lines, samples, settings.depth};
    const float spacing = settings.depth / static_cast<float>(samples);
    exec::for_each_block(policy, lines.values.size(), 1024, 500, [&](std::size_t begin, std::size_t end) {
        detail::line_memory memory;
        for (std::size_t i = begin; i < end; ++i) {
            const ray line = detail::world_beam(probe, at, static_cast<float>(i / samples));
            const float depth = (static_cast<float>(i % samples) + 0.5F) * spacing;
            lines.values[i] = detail::intensity_at(scene, model, probe.frequency, line, depth, memory);
        }
    });
    return lines;
}

/// The same for the pixels of a camera: r1 from the camera to the slice finds the point of each pixel.
///
/// @param seen_by  an `orthographic_camera` or a `perspective_camera`
/// @return an image of the camera's size; black where r1 hits no point between the face and `settings.depth`
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, camera Camera>
image trace_pixels(const Policy& policy, const scene& body, const Probe& probe, const pose& at, const law2011& model,
                   const acquisition& settings, const Camera& seen_by) {
    detail::check_acquisition(body, probe, at, model, settings);
    const scene_view scene = body.view_for_rays(policy);
    seen_by.check();
    image picture{seen_by.size};
    exec::for_each_block(policy, picture.pixels.size(), 1024, 500, [&](std::size_t begin, std::size_t end) {
        detail::line_memory memory;
        for (std::size_t i = begin; i < end; ++i) {
            const ray r1 = seen_by.through(
                {static_cast<float>(i % picture.size.x) + 0.5F, static_cast<float>(i / picture.size.x) + 0.5F});
            const vec3 from = at.local_point(r1.origin), along = at.local_direction(r1.direction);
            const float distance = -from.y / along.y; // to the slice plane y = 0
            if (!(distance >= 0) || !is_finite(distance)) continue;
            const vec3 point = from + distance * along;
            const vec2 place = probe.locate({point.x, point.z});
            if (!(place.x >= -0.5F && place.x <= static_cast<float>(probe.lines) - 0.5F)) continue;
            if (!(place.y >= 0 && place.y <= settings.depth)) continue;
            const ray line = detail::world_beam(probe, at, place.x);
            picture.pixels[i] = detail::intensity_at(scene, model, probe.frequency, line, place.y, memory);
        }
    });
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
