#ifndef INSONIFY_SIGNAL_FOURIER_HPP
#define INSONIFY_SIGNAL_FOURIER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <cstddef>
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

/// The same in memory.
struct alignas(complex_batch) complex_block {
    float x[complex_batch::width], y[complex_batch::width];

    complex_batch loaded() const { return {load<complex_batch::width>(x), load<complex_batch::width>(y)}; }
    void store_from(const complex_batch& from) {
        store(from.x, x);
        store(from.y, y);
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
    void forward(std::vector<complex_block>& values, std::vector<complex_block>& room) const {
        transform<false>(values, room);
    }
    void inverse(std::vector<complex_block>& values, std::vector<complex_block>& room) const {
        transform<true>(values, room);
    }

  private:
    template <bool Inverse>
    vec2 factor(std::size_t i) const {
        return Inverse ? vec2{factors_[i].x, -factors_[i].y} : factors_[i];
    }

    template <bool Inverse>
    void transform(std::vector<complex_block>& values, std::vector<complex_block>& room) const {
        std::size_t stride = 1;
        for (std::size_t left = length_; left > 1;) {
            const std::size_t radix = left % 4 == 0 ? 4 : left % 3 == 0 ? 3 : 2, parts = left / radix;
            for (std::size_t part = 0; part < parts; ++part) {
                const vec2 first = factor<Inverse>(part * stride),
                           second = factor<Inverse>(2 * part * stride % length_),
                           third = factor<Inverse>(3 * part * stride % length_);
                const complex_block* from = values.data() + part * stride;
                complex_block* to = room.data() + radix * part * stride;
                for (std::size_t i = 0; i < stride; ++i, ++from, ++to) {
                    const auto in = [&](std::size_t k) { return from[k * parts * stride].loaded(); };
                    if (radix == 4) {
                        const complex_batch even = in(0) + in(2), odd = in(0) - in(2), other = in(1) + in(3),
                                            turn = quarter_turned<Inverse>(in(1) - in(3));
                        to[0].store_from(even + other);
                        to[stride].store_from(batch_product(first, odd + turn));
                        to[2 * stride].store_from(batch_product(second, even - other));
                        to[3 * stride].store_from(batch_product(third, odd - turn));
                    } else if (radix == 3) {
                        const complex_batch others = in(1) + in(2), middle = in(0) - batch_product({0.5F, 0}, others),
                                            turn =
                                                batch_product({0.8660254F, 0}, quarter_turned<Inverse>(in(1) - in(2)));
                        to[0].store_from(in(0) + others);
                        to[stride].store_from(batch_product(first, middle + turn));
                        to[2 * stride].store_from(batch_product(second, middle - turn));
                    } else {
                        const complex_batch even = in(0), odd = in(1);
                        to[0].store_from(even + odd);
                        to[stride].store_from(batch_product(first, even - odd));
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

/// Calls visit(signal, sample, value) with the analytic signals of real ones: RF + i H(RF), where H is the Hilbert
/// transform, which shifts the phase of every frequency by -90 degrees, so that cos becomes sin. Signals are zero
/// beyond their ends.
/// @param all      signals, one after the other
/// @param samples  of each signal
template <class Policy, class Visit>
void for_each_analytic(const Policy& policy, const std::vector<float>& all, std::size_t samples, const Visit& visit) {
    if (samples == 0) return;
    const fourier transform{transform_length(samples + samples / 4 + 2)}; // with at least a quarter of zeros
    const std::size_t length = transform.size();
    const lanes<complex_batch::width> scale(1 / static_cast<float>(length));
    const auto analyse = [&](std::size_t first, std::size_t end) {
        std::vector<complex_block> values(length), room(length);
        // Two signals in each lane: one as the real and one as the imaginary part. Signal after signal, since samples
        // that are a power of two apart displace each other in a cache.
        const auto part = [&](std::size_t signal, std::size_t k) -> float& {
            const std::size_t lane = (signal - first) / 2;
            return (signal - first) % 2 == 0 ? values[k].x[lane] : values[k].y[lane];
        };
        for (std::size_t i = first; i < end; ++i)
            for (std::size_t k = 0; k < samples; ++k) part(i, k) = all[i * samples + k];
        transform.forward(values, room);
        values[0] = values[length / 2] = {}; // of DC and of the Nyquist frequency it is 0
        for (std::size_t m = 1; m < length / 2; ++m) {
            const complex_batch positive = values[m].loaded(), negative = values[length - m].loaded();
            values[m].store_from({scale * positive.y, -(scale * positive.x)});
            values[length - m].store_from({-(scale * negative.y), scale * negative.x});
        }
        transform.inverse(values, room);
        for (std::size_t i = first; i < end; ++i)
            for (std::size_t k = 0; k < samples; ++k) visit(i, k, vec2{all[i * samples + k], part(i, k)});
    };
    exec::for_each_block(any_policy<false>{policy}, all.size() / samples, 2 * complex_batch::width,
                         10 * static_cast<float>(length), analyse);
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
