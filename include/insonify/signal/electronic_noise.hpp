#ifndef INSONIFY_SIGNAL_ELECTRONIC_NOISE_HPP
#define INSONIFY_SIGNAL_ELECTRONIC_NOISE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <array>

namespace insonify::inline INSONIFY_ABI {

/// Level and seed of the electronic noise.
struct electronic_noise_settings {
    float level_db = -135;   ///< rms of its envelope, relative to the echo of a perfect mirror; `no_level_db`: none
    std::uint64_t seed = 1;  ///< selects a realization
    std::uint32_t frame = 0; ///< number of the frame: noise differs from frame to frame
};

/// Adds the noise of the receiver: complex white Gaussian noise, uniform in depth. Call it before `tgc`, which
/// amplifies it with depth.
/// @throws usage_error  for a level that is not finite
template <exec::policy Policy>
iq_lines add_electronic_noise(const Policy& policy, iq_lines lines, const electronic_noise_settings& settings = {}) {
    if (!is_finite(settings.level_db)) throw usage_error{"add_electronic_noise: `level_db` must be finite"};
    const float scale = amplitude_of_decibels(settings.level_db);
    if (scale == 0) return lines;
    static const auto numbers = [] { // complex, of mean power 1, from which hashes draw
        std::array<vec2, 4096> normal;
        float power = 0;
        for (std::size_t i = 0; i < normal.size(); ++i) {
            normal[i] = hash_normal(normal.size(), i);
            power += dot(normal[i], normal[i]) / static_cast<float>(normal.size());
        }
        for (vec2& number : normal) number /= std::sqrt(power);
        return normal;
    }();
    const auto stream = static_cast<std::uint32_t>(hash_bits(settings.seed, settings.frame));
    exec::for_each_block(policy, lines.values.size(), 4096, 3, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            lines.values[i] += scale * numbers[mix_bits(static_cast<std::uint32_t>(i) ^ stream) % numbers.size()];
    });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
