#ifndef INSONIFY_SIGNAL_GAIN_HPP
#define INSONIFY_SIGNAL_GAIN_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/laws.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/probe/line_grid.hpp>
#include <algorithm>
#include <array>
#include <concepts>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Logarithmic compression of amplitudes to brightness. The reference is fixed, independent of the frame, so that clips
/// do not flicker.
struct log_compress_settings {
    float dynamic_range_db = 60;   ///< range of levels from black to white
    float reference_db = -25;      ///< level of white; 0 dB is amplitude 1, the echo of a perfect mirror
    float gain_db = 0;             ///< added to every level
    float reject_db = no_level_db; ///< levels below this, after the gain, are black; by default none

    /// Brightness of N amplitudes A, 0 to 1: 1 + (20 log10(A) + gain - reference) / dynamic range, within 2e-6 dB per
    /// dB. Amplitudes that are 0, negative or NaN are black.
    template <int N>
    INSONIFY_FN INSONIFY_INLINE lanes<N> grey(const lanes<N>& amplitude) const {
        using floats = lanes<N>;
        const floats decibels = floats(6.0205999F) * logarithm_of_two<N>(amplitude) + floats(gain_db); // 20 log10(2)
        const floats grey = floats(1.0F) + (decibels - floats(reference_db)) * floats(1 / dynamic_range_db);
        return select(floats(0.0F) < amplitude && floats(reject_db) <= decibels,
                      min(max(grey, floats(0.0F)), floats(1.0F)), floats(0.0F));
    }
    /// Brightness of one amplitude.
    INSONIFY_FN float grey(float amplitude) const {
        float one = 0;
        store(grey<1>(lanes<1>(amplitude)), &one);
        return one;
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        if (!is_finite(dynamic_range_db) || !(dynamic_range_db > 0))
            throw usage_error{"log_compress: `dynamic_range_db` must be finite and above 0, such as 60"};
        if (!is_finite(reference_db) || !is_finite(gain_db) || !is_finite(reject_db))
            throw usage_error{"log_compress: `reference_db`, `gain_db` and `reject_db` must be finite"};
    }
};

/// Compresses amplitudes to brightness, 0 black to 1 white. In place: pass std::move(lines) to reuse the buffer.
/// @throws usage_error  for a setting out of range
template <exec::policy Policy>
scan_lines log_compress(const Policy& policy, scan_lines lines, const log_compress_settings& settings = {}) {
    settings.check();
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    exec::for_each_block(policy, lines.values.size(), 16384, 0.5F, [&](std::size_t begin, std::size_t end) {
        const log_compress_settings own = settings; // a local copy, which stores cannot alias, stays in registers
        float* const values = lines.values.data();
        detail::in_registers<width>(
            begin, end, [&](std::size_t i, auto n) { store(own.grey<n>(load<n>(values + i)), values + i); });
    });
    return lines;
}

/// A point of a gain curve.
struct tgc_point {
    float depth = 0;   ///< metres
    float gain_db = 0; ///< gain at this depth

    friend bool operator==(const tgc_point&, const tgc_point&) = default;
};

/// Time-gain compensation (TGC): depth-dependent gain that compensates for an assumed attenuation.
///
/// The gain is automatic or, where `curve` has points, that of the curve; the sliders are added to either.
struct tgc_settings {
    float attenuation = 50; ///< assumed attenuation, dB/m at 1 MHz, one way (50 is 0.5 dB/(cm MHz), as on a scanner)
    float max_db = 60;      ///< limit of the automatic gain
    std::array<float, 8> sliders{}; ///< dB at eight depths from 0 to the end of the lines; linear between
    std::vector<tgc_point> curve{}; ///< points in order of depth; linear between, constant before and after
    float bandwidth = 0; ///< fractional, of a pulse whose losses are restored (`attenuated`); 0: a single frequency

