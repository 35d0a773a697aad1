#ifndef INSONIFY_SIGNAL_GAIN_HPP
#define INSONIFY_SIGNAL_GAIN_HPP

#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>
#include <cfloat>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// How amplitudes become grey. The reference is fixed, never the frame's own maximum: a clip must not flicker.
struct log_compress_settings {
    float dynamic_range_db = 60; ///< from black to white
    float reference_db = -25;    ///< the level that is white; 0 dB is amplitude 1, the echo of a perfect mirror
    float gain_db = 0;           ///< added to every level
    float reject_db = -FLT_MAX;  ///< levels below this, after the gain, are black; by default none is rejected

    /// Grey of an amplitude A, 0 to 1: 1 + (20 log10(A) + gain - reference) / dynamic range. No amplitude (0, negative
    /// or NaN) is black.
    INSONIFY_FN float grey(float amplitude) const {
        if (!(amplitude > 0)) return 0;
        const float level = 20 * std::log10(amplitude) + gain_db;
        return level < reject_db ? 0 : clamped(1 + (level - reference_db) / dynamic_range_db, 0, 1);
    }

    /// @throws usage_error  naming the setting that makes no sense
    void check() const {
        if (!is_finite(dynamic_range_db) || !(dynamic_range_db > 0))
            throw usage_error{"log_compress: `dynamic_range_db` must be a finite number above 0; 60 is usual"};
        if (!is_finite(reference_db) || !is_finite(gain_db) || !is_finite(reject_db))
            throw usage_error{"log_compress: `reference_db`, `gain_db` and `reject_db` must be finite numbers"};
    }
};

/// Turns amplitudes into grey, 0 black to 1 white, in place: pass std::move(lines) to keep the buffer.
/// @throws usage_error  where a setting makes no sense
template <exec::policy Policy>
scan_lines log_compress(const Policy& policy, scan_lines lines, const log_compress_settings& settings = {}) {
    settings.check();
    exec::for_each_block(policy, lines.values.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) lines.values[i] = settings.grey(lines.values[i]);
    });
    return lines;
}

/// Time-gain compensation: what a scanner adds, depth by depth, to make up for the attenuation it expects.
struct tgc_settings {
    float attenuation = 50; ///< dB/m at 1 MHz, one way: what is expected (50 is 0.5 dB/(cm MHz), as on a scanner)
    float most_db = 60;     ///< the gain rises no further than this
};

/// Raises each sample by 2 * attenuation * frequency * depth, in dB; in place: pass std::move(lines).
/// @param frequency  hertz, of the probe
/// @throws usage_error  where a setting is not a finite number, 0 or more
template <exec::policy Policy>
scan_lines tgc(const Policy& policy, scan_lines lines, float frequency, const tgc_settings& settings = {}) {
    if (!(settings.attenuation >= 0 && settings.most_db >= 0 && frequency >= 0) || !is_finite(frequency) ||
        !is_finite(settings.attenuation) || !is_finite(settings.most_db))
        throw usage_error{"tgc: `attenuation`, `most_db` and the frequency must be finite numbers, 0 or more"};
    std::vector<float> gain(lines.samples);
    const float spacing = lines.depth / static_cast<float>(lines.samples);
    for (std::uint32_t k = 0; k < lines.samples; ++k) {
        const float depth = (static_cast<float>(k) + 0.5F) * spacing;
        gain[k] = std::pow(10.0F, lesser(2 * settings.attenuation * frequency * 1e-6F * depth, settings.most_db) / 20);
    }
    for_each_index(policy, lines.count, [&](std::size_t line) {
        float* values = lines.values.data() + line * lines.samples;
        for (std::uint32_t k = 0; k < lines.samples; ++k) values[k] *= gain[k];
    });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
