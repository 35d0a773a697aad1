#ifndef INSONIFY_CHANNELS_FOURIER_HPP
#define INSONIFY_CHANNELS_FOURIER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/execution/simd.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Complex numbers, one in each lane.
struct complex_batch {
    static constexpr std::size_t width = max_simd_width;
    lanes<width> x{0.0F}, y{0.0F};

    friend complex_batch operator+(const complex_batch& a, const complex_batch& b) { return {a.x + b.x, a.y + b.y}; }
    friend complex_batch operator-(const complex_batch& a, const complex_batch& b) { return {a.x - b.x, a.y - b.y}; }
};
inline complex_batch batch_product(vec2 a, const complex_batch& b) {
    const lanes<complex_batch::width> x(a.x), y(a.y);
    return {x * b.x - y * b.y, x * b.y + y * b.x};
}

/// exp(2 pi i turns)
INSONIFY_FN inline vec2 turned(double turns) {
    const auto part = static_cast<float>(turns - std::floor(turns));
    return {std::cos(2 * pi * part), std::sin(2 * pi * part)};
}

/// Discrete Fourier transforms of one length, of several sequences at once: sums over k of x[k] exp(-+ 2 pi i k m /
/// n), not scaled. Source: Cooley & Tukey, An algorithm for the machine calculation of complex Fourier series, 1965.
class fourier {
  public:
    /// @param length  2^k or 3 * 2^k
    explicit fourier(std::size_t length) : length_{length}, factors_(length) {
        for (std::size_t i = 0; i < length; ++i)
            factors_[i] = turned(-static_cast<double>(i) / static_cast<double>(length));
    }

    std::size_t size() const { return length_; }

    /// In place; a sequence in each lane.
    void forward(complex_batch* values) const { transform<false>(values); }
    void inverse(complex_batch* values) const { transform<true>(values); }

  private:
    template <bool Inverse>
    vec2 factor(std::size_t i) const {
        return Inverse ? vec2{factors_[i].x, -factors_[i].y} : factors_[i];
    }

    template <bool Inverse>
    void transform(complex_batch* values) const {
        if (length_ % 3 != 0) return transform_power<Inverse>(values, length_);
        // Every third value, from the first three on, by itself; then together.
        const std::size_t third = length_ / 3;
        std::vector<complex_batch> parts(length_);
        for (std::size_t i = 0; i < length_; ++i) parts[i % 3 * third + i / 3] = values[i];
        for (std::size_t part = 0; part < 3; ++part) transform_power<Inverse>(parts.data() + part * third, third);
        for (std::size_t k = 0; k < length_; ++k) {
            const std::size_t m = k % third;
            values[k] = parts[m] + batch_product(factor<Inverse>(k), parts[third + m]) +
                        batch_product(factor<Inverse>(2 * k % length_), parts[2 * third + m]);
        }
    }

    template <bool Inverse>
    void transform_power(complex_batch* values, std::size_t length) const {
        for (std::size_t i = 1, reversed = 0; i < length; ++i) {
            std::size_t bit = length / 2;
            for (; (reversed & bit) != 0; bit /= 2) reversed ^= bit;
            reversed ^= bit;
            if (i < reversed) std::swap(values[i], values[reversed]);
        }
        for (std::size_t half = 1; half < length; half *= 2) {
            const std::size_t step = length_ / (2 * half);
            for (std::size_t begin = 0; begin < length; begin += 2 * half)
                for (std::size_t k = 0; k < half; ++k) {
                    const complex_batch low = values[begin + k],
                                        high = batch_product(factor<Inverse>(k * step), values[begin + half + k]);
                    values[begin + k] = low + high;
                    values[begin + half + k] = low - high;
                }
        }
    }

    std::size_t length_;
    std::vector<vec2> factors_; // exp(-2 pi i k / n)
};

/// Complex numbers of all lanes in memory: real parts, then imaginary parts.
struct complex_block {
    float x[complex_batch::width], y[complex_batch::width];

    complex_batch loaded() const { return {load<complex_batch::width>(x), load<complex_batch::width>(y)}; }
    void store_from(const complex_batch& from) {
        store(from.x, x);
        store(from.y, y);
    }
};

/// The shortest power of two that is not below a number.
constexpr std::size_t transform_length(std::size_t values) {
    std::size_t length = 1;
    while (length < values) length *= 2;
    return length;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
