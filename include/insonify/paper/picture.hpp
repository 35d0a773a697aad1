#ifndef INSONIFY_PAPER_PICTURE_HPP
#define INSONIFY_PAPER_PICTURE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/random.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/image/scan_convert.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Mean of the frames since the probe last moved.
///
/// Eq. 7 of the paper: the f-th frame c and the mean c' of those before it give c / f + (f - 1) / f c'. In double
/// precision, so that it remains the arithmetic mean over many frames.
class progressive {
  public:
    /// Adds a frame. Restarts where the pose of the probe or the size has changed since the previous frame.
    /// @return `picture()`
    template <exec::policy Policy>
    const image& add(const Policy& policy, const image& frame, const pose& at) {
        if (at != at_ || frame.size != picture_.size || frame.pixels.size() != mean_.size()) reset();
        if (frames_ == 0) {
            at_ = at;
            picture_ = frame;
            mean_.assign(frame.pixels.size(), 0.0);
        }
        ++frames_;
        const double f = frames_;
        exec::for_each_in_blocks(policy, mean_.size(), 4096, 1, [&](std::size_t i) {
            mean_[i] = static_cast<double>(frame.pixels[i]) / f + (f - 1) / f * mean_[i];
            picture_.pixels[i] = static_cast<float>(mean_[i]);
        });
        return picture_;
    }

    /// The mean after the last `add`.
    const image& picture() const { return picture_; }

    /// Number of frames in the mean.
    std::uint32_t frames() const { return frames_; }

    /// Restarts with the next frame: for changes that the pose does not show.
    void reset() { frames_ = 0; }

  private:
    pose at_;
    image picture_;
    std::vector<double> mean_;
    std::uint32_t frames_ = 0;
};

/// Seed and strength of the image noise.
struct noise_settings {
    std::uint64_t seed = 1; ///< selects a realization
    float strength = 1;     ///< 0: all pixels are 1; 1: the statistics of fully developed speckle
};

/// Noise image of the paper, section 3.4: made once, multiplied with every frame.
///
/// Pixels are independent factors with mean 1 and the Rayleigh distribution of the envelope of fully developed speckle
/// (mean over standard deviation 1.913). A pixel depends only on the seed, its column and its row, so a larger image
/// extends a smaller one.
/// @throws usage_error  for a size or strength out of range
template <exec::policy Policy>
image make_noise(const Policy& policy, uvec2 size, const noise_settings& settings = {}) {
    detail::check_size(size, "make_noise");
    if (!is_finite(settings.strength) || settings.strength < 0 || settings.strength > 1)
        throw usage_error{"make_noise: `strength` must be from 0 to 1"};
    image noise{size};
    exec::for_each_block(policy, size.y, 1, 15 * static_cast<float>(size.x), [&](std::size_t row, std::size_t) {
        for (std::uint32_t column = 0; column < size.x; ++column) {
            const std::uint64_t pixel = static_cast<std::uint64_t>(row) << 32U | column;
            const float uniform = 1 - hash_uniform(settings.seed, pixel); // (0, 1]: the logarithm stays finite
            const float rayleigh = std::sqrt(-4 / pi * std::log(uniform));
            noise.pixels[row * size.x + column] = 1 + settings.strength * (rayleigh - 1);
        }
    });
    return noise;
}

/// Multiplies an image by noise. In place: pass std::move(picture) to reuse the buffer.
/// @throws usage_error  for noise of another size
template <exec::policy Policy>
image add_noise(const Policy& policy, image picture, const image& noise) {
    if (picture.size != noise.size || picture.pixels.size() != noise.pixels.size())
        throw usage_error{"add_noise: the noise must have the size of the image; make it with make_noise(policy, "
                          "picture.size)"};
    exec::for_each_in_blocks(policy, picture.pixels.size(), 4096, 0.3F,
                             [&](std::size_t i) { picture.pixels[i] *= noise.pixels[i]; });
    return picture;
}

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
        exec::for_each_in_blocks(policy, place.size(), 1024, 30, [&](std::size_t i) {
            if (map.first[i] == scan_map::outside) return;
            const vec3 from = probe.beam(clamp(place[i].x + shift, -0.5F, end)).at(place[i].y);
            displaced.pixels[i] = detail::pixel_in_field(picture, map, map.pixel({from.x, from.z}), picture.pixels[i]);
        });
        mean.add(policy, displaced, pose{});
    }
    return mean.picture();
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
