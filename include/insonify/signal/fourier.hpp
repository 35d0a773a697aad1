#ifndef INSONIFY_SIGNAL_FOURIER_HPP
#define INSONIFY_SIGNAL_FOURIER_HPP

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

/// Cosine (x) and sine (y) of 2 pi times each lane, within 1e-7 for numbers of turns within +-0.5.
template <int N>
struct turned_lanes {
    lanes<N> x, y;

    explicit turned_lanes(const lanes<N>& turns) {
        const lanes<N> quarter(0.25F), size = abs(turns);
        const lanes<N> y_of_positive = sine(quarter - abs(size - quarter));
        x = sine(quarter - size);
        y = select(turns < lanes<N>(0.0F), -y_of_positive, y_of_positive);
    }

  private:
    static lanes<N> sine(const lanes<N>& turns) { // of turns within +-0.25, by its series
        const lanes<N> a = lanes<N>(2 * pi) * turns;
        return a *
               polynomial<N>(a * a, -2.5052108e-8F, 2.7557319e-6F, -1.9841270e-4F, 8.3333333e-3F, -1.6666667e-1F, 1.0F);
    }
};

/// Discrete Fourier transforms of one length, of several sequences at once: sums over k of x[k] exp(-+ 2 pi i k m /
/// n), not scaled. Source: Stockham's form of the fast transform, in Van Loan, Computational Frameworks for the Fast
/// Fourier Transform, 1992, section 1.7.
class fourier {
  public:
    /// @param length  2^k 3^m
    explicit fourier(std::size_t length) : length_{length}, factors_(length) {
        for (std::size_t i = 0; i < length; ++i)
            factors_[i] = turned(-static_cast<double>(i) / static_cast<double>(length));
    }

    std::size_t size() const { return length_; }

    /// In place, of a sequence in each lane. @param room  as many values, which are overwritten
    /// @{
    void forward(std::vector<complex_batch>& values, std::vector<complex_batch>& room) const {
        transform<false>(values, room);
    }
    void inverse(std::vector<complex_batch>& values, std::vector<complex_batch>& room) const {
        transform<true>(values, room);
    }
    /// @}

  private:
    template <bool Inverse>
    vec2 factor(std::size_t i) const {
        return Inverse ? vec2{factors_[i].x, -factors_[i].y} : factors_[i];
    }

    template <bool Inverse>
    void transform(std::vector<complex_batch>& values, std::vector<complex_batch>& room) const {
        std::size_t stride = 1;
        for (std::size_t left = length_; left > 1;) {
            const std::size_t radix = left % 4 == 0 ? 4 : left % 3 == 0 ? 3 : 2, parts = left / radix;
            for (std::size_t part = 0; part < parts; ++part) {
                const vec2 first = factor<Inverse>(part * stride),
                           second = factor<Inverse>(2 * part * stride % length_),
                           third = factor<Inverse>(3 * part * stride % length_);
                const complex_batch* from = values.data() + part * stride;
                complex_batch* to = room.data() + radix * part * stride;
                for (std::size_t i = 0; i < stride; ++i, ++from, ++to) {
                    const auto in = [&](std::size_t k) { return from[k * parts * stride]; };
                    if (radix == 4) {
                        const complex_batch even = in(0) + in(2), odd = in(0) - in(2), other = in(1) + in(3),
                                            turn = quarter_turned<Inverse>(in(1) - in(3));
                        to[0] = even + other;
                        to[stride] = batch_product(first, odd + turn);
                        to[2 * stride] = batch_product(second, even - other);
                        to[3 * stride] = batch_product(third, odd - turn);
                    } else if (radix == 3) {
                        const complex_batch others = in(1) + in(2), middle = in(0) - batch_product({0.5F, 0}, others),
                                            turn =
                                                batch_product({0.8660254F, 0}, quarter_turned<Inverse>(in(1) - in(2)));
                        to[0] = in(0) + others;
                        to[stride] = batch_product(first, middle + turn);
                        to[2 * stride] = batch_product(second, middle - turn);
                    } else {
                        to[0] = in(0) + in(1);
                        to[stride] = batch_product(first, in(0) - in(1));
                    }
                }
            }
            values.swap(room);
            left = parts;
            stride *= radix;
        }
    }
    template <bool Inverse>
    static complex_batch quarter_turned(const complex_batch& a) { // by -i, or by i
        return Inverse ? complex_batch{-a.y, a.x} : complex_batch{a.y, -a.x};
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

/// The shortest even length of transforms that is not below a number.
constexpr std::size_t transform_length(std::size_t values) {
    std::size_t shortest = 0;
    for (const std::size_t odd : {1U, 3U, 9U}) {
        std::size_t length = 2 * odd;
        while (length < values) length *= 2;
        if (shortest == 0 || length < shortest) shortest = length;
    }
    return shortest;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
