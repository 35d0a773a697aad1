#ifndef INSONIFY_TISSUE_LINE_PARTS_HPP
#define INSONIFY_TISSUE_LINE_PARTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd_bits.hpp>
#include <insonify/tissue/line_nodes.hpp>
#include <cstdint>

/// Parts of a line, a register at a time: see `sheet_crossings`.
namespace insonify::inline INSONIFY_ABI::detail {

/// Metres along a line.
struct line_interval {
    float begin = 0, end = 0;
};

/// Values that are linear along a line, one in each lane.
struct linear_lanes {
    using floats = lanes<max_simd_width>;
    floats first, step;

    INSONIFY_FN INSONIFY_INLINE floats at(const floats& distance) const { return multiply_add(distance, step, first); }
    /// Shortens an interval to its part where least <= value < most; never beyond its ends.
    INSONIFY_FN INSONIFY_INLINE void clip(const floats& least, const floats& most, floats& begin, floats& end) const {
        const floats size = max(abs(step), floats(1e-3F)), // no select: compilers divide on both sides of it
            per_step = select(step < floats(0.0F), floats(-1.0F), floats(1.0F)) / size;
        const floats a = (least - first) * per_step, b = (most - first) * per_step;
        const floats from = min(max(begin, min(a, b)), end);
        end = max(min(end, max(a, b)), begin);
        begin = from;
    }
};

/// Parts of the line within one layer of cells, or one row.
struct part_list {
    static constexpr std::uint32_t room = 64;
    float begin[room], end[room], wave[room], wave_step[room], layer[room], row[room];
    std::uint32_t of_layer[room]; // random bits
    std::uint32_t count = 0;

    INSONIFY_FN bool full() const { return count == room; }
    INSONIFY_FN void push(line_interval within, const line_nodes::linear& displaced, float in_layer, float in_row,
                          std::uint32_t random) {
        begin[count] = within.begin;
        end[count] = within.end;
        wave[count] = displaced.first;
        wave_step[count] = displaced.step;
        layer[count] = in_layer;
        row[count] = in_row;
        of_layer[count++] = random;
    }
};

/// A register full of a list. Behind its end all is 0, so that parts are empty.
struct part_lanes {
    using floats = lanes<max_simd_width>;
    floats begin, end, layer, row;
    linear_lanes wave;
    INSONIFY_FN INSONIFY_INLINE part_lanes(const part_list& of, std::uint32_t i) {
        const auto listed =
            floats_of<max_simd_width>(steps_of_bits<max_simd_width>(i, 1)) < floats(static_cast<float>(of.count));
        const auto at = [&](const float* list) { return select(listed, load<max_simd_width>(list + i), floats(0.0F)); };
        begin = at(of.begin);
        end = at(of.end);
        layer = at(of.layer);
        row = at(of.row);
        wave = {at(of.wave), at(of.wave_step)};
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
