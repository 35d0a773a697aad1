#ifndef INSONIFY_SIGNAL_ENVELOPE_HPP
#define INSONIFY_SIGNAL_ENVELOPE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/probe/line_grid.hpp>
#include <algorithm>
#include <bit>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Fourier transforms of a power of two, x_n = sum over k of x_k exp(-2 pi j k n / N), in place.
///
/// The forward transform (decimation in frequency) leaves its results in bit-reversed order, from which the inverse
/// transform (decimation in time) starts. Source: Gentleman & Sande 1966, Cooley & Tukey 1965.
class fourier_transform {
  public:
    explicit fourier_transform(std::size_t size) : size_{size}, cosine_(size), sine_(size) {
        for (std::size_t half = 1; half < size_; half *= 2)
            for (std::size_t i = 0; i < half; ++i) {
                const double angle = 3.14159265358979323846 * static_cast<double>(i) / static_cast<double>(half);
                cosine_[half + i] = static_cast<float>(std::cos(angle));
                sine_[half + i] = static_cast<float>(std::sin(angle));
            }
    }

    std::size_t size() const { return size_; }

    /// Where `forward` leaves result n.
    std::size_t place(std::size_t n) const {
        std::size_t reversed = 0;
        for (std::size_t bit = 1, mirrored = size_ / 2; bit < size_; bit *= 2, mirrored /= 2)
            if ((n & bit) != 0) reversed |= mirrored;
        return reversed;
    }

    /// @tparam Width  floats in a SIMD register
    template <int Width>
    void forward(float* real, float* imaginary) const {
        for (std::size_t half = size_ / 2; half > 0; half /= 2)
            for (std::size_t begin = 0; begin < size_; begin += 2 * half)
                combine<Width, true>(real + begin, imaginary + begin, half);
    }
    /// The inverse, times the size.
    template <int Width>
    void back(float* real, float* imaginary) const {
        for (std::size_t half = 1; half < size_; half *= 2)
            for (std::size_t begin = 0; begin < size_; begin += 2 * half)
                combine<Width, false>(real + begin, imaginary + begin, half);
    }

  private:
    /// (a, b) becomes (a + b, (a - b) exp(-j angle)), or back (a + b exp(+j angle), a - b exp(+j angle)), for `half`
    /// values a and as many values b after them.
    template <int Width, bool Forward>
    void combine(float* real, float* imaginary, std::size_t half) const {
        using floats = lanes<Width>;
        if constexpr (Width > 1)
            if (half < Width) return combine<1, Forward>(real, imaginary, half);
        for (std::size_t i = 0; i < half; i += Width) {
            const floats c = load<Width>(cosine_.data() + half + i), s = load<Width>(sine_.data() + half + i);
            const floats ar = load<Width>(real + i), ai = load<Width>(imaginary + i);
            floats br = load<Width>(real + half + i), bi = load<Width>(imaginary + half + i);
            if constexpr (!Forward) {
                const floats turned = br * c - bi * s;
                bi = bi * c + br * s;
                br = turned;
            }
            const floats r = ar - br, j = ai - bi;
            store(ar + br, real + i);
            store(ai + bi, imaginary + i);
            store(Forward ? r * c + j * s : r, real + half + i);
            store(Forward ? j * c - r * s : j, imaginary + half + i);
        }
    }

    std::size_t size_ = 0;
    std::vector<float> cosine_; // of i / half of half a turn, at half + i
    std::vector<float> sine_;
};

/// Hilbert transform: shifts the phase of every frequency of a real signal by -90 degrees, so that cos becomes sin.
///
/// Of two signals at a time, one as the real and one as the imaginary part, with at least a quarter of zero padding. In
/// bit-reversed order positive frequencies are at even indices, negative frequencies at odd ones.
class hilbert_transform {
  public:
    explicit hilbert_transform(std::size_t samples) : fourier_{std::bit_ceil(samples + samples / 4 + 2)} {}

    /// Size of the buffers of `apply`: the signal, padded with zeros.
    std::size_t size() const { return fourier_.size(); }

    /// In place; overwrites the padding.
    /// @tparam Width  floats in a SIMD register
    template <int Width>
    void apply(float* one, float* other) const {
        fourier_.forward<Width>(one, other);
        const float scale = 1 / static_cast<float>(size());
        one[0] = one[1] = other[0] = other[1] = 0; // the Hilbert transform of DC and of the Nyquist frequency is 0
        for (std::size_t i = 2; i < size(); i += 2) {
            const float real = one[i], imaginary = other[i];
            one[i] = scale * imaginary;
            other[i] = -scale * real;
            const float negative_real = one[i + 1], negative_imaginary = other[i + 1];
            one[i + 1] = -scale * negative_imaginary;
            other[i + 1] = scale * negative_real;
        }
        fourier_.back<Width>(one, other);
    }

  private:
    fourier_transform fourier_;
};

