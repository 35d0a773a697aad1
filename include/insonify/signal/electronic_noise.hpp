#ifndef INSONIFY_SIGNAL_ELECTRONIC_NOISE_HPP
#define INSONIFY_SIGNAL_ELECTRONIC_NOISE_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>

namespace insonify::inline INSONIFY_ABI {

/// How loud the amplifier is.
struct electronic_noise_settings {
    float level_db = -130;   ///< rms of its envelope against the echo of a perfect mirror
    std::uint64_t seed = 1;  ///< another one, another noise of the same kind
    std::uint32_t frame = 0; ///< each frame of a clip has its own
};

/// Adds what an amplifier adds: complex white Gaussian noise, the same at all depths. Comes before `tgc`, which then
/// raises it deep down.
/// @throws usage_error  where the level is not finite
template <exec::policy Policy>
iq_lines add_electronic_noise(const Policy& policy, iq_lines lines, const electronic_noise_settings& settings = {}) {
    if (!is_finite(settings.level_db)) throw usage_error{"add_electronic_noise: `level_db` must be a finite number"};
    const float scale = std::pow(10.0F, settings.level_db / 20) * std::sqrt(0.5F);
    const std::uint64_t stream = hash_bits(settings.seed, settings.frame);
    exec::for_each_block(policy, lines.values.size(), 1024, 30, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) lines.values[i] += scale * hash_normal(stream, i);
    });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
