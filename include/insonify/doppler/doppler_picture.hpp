#ifndef INSONIFY_DOPPLER_DOPPLER_PICTURE_HPP
#define INSONIFY_DOPPLER_DOPPLER_PICTURE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/autocorrelation.hpp>
#include <insonify/image/colour_image.hpp>
#include <insonify/image/scan_convert.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What counts as flow in a picture.
struct doppler_picture_settings {
    uvec2 size{0, 0};          ///< columns, rows: see `scan_convert_settings`
    float min_power_db = -126; ///< weaker echoes show no flow; electronic noise is at -135 dB. 0 dB is a perfect mirror
    float min_velocity = 0;    ///< slower flow is not shown, m/s

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(min_power_db) || !is_finite(min_velocity))
            throw usage_error{"doppler_picture: `min_power_db` and `min_velocity` must be finite"};
    }

    friend bool operator==(const doppler_picture_settings&, const doppler_picture_settings&) = default;
};

/// What a colour means: velocity towards the probe from red to yellow, away from it from blue to cyan; or power from dark
/// red to yellow.
enum class doppler_map { velocity, power };

/// Settings of `colour_overlay`.
struct colour_overlay_settings {
    doppler_map map = doppler_map::velocity; ///< what is shown
    float max_velocity = 0;                  ///< of the brightest colour, m/s; 0: the largest that does not alias
    float power_range_db = 30;               ///< from the darkest to the brightest colour of `doppler_map::power`
    float min_power_db = -126;               ///< see `doppler_picture_settings`
    float min_velocity = 0;                  ///< likewise, m/s
    float max_grey = 0.6F; ///< priority: brighter tissue is shown in grey, 0 (never colour) to 1 (always colour)

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(min_power_db) || !is_finite(min_velocity) || !is_finite(max_velocity) || !(max_velocity >= 0) ||
            !is_finite(power_range_db) || !(power_range_db > 0) || !is_finite(max_grey))
            throw usage_error{"colour_overlay: `power_range_db` must be above 0, `max_velocity` at least 0, and both, "
                              "`min_power_db`, `min_velocity` and `max_grey` finite"};
    }

    friend bool operator==(const colour_overlay_settings&, const colour_overlay_settings&) = default;
};

/// The colour of a velocity. @param share  of the largest, -1 (away) to 1 (towards the probe)
INSONIFY_FN inline vec3 velocity_colour(float fraction) {
    const float fast = min(std::fabs(fraction), 1), strong = 0.35F + 0.65F * min(1.6F * fast, 1),
                bright = max(fast - 0.35F, 0) / 0.65F;
    return fraction > 0 ? vec3{strong, 0.9F * bright, 0} : vec3{0, 0.9F * bright, strong};
}
/// The colour of a power. @param share  0 (weakest) to 1 (strongest)
INSONIFY_FN inline vec3 power_colour(float fraction) {
    const float level = clamp(fraction, 0, 1);
    return {0.35F + 0.65F * min(1.5F * level, 1), 0.9F * max(level - 0.3F, 0) / 0.7F, 0.1F * level};
}

