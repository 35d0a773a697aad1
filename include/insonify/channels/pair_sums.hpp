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

/// Pairs of a source and a receiver. Between elements each is kept once: both ways are alike.
struct pair_numbers {
    std::size_t sources = 0, receivers = 0;
    bool symmetric = false; ///< sources are the receivers

    std::size_t count() const { return symmetric ? sources * (sources + 1) / 2 : sources * receivers; }
    /// @param receiver  not before the source where they are symmetric
    std::size_t operator()(std::size_t source, std::size_t receiver) const {
        return source * receivers + receiver - (symmetric ? source * (source + 1) / 2 : 0);
    }
};

/// So few that their waves from two tiles of elements fit into the second-level cache.
inline constexpr std::size_t reflectors_per_block = 2048;

/// One sample of a sum, or one wave: a complex value at each node.
template <int Nodes>
inline constexpr std::size_t floats_per_wave = std::size_t{2} * Nodes;

/// What arrives at each of a block of reflectors, from every source or at every receiver.
/// @tparam Nodes  frequencies around the carrier, in the middle of those of `spectral_value`
template <int Nodes>
class wave_table {
  public:
    static constexpr std::size_t block = reflectors_per_block;
    static constexpr float never = 1e3F;     // s: the time of what does not arrive
    static constexpr std::size_t group = 64; // reflectors are added in whole groups
    static_assert(block % group == 0 && group % max_simd_width == 0);

    /// Of a source or receiver.
    static constexpr std::size_t bytes_per_column() { return column_size * sizeof(float); }

    explicit wave_table(std::size_t columns) : values_(columns * column_size) {
        std::fill(values_.begin(), values_.end(), 0.0F);
    }

    /// Of one source or receiver at all reflectors, in whole registers.
    /// @{
    const float* time(std::size_t column) const { return values_.data() + column * column_size; } ///< s
    /// Share of the obliquity: 1/2 of a point, cos / 2 of a surface.
    const float* facing(std::size_t column) const { return time(column) + row; }
    /// The waves, with the phase of the carrier by the travel time.
    const float* waves(std::size_t column) const { return time(column) + 2 * row; }
    /// @}

    /// @return where the wave goes: real and imaginary part at each node
    float* set(std::size_t column, std::size_t reflector, float time, float facing) {
        float* const own = values_.data() + column * column_size;
        own[reflector] = time;
        own[row + reflector] = facing;
        return own + 2 * row + floats_per_wave<Nodes> * reflector;
    }
    /// Nothing arrives.
    void clear(std::size_t column, std::size_t reflector) {
        std::fill_n(set(column, reflector, never, 0), floats_per_wave<Nodes>, 0.0F);
    }
    /// Reflectors of all groups that begin before a number of them.
    static std::size_t whole_groups(std::size_t reflectors) { return (reflectors + group - 1) / group * group; }

  private:
    // A cache line more than a power of two, so that the waves of one reflector do not all lie in the same set of a
    // cache.
    static constexpr std::size_t row = block + 16, column_size = 2 * row + floats_per_wave<Nodes> * block + 16;
    large_array<float> values_; // source after source; aligned to cache lines
};

/// Adds the echoes of a block of reflectors from a source to a receiver to complex samples at baseband. Each is a delta
/// at its travel time, spread over three samples by a quadratic B-spline, whose spectrum sinc^3 is divided out later.
/// @param count    of the reflectors; nothing arrives at those beyond it in the last group
/// @param rate     samples a second
/// @param margin   of samples before time 0
/// @param sum      `samples` times `floats_per_wave`
/// @param next     the sum after it, which is fetched beforehand: its echoes arrive at nearly the same times
template <int Nodes>
void add_echoes(const wave_table<Nodes>& sent, std::size_t source, const wave_table<Nodes>& received,
                std::size_t receiver, std::size_t count, float rate, float margin, float* sum, const float* next,
                std::uint32_t samples) {
    constexpr int width = max_simd_width;
    constexpr std::size_t group = wave_table<Nodes>::group, wave = floats_per_wave<Nodes>;
    using floats = lanes<width>;
    using wave_lanes = lanes<static_cast<int>(wave)>;
    const floats last(static_cast<float>(samples - 4)), half(0.5F);
    const float *const sent_waves = sent.waves(source), *const received_waves = received.waves(receiver);
    for (std::size_t first = 0; first < count; first += group) {
        float weight[3][group], values[wave * group];
        std::uint32_t sample[group], heard = 0;
        for (std::size_t i = 0; i < group; i += width) {
            const auto both = [at = first + i](const float* a, const float* b) {
                return load<width>(a + at) + load<width>(b + at);
            };
            const floats place =
                both(sent.time(source), received.time(receiver)) * floats(rate) + floats(margin - 0.5F);
            const floats within = min(max(place, floats(0.0F)), last);
            const bit_lanes<width> below = bits_of_whole<width>(within); // the middle one of three follows it
            const auto inside = within == place;
            heard |= bits_of(inside);
            const floats fraction = select(inside, both(sent.facing(source), received.facing(receiver)), floats(0.0F));
            const floats u = within - floats_of<width>(below), v = floats(1.0F) - u;
            store(fraction * half * v * v, weight[0] + i);
            store(fraction * (half + u * v), weight[1] + i);
            store(fraction * half * u * u, weight[2] + i);
            store_bits<width>(below, sample + i);
        }
        if (heard == 0) continue;
        for (std::size_t i = 0; i < wave * group; i += width) {
            const std::size_t at = wave * first + i;
            store(complex_products<width>(load<width>(sent_waves + at), load<width>(received_waves + at)), values + i);
        }
        for (std::size_t i = 0; i < group; ++i) {
            const std::size_t at = wave * std::size_t{sample[i]};
            float* const to = sum + at;
            prefetch(next + at);
            const wave_lanes value = load<static_cast<int>(wave)>(values + wave * i);
            const auto tap = [&](std::size_t k) {
                return load<static_cast<int>(wave)>(to + wave * k) + wave_lanes(weight[k][i]) * value;
            };
            const wave_lanes before = tap(0), here = tap(1), after = tap(2);
            store(before, to);
            store(here, to + wave);
            store(after, to + 2 * wave);
        }
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
