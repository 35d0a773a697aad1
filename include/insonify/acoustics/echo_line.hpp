#ifndef INSONIFY_ACOUSTICS_ECHO_LINE_HPP
#define INSONIFY_ACOUSTICS_ECHO_LINE_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/view.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Writes echoes into one line of complex samples at baseband.
///
/// An echo a at displayed depth z adds a exp(-j 4 pi f0 z / c0) to its two neighbouring samples, divided linearly;
/// sample k stands at (k + 1/2) * spacing. The phase is reduced in cycles, so it keeps its digits at any depth.
class echo_line {
  public:
    INSONIFY_FN echo_line(view<vec2> samples, float spacing, float frequency)
        : samples_{samples}, per_spacing_{1 / spacing}, spacing_{spacing}, cycles_{2.0 *
                                                                                   static_cast<double>(frequency) /
                                                                                   static_cast<double>(display_speed)} {
    }

    /// Metres to the end of the last sample.
    INSONIFY_FN float depth() const { return spacing_ * static_cast<float>(samples_.size()); }

    INSONIFY_FN void add(float depth, vec2 amplitude) const { put(depth, turned(amplitude, phase(depth))); }

    /// Echoes at equal steps: number i at depth + i * step, of strength scale * ratio^i.
    INSONIFY_FN void add(float depth, float step, std::uint32_t count, const vec2* amplitude, float scale,
                         float ratio) const {
        vec2 carrier = scale * phase(depth);
        const vec2 turn = ratio * phase(step);
        for (std::uint32_t i = 0; i < count; ++i) {
            put(depth + static_cast<float>(i) * step, turned(amplitude[i], carrier));
            carrier = turned(carrier, turn);
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
        const float place = depth * per_spacing_ - 0.5F;
        const float below = std::floor(place);
        const float share = place - below;
        const auto k = static_cast<std::int64_t>(below);
        const auto end = static_cast<std::int64_t>(samples_.size());
        if (k >= 0 && k < end) samples_[static_cast<std::size_t>(k)] += (1 - share) * value;
        if (k >= -1 && k + 1 < end) samples_[static_cast<std::size_t>(k + 1)] += share * value;
    }

    view<vec2> samples_;
    float per_spacing_;
    float spacing_;
    double cycles_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
