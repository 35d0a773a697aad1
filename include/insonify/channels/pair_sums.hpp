#ifndef INSONIFY_CHANNELS_PAIR_SUMS_HPP
#define INSONIFY_CHANNELS_PAIR_SUMS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/large_array.hpp>
#include <insonify/channels/element_field.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/simd.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>

/// Sums over reflectors of what goes from one source by a reflector to one receiver.
namespace insonify::inline INSONIFY_ABI::detail {

/// One sample of a sum, or one wave: a complex value at each frequency, real parts before imaginary parts.
inline constexpr std::size_t floats_per_wave = std::size_t{2} * spectral_value::nodes;
using wave_lanes = lanes<floats_per_wave>;

/// What arrives at each of a block of reflectors, from every source or at every receiver.
class wave_table {
  public:
    static constexpr std::size_t block =
        2048; // reflectors; the waves of two tiles of elements fit into the second-level cache
    static constexpr float never = 1e3F; // s: the time of what does not arrive
    static_assert(block % max_simd_width == 0);

    explicit wave_table(std::size_t columns) : columns_{columns}, values_(columns * column_size) {
        std::fill(values_.begin(), values_.end(), 0.0F);
    }

    /// Of one source or receiver at all reflectors, in whole registers.
    /// @{
    const float* time(std::size_t column) const { return values_.data() + column * column_size; } ///< s
    /// Share of the obliquity: 1/2 of a point, cos / 2 of a surface.
    const float* facing(std::size_t column) const { return time(column) + block; }
    /// The waves, with the phase of the carrier by the travel time; each is followed by the same times the imaginary unit.
    const float* waves(std::size_t column) const { return time(column) + 2 * block; }
    /// @}

    void set(std::size_t column, std::size_t reflector, float time, float facing, const spectral_value& wave) {
        float* const own = values_.data() + column * column_size;
        own[reflector] = time;
        own[block + reflector] = facing;
        float* const to = own + 2 * block + floats_per_wave * reflector;
        store(wave.x, to);
        store(wave.y, to + spectral_value::nodes);
    }
    /// Nothing arrives.
    void clear(std::size_t column, std::size_t reflector) { set(column, reflector, never, 0, {}); }
    void clear(std::size_t reflector) {
        for (std::size_t i = 0; i < columns_; ++i) clear(i, reflector);
    }

  private:
    static constexpr std::size_t column_size = (2 + floats_per_wave) * block;
    std::size_t columns_;
    large_array<float> values_; // source after source; aligned to cache lines
};

/// Adds the echoes of a block of reflectors from a source to a receiver to complex samples at baseband. Each is a delta at
/// its travel time, spread over three samples by a quadratic B-spline, whose spectrum sinc^3 is divided out later.
/// @param count    of the reflectors; nothing arrives at those beyond it in the last register
/// @param rate     samples a second
/// @param margin   of samples before time 0
/// @param sum      `samples` times `floats_per_wave`
inline void add_echoes(const wave_table& sent, std::size_t source, const wave_table& received, std::size_t receiver,
                       std::size_t count, float rate, float margin, float* sum, std::uint32_t samples) {
    constexpr int width = max_simd_width;
    using floats = lanes<width>;
    const floats last(static_cast<float>(samples - 4)), half(0.5F);
    const auto imaginary = wave_lanes(spectral_value::nodes - 0.5F) <
                           each_lane<floats_per_wave>([](int lane) { return static_cast<float>(lane); });
    const float *const sent_waves = sent.waves(source), *const received_waves = received.waves(receiver);
    for (std::size_t first = 0; first < count; first += width) {
        const auto both = [first](const float* a, const float* b) {
            return load<width>(a + first) + load<width>(b + first);
        };
        const floats place = both(sent.time(source), received.time(receiver)) * floats(rate) + floats(margin - 0.5F);
        const floats within = min(max(place, floats(0.0F)), last);
        const bit_lanes<width> below = floor_bits<width>(within); // the middle one of three follows it
        const floats share =
            select(within == place, both(sent.facing(source), received.facing(receiver)), floats(0.0F));
        const floats u = within - floats_of<width>(below), v = floats(1.0F) - u;
        float weight[3][width];
        store(share * half * v * v, weight[0]);
        store(share * (half + u * v), weight[1]);
        store(share * half * u * u, weight[2]);
        std::uint32_t sample[width];
        store_bits<width>(below, sample);
        wave_lanes value[width];
        for (std::size_t i = 0; i < width; ++i) {
            const std::size_t at = floats_per_wave * (first + i);
            const wave_lanes a = load<floats_per_wave>(sent_waves + at), a_swapped = swapped_halves<floats_per_wave>(a),
                             b = load<floats_per_wave>(received_waves + at);
            value[i] = select(imaginary, a_swapped, a) * b +
                       select(imaginary, a, -a_swapped) * swapped_halves<floats_per_wave>(b);
        }
        for (std::size_t i = 0; i < width; ++i) {
            float* const to = sum + floats_per_wave * std::size_t{sample[i]};
            const auto tap = [&](std::size_t k) {
                return load<floats_per_wave>(to + floats_per_wave * k) + wave_lanes(weight[k][i]) * value[i];
            };
            const wave_lanes before = tap(0), here = tap(1), after = tap(2);
            store(before, to);
            store(here, to + floats_per_wave);
            store(after, to + 2 * floats_per_wave);
        }
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
