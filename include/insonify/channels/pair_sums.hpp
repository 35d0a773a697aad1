#ifndef INSONIFY_CHANNELS_PAIR_SUMS_HPP
#define INSONIFY_CHANNELS_PAIR_SUMS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/large_array.hpp>
#include <insonify/channels/element_field.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>

/// Sums over reflectors of what goes from one source by a reflector to one receiver.
namespace insonify::inline INSONIFY_ABI::detail {

/// One sample of a sum, or one wave: a complex value at each frequency.
inline constexpr std::size_t floats_per_wave = 2 * spectral_value::nodes;

/// What arrives at reflectors, from one source or at one receiver: a row of a `wave_table`.
struct wave_row {
    const float* time;    ///< s
    const float* facing;  ///< share of the obliquity: 1/2 of a point, cos / 2 of a surface
    const float* wave;    ///< with the phase of the carrier by the travel time: x, y at each frequency
    const float* swapped; ///< the same: y, x

    vec2 at(std::size_t i, std::size_t node) const {
        const float* const own = wave + floats_per_wave * i + 2 * node;
        return {own[0], own[1]};
    }
};

/// Of many sources or receivers, for a block of reflectors.
class wave_table {
  public:
    static constexpr std::size_t block =
        1024; // reflectors; the rows of two tiles of elements fit into the second-level cache

    static constexpr std::size_t together = max_simd_width; // reflectors
    static_assert(block % together == 0);

    explicit wave_table(std::size_t rows) : values_(rows * row_size) {
        std::fill(values_.begin(), values_.end(), 0.0F);
    }

    wave_row operator[](std::size_t row) const {
        const float* const begin = values_.data() + row * row_size;
        return {begin, begin + block, begin + 2 * block, begin + (2 + floats_per_wave) * block};
    }
    void set(std::size_t row, std::size_t i, float time, float facing, const spectral_value& wave) {
        float* const begin = values_.data() + row * row_size;
        begin[i] = time;
        begin[block + i] = facing;
        float *const to = begin + 2 * block + floats_per_wave * i, *const swapped = to + floats_per_wave * block;
        for (std::size_t k = 0; k < spectral_value::nodes; ++k) {
            to[2 * k] = swapped[2 * k + 1] = wave.at[k].x;
            to[2 * k + 1] = swapped[2 * k] = wave.at[k].y;
        }
    }

  private:
    static constexpr std::size_t row_size = (2 + 2 * floats_per_wave) * block;
    large_array<float> values_; // aligned to cache lines
};

/// One source, ready to be multiplied with receivers: x, x and -y, y at each frequency.
class source_waves {
  public:
    void assign(const wave_row& from, std::size_t count) {
        time_ = from.time;
        facing_ = from.facing;
        real_.resize(floats_per_wave * count);
        imaginary_.resize(floats_per_wave * count);
        std::fill(real_.begin(), real_.end(), 0.0F);
        std::fill(imaginary_.begin(), imaginary_.end(), 0.0F);
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < spectral_value::nodes; ++k) {
                const std::size_t at = floats_per_wave * i + 2 * k;
                real_[at] = real_[at + 1] = from.wave[at];
                imaginary_[at + 1] = from.wave[at + 1];
                imaginary_[at] = -from.wave[at + 1];
            }
    }

    /// Adds the echoes of a block of reflectors at a receiver to complex samples at baseband: each is a delta at its
    /// travel time, spread over three samples by a quadratic B-spline, whose spectrum sinc^3 is divided out later.
    /// @param count   reflectors, a multiple of `wave_table::together`
    /// @param rate    samples a second
    /// @param margin  of samples before time 0
    /// @param sums    `samples` times `floats_per_wave`
    void add(const wave_row& b, std::size_t count, float rate, float margin, float* sums, std::uint32_t samples) const {
        constexpr int width = max_simd_width;
        using floats = lanes<width>;
        using wave_lanes = lanes<floats_per_wave>;
        const floats last(static_cast<float>(samples - 4)), half(0.5F);
        for (std::size_t first = 0; first < count; first += width) {
            const auto row = [&](const float* of) { return load<width>(of + first); };
            const floats place = (row(time_) + row(b.time)) * floats(rate) + floats(margin - 0.5F);
            const floats within = min(max(place, floats(0.0F)), last);
            const bit_lanes<width> below = floor_bits<width>(within); // the middle one of three follows it
            const floats facing = select(within == place, row(facing_) + row(b.facing), floats(0.0F));
            const floats u = within - floats_of<width>(below), v = floats(1.0F) - u;
            float weight[3][width];
            store(facing * half * v * v, weight[0]);
            store(facing * (half + u * v), weight[1]);
            store(facing * half * u * u, weight[2]);
            std::uint32_t sample[width];
            store_bits<width>(below, sample);
            for (std::size_t i = 0; i < width; ++i) {
                const std::size_t at = floats_per_wave * (first + i);
                const auto wave = [&](const float* of) { return load<floats_per_wave>(of + at); };
                const wave_lanes value = wave(real_.data()) * wave(b.wave) + wave(imaginary_.data()) * wave(b.swapped);
                float* const to = sums + floats_per_wave * sample[i];
                const auto tap = [&](std::size_t k) {
                    return load<floats_per_wave>(to + floats_per_wave * k) + wave_lanes(weight[k][i]) * value;
                };
                const wave_lanes before = tap(0), here = tap(1), after = tap(2);
                store(before, to);
                store(here, to + floats_per_wave);
                store(after, to + 2 * floats_per_wave);
            }
        }
    }

  private:
    const float *time_ = nullptr, *facing_ = nullptr;
    large_array<float> real_{}, imaginary_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
