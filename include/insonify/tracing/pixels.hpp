#ifndef INSONIFY_TRACING_PIXELS_HPP
#define INSONIFY_TRACING_PIXELS_HPP

#include <insonify/acoustics/law2011.hpp>
#include <insonify/core/later.hpp>
#include <insonify/fwd.hpp>
#include <insonify/tracing/beams.hpp>
#include <insonify/tracing/camera.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The paper's two secondary rays of one point on the slice: r2 towards the transducer, for what reaches the point, and
/// r3 away from it, for an interface within reach.
///
/// `line` is the beam through the point, which lies `depth` along it. The crossings are given in depths along the beam.
INSONIFY_LAZY void find_pixel_crossings(const scene& body, const ray& line, float depth, float reflection_length,
                                        line_crossings& found) {
    found.clear(body);
    auto& crossings = later<Later>(found.crossings);
    const vec3 point = line.at(depth);
    const float beyond = depth + reflection_length;
    for (const object& one : body.objects()) {
        const bool around = one.box.contains(line.origin);
        if (!around && !may_touch(one.box, line, beyond)) continue;
        const ray r2 =
            one.local({.origin = point, .direction = -line.direction, .max_distance = around ? FLT_MAX : depth});
        one.tree_view().for_each_hit(r2, [&](const hit& at) {
            if (at.distance <= depth)
                crossings.push_back({depth - at.distance, one.rank, at.primitive});
            else
                found.inside.toggle(one.rank);
        });
        const ray r3 = one.local({.origin = point, .direction = line.direction, .max_distance = reflection_length});
        one.tree_view().for_each_hit(r3, [&](const hit& at) {
            crossings.push_back({depth + at.distance, one.rank, at.primitive});
        });
    }
    found.sort();
}

/// Traces points of the slice one by one, as the paper does: much work twice, kept as the reference for `trace_beams`.
class pixel_tracer {
  public:
    /// Refers to scene and model: keep them. @param frequency  hertz
    INSONIFY_LAZY pixel_tracer(const scene& body, const law2011& model, float frequency)
        : body_{body}, model_{model}, frequency_{frequency} {}

    /// Intensity at `depth` metres along a beam in the world.
    INSONIFY_LAZY float operator()(const ray& line, float depth) {
        find_pixel_crossings(body_, line, depth, model_.reflection_length, found_);
        stack_layers(body_, {.origin = line.origin, .along = line.direction}, depth + model_.reflection_length, found_,
                     layers_, angles::skip);
        return model_.at({layers_, body_.media(), frequency_}, depth);
    }

  private:
    const scene& body_;
    const law2011& model_;
    float frequency_;
    line_crossings found_;
    std::vector<layer> layers_;
};

/// The paper's algorithm to the letter, on the probe's own grid: the same values as `trace_beams`, within rounding.
/// @throws usage_error, geometry_error  as `trace_beams`
template <exec::policy Policy, transducer Probe>
scan_lines trace_pixels(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                        const law2011& model, const acquisition& settings) {
    const std::uint32_t samples = check_acquisition(body, probe, at, model, settings);
    body.require_trees();
    scan_lines lines{probe.lines, samples, settings.depth};
    const float spacing = settings.depth / static_cast<float>(samples);
    exec::for_each_block(policy, lines.values.size(), 1024, 500, [&](std::size_t begin, std::size_t end) {
        pixel_tracer tracer{body, model, probe.frequency};
        for (std::size_t i = begin; i < end; ++i) {
            const ray line = world_beam(probe, at, static_cast<float>(i / samples));
            lines.values[i] = tracer(line, (static_cast<float>(i % samples) + 0.5F) * spacing);
        }
    });
    return lines;
}

/// The same as a camera sees the slice: r1 from the camera to the slice finds the point of each pixel.
///
/// @param seen_by  an `orthographic_camera` or a `perspective_camera`
/// @return a picture of the camera's size; black where r1 meets no point between the face and `settings.depth`
/// @tparam Image    a picture, complete where this is called: include image/image.hpp
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, camera Camera, class Image = image>
Image trace_pixels(const Policy& policy, const scene& body, const Probe& probe, const pose& at, const law2011& model,
                   const acquisition& settings, const Camera& seen_by) {
    check_acquisition(body, probe, at, model, settings);
    body.require_trees();
    seen_by.check();
    Image picture{seen_by.size};
    exec::for_each_block(policy, picture.pixels.size(), 1024, 500, [&](std::size_t begin, std::size_t end) {
        pixel_tracer tracer{body, model, probe.frequency};
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
            picture.pixels[i] = tracer(world_beam(probe, at, place.x), place.y);
        }
    });
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
