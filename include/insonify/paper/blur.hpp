#ifndef INSONIFY_PAPER_BLUR_HPP
#define INSONIFY_PAPER_BLUR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/image/scan_convert.hpp>
#include <insonify/paper/progressive.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Displacements of the radial blur.
struct radial_blur_settings {
    float lines = 1.5F;       ///< largest displacement to either side, in lines
    std::uint32_t frames = 9; ///< displaced frames, at the centres of equal parts of that range
};

namespace detail {

/// Bilinear interpolation at pixel coordinates between those neighbours that lie in the field of view, so that the
/// background does not bleed in; `otherwise` where there are none.
inline float pixel_in_field(const image& picture, const scan_map& map, vec2 at, float otherwise) {
    const float left = std::floor(at.x - 0.5F);
    const float top = std::floor(at.y - 0.5F);
    float sum = 0;
    float weights = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const float x = left + static_cast<float>(corner & 1);
        const float y = top + static_cast<float>(corner >> 1);
        if (!(x >= 0 && y >= 0 && x < static_cast<float>(map.size.x) && y < static_cast<float>(map.size.y))) continue;
        const std::size_t i = static_cast<std::size_t>(y) * map.size.x + static_cast<std::size_t>(x);
        if (map.first[i] == scan_map::outside) continue;
        const float weight = (1 - std::fabs(at.x - 0.5F - x)) * (1 - std::fabs(at.y - 0.5F - y));
        sum += weight * picture.pixels[i];
        weights += weight;
    }
    return weights > 0 ? sum / weights : otherwise;
}

} // namespace detail

/// Radial blur of the paper, section 3.4: the progressive mean of frames rotated about the apex of the probe.
///
/// Frames are displaced by lines instead of angles: a rotation for a sector, a translation for a linear array. Pixels
/// outside the field of view are unchanged and do not bleed into it.
/// @param map  the map that the image was made with
/// @throws usage_error  where image, probe and map do not match, or a setting is out of range
template <exec::policy Policy, transducer Probe>
image radial_blur(const Policy& policy, const image& picture, const Probe& probe, const scan_map& map,
                  const radial_blur_settings& settings = {}) {
    probe.check();
    if (picture.size != map.size || picture.pixels.size() != map.first.size() || probe.lines != map.count)
        throw usage_error{"radial_blur: the image must have been made with this map, and the map for this probe"};
    if (!is_finite(settings.lines) || !(settings.lines >= 0) || settings.frames == 0)
        throw usage_error{"radial_blur: `lines` must be finite and not negative, and `frames` at least 1"};

    std::vector<vec2> place(picture.pixels.size()); // line and depth of each pixel
    exec::for_each_block(policy, map.size.y, 1, 15 * static_cast<float>(map.size.x), [&](std::size_t row, std::size_t) {
        for (std::uint32_t x = 0; x < map.size.x; ++x)
            place[row * map.size.x + x] = probe.locate(map.point(x, static_cast<std::uint32_t>(row)));
    });

    const float end = static_cast<float>(probe.lines) - 0.5F;
    image displaced = picture;
    progressive mean;
    for (std::uint32_t frame = 0; frame < settings.frames; ++frame) {
        const float shift =
            2 * settings.lines * ((static_cast<float>(frame) + 0.5F) / static_cast<float>(settings.frames) - 0.5F);
        exec::for_each_block(policy, place.size(), 1024, 30, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                if (map.first[i] == scan_map::outside) continue;
                const vec3 from = probe.beam(clamp(place[i].x + shift, -0.5F, end)).at(place[i].y);
                displaced.pixels[i] =
                    detail::pixel_in_field(picture, map, map.pixel({from.x, from.z}), picture.pixels[i]);
            }
        });
        mean.add(policy, displaced, pose{});
    }
    return mean.picture();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