namespace detail {

/// Velocity and power of each pixel, 0 outside the field of view. Interpolates phasors, so aliased velocities do not pass
/// through 0 on their way from one end of the range to the other.
template <exec::policy Policy, class Pixel>
void for_each_flow_pixel(const Policy& policy, const flow_lines& lines, const scan_map& map, const Pixel& pixel) {
    check_lines_of_map<flow_sample>(lines, map);
    const float turn = lines.max_velocity > 0 ? pi / lines.max_velocity : 0, scale = lines.max_velocity / pi;
    const std::size_t next = map.samples > 1 ? 1 : 0;
    exec::for_each_block(policy, map.size.y, 1, 40 * static_cast<float>(map.size.x), [&](std::size_t y, std::size_t) {
        for (std::size_t i = y * map.size.x; i < (y + 1) * map.size.x; ++i) {
            if (map.first[i] == scan_map::outside) {
                pixel(i, flow_sample{});
                continue;
            }
            const std::size_t here = map.first[i], beside = map.beside(map.first[i]);
            const float across = map.across[i], along = map.along[i];
            vec2 phasor{0, 0};
            float power = 0;
            const auto add = [&](const flow_sample& sample, float weight) {
                const float angle = turn * sample.velocity;
                phasor += weight * sample.power * vec2{std::cos(angle), std::sin(angle)};
                power += weight * sample.power;
            };
            add(lines.values[here], (1 - across) * (1 - along));
            add(lines.values[here + next], (1 - across) * along);
            add(lines.values[beside], across * (1 - along));
            add(lines.values[beside + next], across * along);
            pixel(i, flow_sample{.velocity = power > 0 ? scale * std::atan2(phasor.y, phasor.x) : 0, .power = power});
        }
    });
}

/// Whether a pixel shows flow.
INSONIFY_FN inline bool shows_flow(const flow_sample& of, float min_power, float min_velocity) {
    return of.power >= min_power && of.power > 0 && std::fabs(of.velocity) >= min_velocity;
}
/// Power ratio of a level in decibels.
INSONIFY_FN inline float power_of_decibels(float level) { return std::exp2(0.33219281F * level); } // log2(10) / 10

} // namespace detail

/// Velocity of each pixel, m/s, towards the probe positive; 0 where there is no flow.
/// @param probe  that the lines are of
/// @throws usage_error  for lines that are empty or not those of the probe, or a setting out of range
template <exec::policy Policy, transducer Probe>
image doppler_picture(const Policy& policy, const flow_lines& lines, const Probe& probe,
                      const doppler_picture_settings& settings = {}) {
    settings.check();
    const scan_map map =
        make_scan_map(policy, probe, detail::acquisition_of<flow_sample>(lines), {.size = settings.size});
    image picture{map.size};
    const float min_power = detail::power_of_decibels(settings.min_power_db);
    detail::for_each_flow_pixel(policy, lines, map, [&](std::size_t i, const flow_sample& of) {
        if (detail::shows_flow(of, min_power, settings.min_velocity)) picture.pixels[i] = of.velocity;
    });
    return picture;
}

/// Colour over a B-mode image: flow is coloured where the image is dark enough, the rest is grey.
///
///     const image grey = b_mode(exec::par_unseq, body, probe, at, {.depth = 40_mm});
///     const flow_lines seen = colour_doppler(exec::par_unseq, body, probe, at, stream, {.depth = 40_mm});
///     write_png("duplex.png", colour_overlay(exec::par, grey, seen, probe));
///
/// @param grey   an image of the same probe and depth
/// @param probe  that the lines are of
/// @throws usage_error  for lines that are empty or not those of the probe, an image of another size, or a setting out of range
template <exec::policy Policy, transducer Probe>
colour_image colour_overlay(const Policy& policy, const image& grey, const flow_lines& lines, const Probe& probe,
                            const colour_overlay_settings& settings = {}) {
    settings.check();
    const scan_map map = make_scan_map(policy, probe, detail::acquisition_of<flow_sample>(lines), {.size = grey.size});
    if (grey.pixels.size() != map.first.size())
        throw usage_error{"colour_overlay: the image has no pixels, or not as many as its size says"};
    colour_image picture{grey.size};
    const float min_power = detail::power_of_decibels(settings.min_power_db);
    const float fastest = settings.max_velocity > 0 ? settings.max_velocity : max(lines.max_velocity, 1e-9F);
    detail::for_each_flow_pixel(policy, lines, map, [&](std::size_t i, const flow_sample& of) {
        const float level = clamp(grey.pixels[i], 0, 1);
        if (level > settings.max_grey || !detail::shows_flow(of, min_power, settings.min_velocity))
            picture.pixels[i] = vec3{level};
        else if (settings.map == doppler_map::velocity)
            picture.pixels[i] = velocity_colour(of.velocity / fastest);
        else
            picture.pixels[i] =
                power_colour((10 * std::log10(of.power) - settings.min_power_db) / max(settings.power_range_db, 1e-3F));
    });
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
