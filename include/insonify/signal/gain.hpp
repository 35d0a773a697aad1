#ifndef INSONIFY_SIGNAL_GAIN_HPP
#define INSONIFY_SIGNAL_GAIN_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/execution/simd_math.hpp>
#include <insonify/probe/line_grid.hpp>
#include <array>
#include <cfloat>
#include <concepts>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// How amplitudes become grey. The reference is fixed, never the frame's own maximum: a clip must not flicker.
struct log_compress_settings {
    float dynamic_range_db = 60; ///< from black to white
    float reference_db = -25;    ///< the level that is white; 0 dB is amplitude 1, the echo of a perfect mirror
    float gain_db = 0;           ///< added to every level
    float reject_db = -FLT_MAX;  ///< levels below this, after the gain, are black; by default none is rejected

    /// Greys of N amplitudes A, 0 to 1: 1 + (20 log10(A) + gain - reference) / dynamic range, within 2e-6 dB a dB. No
    /// amplitude (0, negative or NaN) is black.
    template <int N>
    INSONIFY_FN INSONIFY_INLINE lanes<N> grey(const lanes<N>& amplitude) const {
        using floats = lanes<N>;
        const floats decibels = floats(6.0205999F) * logarithm_of_two<N>(amplitude) + floats(gain_db); // 20 log10(2)
        const floats grey = floats(1.0F) + (decibels - floats(reference_db)) * floats(1 / dynamic_range_db);
        return select(floats(0.0F) < amplitude && floats(reject_db) <= decibels,
                      lesser(greater(grey, floats(0.0F)), floats(1.0F)), floats(0.0F));
    }
    /// The grey of one amplitude.
    INSONIFY_LAZY INSONIFY_FN float grey(float amplitude) const {
        float one = 0;
        store(grey<1>(lanes<1>(amplitude)), &one);
        return one;
    }

    /// @throws usage_error  naming the setting that makes no sense
    INSONIFY_LAZY void check() const {
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
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    exec::for_each_block(policy, lines.values.size(), 16384, 0.5F, [&](std::size_t begin, std::size_t end) {
        const log_compress_settings own = settings; // out of reach of the stores, so that it stays in registers
        float* values = lines.values.data();
        std::size_t i = begin;
        for (; i + width <= end; i += width) store(own.grey<width>(load<width>(values + i)), values + i);
        for (; i < end; ++i) values[i] = own.grey(values[i]);
    });
    return lines;
}

/// A point of a gain curve.
struct tgc_point {
    float depth = 0;   ///< metres
    float gain_db = 0; ///< there
};

/// Time-gain compensation: what a scanner adds, depth by depth, to make up for the attenuation it expects.
///
/// The gain is the automatic one or, where there is a curve, that of the curve; the sliders are added to either.
struct tgc_settings {
    float attenuation = 50; ///< dB/m at 1 MHz, one way: what is expected (50 is 0.5 dB/(cm MHz), as on a scanner)
    float most_db = 60;     ///< the automatic gain rises no further than this
    std::array<float, 8> sliders{}; ///< dB at eight depths, the first at 0 and the last at the end; linear between
    std::vector<tgc_point> curve{}; ///< by rising depth; linear between its points, level before and after them

    /// @param depth      metres
    /// @param end        of the lines, metres
    /// @param frequency  f0 of the probe, hertz: the automatic gain is 2 attenuation f0 depth
    INSONIFY_LAZY float gain_db(float depth, float end, float frequency) const {
        const float place = clamped(depth / end, 0, 1) * 7;
        const std::size_t slider = place < 7 ? static_cast<std::size_t>(place) : 6;
        const float share_of_next = place - static_cast<float>(slider);
        const float by_hand = sliders[slider] + share_of_next * (sliders[slider + 1] - sliders[slider]);
        if (curve.empty()) return by_hand + lesser(2 * attenuation * frequency * 1e-6F * depth, most_db);

        const auto after =
            std::find_if(curve.begin(), curve.end(), [=](const tgc_point& p) { return p.depth > depth; });
        if (after == curve.begin()) return by_hand + curve.front().gain_db;
        if (after == curve.end()) return by_hand + curve.back().gain_db;
        const tgc_point& before = *(after - 1);
        const float share = (depth - before.depth) / (after->depth - before.depth);
        return by_hand + before.gain_db + share * (after->gain_db - before.gain_db);
    }

    /// @throws usage_error  naming the setting that makes no sense
    INSONIFY_LAZY void check() const {
        if (!is_finite(attenuation) || !(attenuation >= 0) || !is_finite(most_db) || !(most_db >= 0))
            throw usage_error{"tgc: `attenuation` and `most_db` must be finite numbers, 0 or more"};
        for (const float slider : sliders)
            if (!is_finite(slider)) throw usage_error{"tgc: `sliders` must be finite numbers of dB"};
        for (std::size_t i = 0; i < curve.size(); ++i)
            if (!is_finite(curve[i].depth) || !is_finite(curve[i].gain_db) ||
                (i > 0 && !(curve[i].depth > curve[i - 1].depth)))
                throw usage_error{"tgc: the points of `curve` must be finite, each deeper than the one before"};
    }
};

/// Raises each sample by the gain of its depth; in place: pass std::move(lines).
/// @tparam Value     float for amplitudes, vec2 for IQ
/// @param frequency  hertz, of the probe
/// @throws usage_error  where the frequency or a setting makes no sense
template <exec::policy Policy, class Value>
    requires std::same_as<Value, float> || std::same_as<Value, vec2> line_grid<Value>
    tgc(const Policy& policy, line_grid<Value> lines, float frequency, const tgc_settings& settings = {}) {
        settings.check();
        if (!is_finite(frequency) || !(frequency >= 0))
            throw usage_error{"tgc: the frequency must be a finite number of hertz, 0 or more"};
        constexpr std::size_t together = 512; // samples, on all lines
        const float spacing = lines.depth / static_cast<float>(lines.samples);
        exec::for_each_block(policy, lines.samples, together, 0.5F * static_cast<float>(lines.count),
                             [&](std::size_t begin, std::size_t end) {
                                 float gain[together];
                                 for (std::size_t k = begin; k < end; ++k) {
                                     const float depth = (static_cast<float>(k) + 0.5F) * spacing;
                                     gain[k - begin] =
                                         std::pow(10.0F, settings.gain_db(depth, lines.depth, frequency) / 20);
                                 }
                                 for (std::size_t line = 0; line < lines.count; ++line) {
                                     Value* values = lines.values.data() + line * lines.samples + begin;
                                     for (std::size_t k = 0; k < end - begin; ++k) values[k] *= gain[k];
                                 }
                             });
        return lines;
    }

} // namespace insonify::inline INSONIFY_ABI
#endif
