#ifndef INSONIFY_TISSUE_LINE_NODES_HPP
#define INSONIFY_TISSUE_LINE_NODES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd_math.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Linear interpolation between values at whole numbers, for a register full of places at equal steps. Within the register the
/// slope changes at each whole number.
/// @param count  of values, at least 2; before the first one and behind the last one the slope is that beside it
/// @param first  of the places
INSONIFY_FN INSONIFY_INLINE lanes<max_simd_width> interpolate(const float* values, std::uint32_t count, float first,
                                                              float step) {
    using floats = lanes<max_simd_width>;
    const auto whole = static_cast<std::uint32_t>(max(first, 0));
    const std::uint32_t before = whole + 2 < count ? whole : count - 2;
    const float part = first - static_cast<float>(before);
    const float* const at = values + before;
    const floats away = floats_of<max_simd_width>(steps_of_bits<max_simd_width>(0, 1)) * floats(step) + floats(part);
    floats sum = multiply_add(away, floats(at[1] - at[0]), floats(at[0]));
    for (std::uint32_t i = 1; static_cast<float>(i) < 1 + (max_simd_width - 1) * step && before + i + 1 < count; ++i)
        sum = multiply_add(max(away - floats(static_cast<float>(i)), floats(0.0F)),
                           floats(at[i + 1] - 2 * at[i] + at[i - 1]), sum);
    return sum;
}

/// A quantity that varies slowly along a line: its values at nodes, linear in between. Nodes lie at whole multiples of their
/// distance in the material, so that neighbouring segments and lines share them.
class line_nodes {
  public:
    /// Evaluates a field, lanes(lanes distances), between two distances along the line, metres.
    /// @param apart   distance of the nodes, metres; more where they would be too many
    /// @param origin  of the distances in the material, metres
    template <class Field>
    INSONIFY_FN void evaluate(float from, float to, float apart, float origin, const Field& field) {
        step_ = max(apart, (to - from) / (max_count - 3));
        first_ = std::floor((origin + from) / step_) * step_ - origin;
        count_ = static_cast<std::uint32_t>(clamp((to - first_) / step_, 0, max_count - 3)) + 2;
        for (std::uint32_t i = 0; i < count_; i += max_simd_width)
            store(field(lanes<max_simd_width>(first_) +
                        floats_of<max_simd_width>(steps_of_bits<max_simd_width>(i, 1)) * lanes<max_simd_width>(step_)),
                  value_ + i);
    }

    /// The values at a register full of distances at equal steps, metres.
    INSONIFY_FN INSONIFY_INLINE lanes<max_simd_width> at(float distance, float step) const {
        return interpolate(value_, count_, min((distance - first_) / step_, static_cast<float>(count_ - 1)),
                           step / step_);
    }

    /// A linear function of the distance.
    struct linear {
        float first = 0; ///< at distance 0
        float step = 0;  ///< per metre
    };
    /// Calls visit(begin, end, values) for every piece of a part of the line on which the quantity is linear.
    template <class Visit>
    INSONIFY_FN void for_each_piece(float from, float to, const Visit& visit) const {
        for (std::uint32_t i = 0; i + 1 < count_; ++i) {
            const float node = first_ + static_cast<float>(i) * step_;
            const float begin = i == 0 ? from : max(node, from), end = i + 2 == count_ ? to : min(node + step_, to);
            if (!(begin < end)) continue;
            const float slope = (value_[i + 1] - value_[i]) / step_;
            visit(begin, end, linear{value_[i] - slope * node, slope});
        }
    }

  private:
    static constexpr std::uint32_t max_count = 72;

    float first_ = 0, step_ = 1; // metres
    std::uint32_t count_ = 0;
    float value_[max_count + max_simd_width];
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