    /// @param depth      metres
    /// @param end        depth of the lines, metres
    /// @param frequency  f0 of the probe, hertz; the automatic gain is 2 attenuation f0 depth, or with a `bandwidth`
    ///                   what `attenuated` makes of that
    float gain_db(float depth, float end, float frequency) const {
        const detail::table_place at{depth / end * 7, sliders.size()};
        const float manual = sliders[at.above] + at.part * (sliders[at.below] - sliders[at.above]);
        if (curve.empty()) {
            const float lost = 2 * attenuation * frequency * 1e-6F * depth;
            return manual +
                   min(bandwidth > 0 && lost > 0 ? attenuated(lost, frequency, bandwidth).loss_db : lost, max_db);
        }
        const auto after =
            std::find_if(curve.begin(), curve.end(), [=](const tgc_point& p) { return p.depth > depth; });
        if (after == curve.begin()) return manual + curve.front().gain_db;
        if (after == curve.end()) return manual + curve.back().gain_db;
        const tgc_point& before = *(after - 1);
        const float between = (depth - before.depth) / (after->depth - before.depth);
        return manual + before.gain_db + between * (after->gain_db - before.gain_db);
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        if (!is_finite(attenuation) || !(attenuation >= 0) || !is_finite(max_db) || !(max_db >= 0))
            throw usage_error{"tgc: `attenuation` and `max_db` must be finite and not negative"};
        if (!is_finite(bandwidth) || !(bandwidth >= 0))
            throw usage_error{
                "tgc: `bandwidth` must be finite and not negative, such as 0.6, or 0 for a single frequency"};
        for (const float slider : sliders)
            if (!is_finite(slider)) throw usage_error{"tgc: `sliders` must be finite"};
        for (std::size_t i = 0; i < curve.size(); ++i)
            if (!is_finite(curve[i].depth) || !is_finite(curve[i].gain_db) ||
                (i > 0 && !(curve[i].depth > curve[i - 1].depth)))
                throw usage_error{"tgc: the points of `curve` must be finite and in order of increasing depth"};
    }

    friend bool operator==(const tgc_settings&, const tgc_settings&) = default;
};

/// Replaces the time gain of lines that have had one: for stored lines, of which only the amplitudes are left.
/// @param before  the settings with which `tgc` was applied
/// @throws usage_error  as `tgc`
template <exec::policy Policy, class Value>
line_grid<Value> regain(const Policy& policy, line_grid<Value> lines, float frequency, const tgc_settings& before,
                        const tgc_settings& settings) {
    static_assert(std::same_as<Value, float> || std::same_as<Value, vec2>, "tgc: the lines must be amplitudes or IQ");
    settings.check();
    if (!is_finite(frequency) || !(frequency >= 0))
        throw usage_error{"tgc: the frequency must be finite and not negative"};
    if (before == settings) return lines;
    constexpr std::size_t block = 512; // samples, of all lines
    const float spacing = lines.depth / static_cast<float>(lines.samples);
    const auto amplify = [&](std::size_t begin, std::size_t end) {
        float gain[block];
        for (std::size_t k = begin; k < end; ++k) {
            const float depth = (static_cast<float>(k) + 0.5F) * spacing;
            gain[k - begin] = amplitude_of_decibels(settings.gain_db(depth, lines.depth, frequency) -
                                                    before.gain_db(depth, lines.depth, frequency));
        }
        for (std::size_t line = 0; line < lines.count; ++line) {
            Value* values = lines.values.data() + line * lines.samples + begin;
            for (std::size_t k = 0; k < end - begin; ++k) values[k] *= gain[k];
        }
    };
    exec::for_each_block(policy, lines.samples, block, 0.5F * static_cast<float>(lines.count), amplify);
    return lines;
}

/// Multiplies each sample by the gain at its depth. In place: pass std::move(lines).
/// @tparam Value     float for amplitudes, vec2 for IQ
/// @param frequency  of the probe, hertz
/// @throws usage_error  for a frequency or setting out of range
template <exec::policy Policy, class Value>
line_grid<Value> tgc(const Policy& policy, line_grid<Value> lines, float frequency, const tgc_settings& settings = {}) {
    return regain(policy, std::move(lines), frequency, {.attenuation = 0}, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