/// Square roots, in place.
template <int Width>
void square_roots(float* values, std::size_t count) {
    const std::size_t whole = count - count % Width;
    for (std::size_t i = 0; i < whole; i += Width) store(sqrt(load<Width>(values + i)), values + i);
    for (std::size_t i = whole; i < count; ++i) values[i] = std::sqrt(values[i]);
}

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

/// Envelope of baseband signals: |IQ| = sqrt(I^2 + Q^2).
/// @param recycled  lines whose memory is reused
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const iq_lines& iq, scan_lines recycled = {}) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    recycled.reshape(iq.count, iq.samples, iq.depth);
    exec::for_each_block(policy, iq.values.size(), 16384, 0.6F, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            recycled.values[i] = iq.values[i].x * iq.values[i].x + iq.values[i].y * iq.values[i].y;
        detail::square_roots<width>(recycled.values.data() + begin, end - begin);
    });
    return recycled;
}

/// Envelope of RF signals: sqrt(RF^2 + H(RF)^2), where H is the Hilbert transform.
///
/// Equals |IQ| of the same echoes within 1e-3 of the maximum for fractional bandwidths below 0.8, except near truncated
/// signals: lines are zero beyond their ends.
/// @param rf  at least four samples per cycle
/// @throws usage_error  where the number of values is not lines times samples
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const scan_lines& rf) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    if (rf.values.size() != static_cast<std::size_t>(rf.count) * rf.samples)
        throw usage_error{"envelope: " + std::to_string(rf.count) + " lines of " + std::to_string(rf.samples) +
                          " samples need as many values, not " + std::to_string(rf.values.size())};
    const detail::hilbert_transform transform{rf.samples};
    scan_lines lines{rf.count, rf.samples, rf.depth};
    const auto envelope_of_pair = [&](std::size_t first, std::size_t end) {
        const std::size_t n = rf.samples, last = end - 1; // an odd last line is paired with itself
        std::vector<float> shifted(2 * transform.size());
        float *const one = shifted.data(), *const other = one + transform.size();
        std::copy_n(rf.values.data() + first * n, n, one);
        std::copy_n(rf.values.data() + last * n, n, other);
        transform.template apply<width>(one, other);
        for (const std::size_t line : {first, last}) {
            const float* const from = rf.values.data() + line * n;
            const float* const quarter = line == first ? one : other;
            float* const to = lines.values.data() + line * n;
            for (std::size_t i = 0; i < n; ++i) to[i] = from[i] * from[i] + quarter[i] * quarter[i];
            detail::square_roots<width>(to, n);
        }
    };
    exec::for_each_block(policy, rf.count, 2, 20 * static_cast<float>(rf.samples), envelope_of_pair);
    return lines;
}

/// Modulates baseband signals to the RF signal that a probe receives: RF(z) = Re(IQ(z) exp(+j 4 pi f0 z / c0)).
///
/// Along displayed depth the carrier has 2 f0 / c0 cycles per metre. The envelope is unchanged.
/// @param frequency  f0 of the carrier, hertz
/// @throws usage_error  for fewer than four samples per cycle, lines without samples, or a frequency out of range
template <exec::policy Policy>
scan_lines to_rf(const Policy& policy, const iq_lines& iq, float frequency) {
    if (iq.samples == 0 || iq.values.size() != static_cast<std::size_t>(iq.count) * iq.samples ||
        !is_finite(iq.depth) || !(iq.depth > 0))
        throw usage_error{"to_rf: the lines must have a depth above 0 and a value for every sample"};
    if (!is_finite(frequency) || !(frequency > 0))
        throw usage_error{"to_rf: the frequency must be finite and above 0, such as 5_MHz"};
    const double cycles_per_sample = 2.0 * frequency / display_speed * iq.depth / iq.samples;
    if (cycles_per_sample > 0.25001) {
        const float needed = min(std::ceil(static_cast<float>(4 * cycles_per_sample * iq.samples)), 1e9F);
        throw usage_error{"to_rf: RF needs four samples per cycle; trace and convolve with at least " +
                          std::to_string(static_cast<std::uint32_t>(needed)) + " samples per line"};
    }

    std::vector<vec2> carrier(iq.samples); // cosine and sine
    for (std::uint32_t k = 0; k < iq.samples; ++k) {
        const double cycles = (k + 0.5) * cycles_per_sample;
        const auto phase = static_cast<float>(cycles - std::floor(cycles)) * 2 * pi;
        carrier[k] = {std::cos(phase), std::sin(phase)};
    }
    scan_lines rf{iq.count, iq.samples, iq.depth};
    const auto modulate = [&](std::size_t line, std::size_t) {
        const vec2* const from = iq.values.data() + line * iq.samples;
        float* const to = rf.values.data() + line * iq.samples;
        for (std::uint32_t k = 0; k < iq.samples; ++k) to[k] = from[k].x * carrier[k].x - from[k].y * carrier[k].y;
    };
    exec::for_each_block(policy, iq.count, 1, 0.5F * static_cast<float>(iq.samples), modulate);
    return rf;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
