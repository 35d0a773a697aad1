#ifndef INSONIFY_SIGNAL_ELECTRONIC_NOISE_HPP
#define INSONIFY_SIGNAL_ELECTRONIC_NOISE_HPP

#include <insonify/core/decibels.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/execution/simd_math.hpp>
#include <insonify/probe/line_grid.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Level and seed of the electronic noise.
struct electronic_noise_settings {
    float level_db = -135;   ///< rms of its envelope, relative to the echo of a perfect mirror; `no_level_db`: none
    std::uint64_t seed = 1;  ///< selects a realization
    std::uint32_t frame = 0; ///< number of the frame: noise differs from frame to frame
};

namespace detail {

/// N complex normal numbers of mean power 1, from two hashes each. Source: Box & Muller 1958; the angle is one within
/// +-45 degrees, whose cosine and sine are polynomials, and a random quarter turn.
/// @param index  of the numbers, distinct within a stream
template <int N>
INSONIFY_FN INSONIFY_INLINE void noise_lanes(std::uint32_t stream, const bit_lanes<N>& index, lanes<N>& x,
                                             lanes<N>& y) {
    using floats = lanes<N>;
    const bit_lanes<N> first = mix_lanes<N>(index ^ stream), second = mix_lanes<N>(first + 0x9E3779B9U);
    const floats uniform = (floats_of<N>(first >> 8) + floats(1.0F)) * floats(0x1p-24F); // in (0, 1]
    const floats radius = sqrt(max(floats(-0.69314718F) * logarithm_of_two<N>(uniform), floats(0.0F)));
    const floats angle = (floats_of<N>(second >> 8) * floats(0x1p-23F) - floats(1.0F)) * floats(pi / 4);
    const floats square = angle * angle;
    const floats sine = angle * polynomial<N>(square, -1.9515296e-4F, 8.3321609e-3F, -1.6666654e-1F, 1.0F);
    const floats cosine = polynomial<N>(square, 2.4433157e-5F, -1.3887316e-3F, 4.1666646e-2F, -0.5F, 1.0F);
    const floats turned = raw_floats<N>(raw_bits<N>(cosine) ^ ((second & 1U) << 31)); // random sign
    const lane_mask<N> swapped = floats(0.0F) < floats_of<N>(second & 2U);
    x = radius * select(swapped, sine, turned);
    y = radius * select(swapped, turned, sine);
}

} // namespace detail

/// Adds the noise of the receiver: complex white Gaussian noise, uniform in depth. Call it before `tgc`, which
/// amplifies it with depth.
/// @throws usage_error  for a level that is not finite
template <exec::policy Policy>
iq_lines add_electronic_noise(const Policy& policy, iq_lines lines, const electronic_noise_settings& settings = {}) {
    if (!is_finite(settings.level_db)) throw usage_error{"add_electronic_noise: `level_db` must be finite"};
    const float scale = amplitude_of_decibels(settings.level_db);
    if (scale == 0) return lines;
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    const auto stream = static_cast<std::uint32_t>(hash_bits(settings.seed, settings.frame));
    exec::for_each_block(policy, lines.values.size(), 4096, 5, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; i += width) {
            lanes<width> x, y;
            detail::noise_lanes<width>(stream, steps_of_bits<width>(static_cast<std::uint32_t>(i), 1), x, y);
            float real[width], imaginary[width];
            store(x * lanes<width>(scale), real);
            store(y * lanes<width>(scale), imaginary);
            for (std::size_t k = 0; k < width && i + k < end; ++k) lines.values[i + k] += vec2{real[k], imaginary[k]};
        }
    });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
