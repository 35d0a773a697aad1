#ifndef INSONIFY_ACOUSTICS_ECHO_LINE_HPP
#define INSONIFY_ACOUSTICS_ECHO_LINE_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/simd_bits.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Writes echoes into one line of complex samples at baseband.
///
/// An echo a at displayed depth z adds a exp(-j 4 pi f0 z / c0) to its two neighbouring samples, divided linearly;
/// sample k stands at (k + 1/2) * spacing. The phase is reduced in cycles, so it keeps its digits at any depth.
class echo_line {
  public:
    /// @param samples    written to; they keep what they hold
    /// @param spacing    metres of displayed depth from sample to sample
    /// @param frequency  of the carrier, hertz
    INSONIFY_FN echo_line(view<vec2> samples, float spacing, float frequency)
        : samples_{samples}, per_spacing_{1 / spacing}, spacing_{spacing}, cycles_{2.0 *
                                                                                   static_cast<double>(frequency) /
                                                                                   static_cast<double>(display_speed)} {
    }

    /// Metres to the end of the last sample.
    INSONIFY_FN float depth() const { return spacing_ * static_cast<float>(samples_.size()); }

    /// One echo at a displayed depth, metres; what lies beyond the ends of the line is dropped.
    INSONIFY_FN void add(float depth, vec2 amplitude) const { put(depth, turned(amplitude, phase(depth))); }

    /// Echoes at equal steps: number i at depth + i * step, of strength scale * ratio^i times its complex amplitude.
    /// @param step       not below 0
    INSONIFY_LAZY INSONIFY_FN void add(float depth, float step, std::uint32_t count, const float* real,
                                       const float* imaginary, float scale, float ratio) const {
        constexpr int width = simd_width;
        using floats = lanes<width>;
        const vec2 turn = ratio * phase(step);
        float powers[2][width];
        vec2 power = scale * phase(depth);
        for (int i = 0; i < width; ++i) {
            powers[0][i] = power.x;
            powers[1][i] = power.y;
            power = turned(power, turn);
        }
        vec2 turn_on{1, 0};
        for (int i = 0; i < width; ++i) turn_on = turned(turn_on, turn);
        floats carrier_x = load<width>(powers[0]), carrier_y = load<width>(powers[1]);
        const auto inside = static_cast<std::uint32_t>(samples_.size()) - 1; // of a sample with a next one
        const floats turn_x(turn_on.x), turn_y(turn_on.y), one(1.0F);
        for (std::uint32_t first = 0; first < count; first += width) {
            const floats x = some_of(real + first, count - first), y = some_of(imaginary + first, count - first);
            const floats value_x = x * carrier_x - y * carrier_y, value_y = x * carrier_y + y * carrier_x;
            const floats number = floats_of<width>(steps_of_bits<width>(first, 1));
            const floats place = (floats(depth) + number * floats(step)) * floats(per_spacing_) - floats(0.5F);
            const bit_lanes<width> below = floor_bits<width>(
                lesser(greater(place, floats(-2.0F)), floats(static_cast<float>(samples_.size()) + 1.0F)));
            const floats share = place - floats_of<width>(below);
            vec2 here[width], next[width];
            store_pairs((one - share) * value_x, (one - share) * value_y, here);
            store_pairs(share * value_x, share * value_y, next);
            std::uint32_t sample[width];
            store_bits<width>(below, sample);
            if (count - first >= width && sample[0] < inside && sample[width - 1] < inside)
                for (int i = 0; i < width; ++i) {
                    samples_[sample[i]] += here[i];
                    samples_[sample[i] + 1] += next[i];
                }
            else
                for (std::uint32_t i = 0; i < width && i < count - first; ++i) put_parts(sample[i], here[i], next[i]);
            const floats turned_x = carrier_x * turn_x - carrier_y * turn_y;
            carrier_y = carrier_x * turn_y + carrier_y * turn_x;
            carrier_x = turned_x;
        }
    }

  private:
    INSONIFY_FN static vec2 turned(vec2 a, vec2 b) { return {a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x}; }

    INSONIFY_FN vec2 phase(float depth) const {
        const double cycles = cycles_ * static_cast<double>(depth);
        const auto part = static_cast<float>(cycles - std::floor(cycles));
        return {std::cos(2 * pi * part), -std::sin(2 * pi * part)};
    }

    INSONIFY_FN void put(float depth, vec2 value) const {
        const float place = clamped(depth * per_spacing_ - 0.5F, -2.0F, static_cast<float>(samples_.size()) + 1.0F);
        const float below = std::floor(place);
        const float share = place - below;
        put_parts(static_cast<std::uint32_t>(static_cast<std::int32_t>(below)), (1 - share) * value, share * value);
    }

    // As many as a register holds; zeros after the last.
    template <class = void>
    INSONIFY_FN INSONIFY_INLINE static lanes<simd_width> some_of(const float* from, std::uint32_t count) {
        if (count >= simd_width) return load<simd_width>(from);
        float some[simd_width] = {};
        for (std::uint32_t i = 0; i < count; ++i) some[i] = from[i];
        return load<simd_width>(some);
    }

    template <class Lanes>
    INSONIFY_FN INSONIFY_INLINE static void store_pairs(const Lanes& x, const Lanes& y, vec2* to) {
        float apart[2][simd_width];
        store(x, apart[0]);
        store(y, apart[1]);
        for (int i = 0; i < simd_width; ++i) to[i] = {apart[0][i], apart[1][i]};
    }

    // To a sample, which may lie before the first by wrapping round, and to the next.
    INSONIFY_FN void put_parts(std::uint32_t sample, vec2 here, vec2 next) const {
        const auto end = static_cast<std::uint32_t>(samples_.size());
        if (sample < end) samples_[sample] += here;
        if (sample + 1 < end) samples_[sample + 1] += next;
    }

    view<vec2> samples_;
    float per_spacing_;
    float spacing_;
    double cycles_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
