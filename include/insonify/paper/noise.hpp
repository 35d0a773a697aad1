#ifndef INSONIFY_PAPER_NOISE_HPP
#define INSONIFY_PAPER_NOISE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/random.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/image/image.hpp>
#include <cstddef>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

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
    exec::for_each_block(policy, picture.pixels.size(), 4096, 0.3F, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) picture.pixels[i] *= noise.pixels[i];
    });
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
