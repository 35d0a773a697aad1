#ifndef INSONIFY_B_MODE_HPP
#define INSONIFY_B_MODE_HPP

#include <insonify/acoustics/law2011.hpp>
#include <insonify/image/blur.hpp>
#include <insonify/image/noise.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/tracing/trace.hpp>

namespace insonify::inline INSONIFY_ABI {

struct b_mode_settings {
    float depth = 0.08F;         ///< metres
    std::uint32_t samples = 0;   ///< along each line; 0: chosen from depth and frequency
    uvec2 size{0, 0};            ///< columns, rows; see `scan_convert_settings`
    float dynamic_range_db = 60; ///< from black to white
    float reference_db = -25;    ///< the level that is white; 0 dB is the echo of a perfect mirror
    noise_settings noise{};      ///< of the speckle
    radial_blur_settings blur{}; ///< of the beam's width
};

/// The whole chain in one call: a B-mode picture.
///
/// Echoes by `law2011` as amplitudes that travel there and back, weakened on the way, beyond their interface, and of
/// each medium's texture; time-gain compensation for the background's attenuation, between 0.5 and 1 dB/(cm MHz); scan
/// conversion, noise, radial blur; decibels. The levels are fixed: a clip does not flicker.
/// @throws usage_error     for an unbuilt scene, senseless settings, absurd sizes
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
image b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
             const b_mode_settings& settings = {}) {
    const log_compress_settings grey{.dynamic_range_db = settings.dynamic_range_db,
                                     .reference_db = settings.reference_db};
    grey.check();
    const law2011 model{.reflection_length = 2 * 1540 / probe.frequency,
                        .travel = travel::two_way,
                        .reflection = reflection::attenuated,
                        .band = band::after,
                        .spectrum = spectrum::power_law,
                        .incident = incident::backscattered};
    constexpr std::uint32_t rays = 4; // a line, so that a steep surface is no staircase
    Probe fine = probe;
    fine.lines *= rays;
    scan_lines lines = trace(policy, body, fine, at, model, {.depth = settings.depth, .samples = settings.samples});
    lines = tgc(policy, std::move(lines), probe.frequency,
                {.attenuation = clamped(body.background().attenuation, 50, 100)});
    const scan_map map =
        make_scan_map(policy, fine, {.depth = lines.depth, .samples = lines.samples}, {.size = settings.size});
    image picture = scan_convert(policy, lines, map);
    picture = add_noise(policy, std::move(picture), make_noise(policy, map.size, settings.noise));
    picture =
        radial_blur(policy, picture, fine, map, {.lines = rays * settings.blur.lines, .frames = settings.blur.frames});
    exec::for_each_block(policy, picture.pixels.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) picture.pixels[i] = grey.grey(picture.pixels[i]);
    });
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
