#ifndef INSONIFY_TISSUE_SHEET_CROSSINGS_HPP
#define INSONIFY_TISSUE_SHEET_CROSSINGS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd.hpp>
#include <insonify/tissue/placed_structure.hpp>
#include <cstdint>

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
    INSONIFY_FN INSONIFY_INLINE void clip(const floats& smallest, const floats& largest, floats& begin,
                                          floats& end) const {
        const floats size = max(abs(step), floats(1e-3F)), // no select: compilers divide on both sides of it
            per_step = select(step < floats(0.0F), floats(-1.0F), floats(1.0F)) / size;
        const floats a = (smallest - first) * per_step, b = (largest - first) * per_step;
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

/// Fraction 0 to 1 of some of the bits.
INSONIFY_FN INSONIFY_INLINE lanes<max_simd_width> fraction_of_bits(const bit_lanes<max_simd_width>& random,
                                                                   std::uint32_t shift, std::uint32_t count) {
    return floats_of<max_simd_width>((random >> static_cast<int>(shift)) & ((1U << count) - 1)) *
           lanes<max_simd_width>(1 / static_cast<float>((1U << count) - 1));
}

/// Points at equal steps of a line, and their gains.
struct gain_points {
    float first = 0;         ///< metres
    float spacing = 1;       ///< metres
    std::uint32_t count = 0; ///< of points
    float* gain = nullptr;   ///< with room for a register behind the last

    INSONIFY_FN float distance(std::uint32_t i) const { return first + static_cast<float>(i) * spacing; }
    INSONIFY_FN float last() const { return distance(count - 1); }
    INSONIFY_FN INSONIFY_INLINE lanes<max_simd_width> distances(std::uint32_t i) const {
        return lanes<max_simd_width>(first) +
               floats_of<max_simd_width>(steps_of_bits<max_simd_width>(i, 1)) * lanes<max_simd_width>(spacing);
    }
};

/// One lattice of sheets along a segment of a line. Most points of a line are outside every sheet, so the cells that the line
/// passes are listed, layer by layer and row by row, and only the points inside their sheets are evaluated.
class sheet_crossings {
  public:
    /// @param of, all, k   the layer of sheets, and the number of the lattice
    /// @param origin, along, propagation, key  as those of `structure_gains`
    /// @param lobe         see `lobe_of`
    INSONIFY_FN sheet_crossings(const structure::sheet_layer& of, const placed_structure::sheets& all, std::uint32_t k,
                                vec3 origin, vec3 along, vec3 propagation, std::uint32_t key, float lobe)
        : of_{of}, cell_{all.lattices[k].cell}, aside_{all.lattices[k].aside}, key_{all.lattices[k].key ^ key},
          facing_y_{dot(all.lattices[k].axes[1], propagation)}, facing_z_{dot(all.lattices[k].axes[2], propagation)},
          per_lobe_{1 / (lobe * lobe)}, diffuse_{all.diffuse} {
        const mat3& cells = all.lattices[k].cells;
        for (int i = 0; i < 3; ++i) place_[i] = {dot(cells[i], origin), dot(cells[i], along)};
        place_[2].first += static_cast<float>(key_ & 0xFFFFU) * 0x1p-16F; // of each object by itself
    }

    /// Adds the amplitudes of the sheets.
    /// @param waves  displacement of the sheets along z of the structure, metres
    INSONIFY_FN void add(const line_nodes& waves, const gain_points& points) const {
        part_list layers, rows;
        waves.for_each_piece(points.first, points.last() + 1e-3F * points.spacing,
                             [&](float begin, float end, const linear& wave) {
                                 const linear z = displaced(2, wave);
                                 const float per_step = (z.step < 0 ? -1.0F : 1.0F) / max(std::fabs(z.step), 1e-3F);
                                 for_each_cell(z.first + begin * z.step, z.first + end * z.step, [&](float layer) {
                                     if (layers.full()) enter_rows(layers, rows, points);
                                     const interval within = passage(z, per_step, layer, {begin, end});
                                     if (within.begin < within.end) layers.push(within, wave, layer, 0, 0);
                                 });
                             });
        enter_rows(layers, rows, points);
        enter_cells(rows, points);
    }

  private:
    using floats = lanes<max_simd_width>;
    using bits = bit_lanes<max_simd_width>;
    using linear = line_nodes::linear;
    using interval = line_interval;
    static constexpr std::uint32_t max_cells = 256; // along one axis; of more, that many

    // A coordinate in cells where the lattice is displaced.
    INSONIFY_FN linear displaced(int axis, const linear& wave) const {
        return {place_[axis].first + aside_[axis] * wave.first, place_[axis].step + aside_[axis] * wave.step};
    }
    INSONIFY_FN INSONIFY_INLINE linear_lanes displaced(int axis, const linear_lanes& wave) const {
        const floats aside(aside_[axis]);
        return {multiply_add(aside, wave.first, floats(place_[axis].first)),
                multiply_add(aside, wave.step, floats(place_[axis].step))};
    }
    // The part of an interval where a coordinate is in a cell; `per_step` is one over its change per metre, which is at least
    // 1e-3.
    INSONIFY_FN static interval passage(const linear& coordinate, float per_step, float cell, interval within) {
        const float a = (cell - coordinate.first) * per_step, b = (cell + 1 - coordinate.first) * per_step;
        return {max(within.begin, min(a, b)), min(within.end, max(a, b))};
    }
    template <class Visit>
    INSONIFY_FN static void for_each_cell(float from, float to, const Visit& visit) {
        const float first = std::floor(min(from, to)), others = std::floor(max(from, to)) - first;
        if (!is_finite(others)) return;
        const float step = 1 + std::floor(others * (1.0F / max_cells));
        for (std::uint32_t i = 0; static_cast<float>(i) * step <= others; ++i)
            visit(first + static_cast<float>(i) * step);
    }

    // Rows within a layer are shifted at random.
    INSONIFY_FN void enter_rows(part_list& layers, part_list& rows, const gain_points& points) const {
        for (std::uint32_t i = 0; i < layers.count; i += max_simd_width) {
            const part_lanes part{layers, i};
            const bits random =
                mix_lanes<max_simd_width>(bits_of_whole<max_simd_width>(part.layer) * 0xC2B2AE35U + key_);
            const linear_lanes y = displaced(1, part.wave);
            const floats shift = fraction_of_bits(random, 0, 16);
            float from[max_simd_width], to[max_simd_width];
            std::uint32_t of_layer[max_simd_width];
            store(y.at(part.begin) + shift, from);
            store(y.at(part.end) + shift, to);
            store_bits<max_simd_width>(random, of_layer);
            for (std::uint32_t k = i; k < i + max_simd_width && k < layers.count; ++k)
                for_each_cell(from[k - i], to[k - i], [&](float row) {
                    if (rows.full()) enter_cells(rows, points);
                    rows.push({layers.begin[k], layers.end[k]}, {layers.wave[k], layers.wave_step[k]}, layers.layer[k],
                              row, of_layer[k - i]);
                });
        }
        layers.count = 0;
    }

    // Cells within a row are shifted too.
    INSONIFY_FN void enter_cells(part_list& rows, const gain_points& points) const {
        for (std::uint32_t i = 0; i < rows.count; i += max_simd_width) {
            const part_lanes part{rows, i};
            const bits of_layer = load_bits<max_simd_width>(rows.of_layer + i);
            cell_lanes in{{}, displaced(1, part.wave), displaced(2, part.wave), part.begin, part.end};
            in.y.first = in.y.first + fraction_of_bits(of_layer, 0, 16) - part.row;
            in.y.clip(floats(0.0F), floats(1.0F), in.begin, in.end);
            in.z.first = in.z.first - part.layer;
            const bits column =
                mix_lanes<max_simd_width>(bits_of_whole<max_simd_width>(part.row) * 0x85EBCA6BU + of_layer);
            linear_lanes x = displaced(0, part.wave);
            x.first = x.first + fraction_of_bits(column, 0, 16);
            const floats from = x.at(in.begin), to = x.at(in.end), lowest = min(from, to), highest = max(from, to);
            const auto passed = in.begin < in.end;
            bits number = floor_bits<max_simd_width>(lowest);
            for (std::uint32_t tries = 0; tries < max_cells; ++tries, number = number + 1U) {
                const auto entered = passed && floats_of<max_simd_width>(number) <= highest;
                if (bits_of(entered) == 0) break;
                const bits random = mix_lanes<max_simd_width>(column + number * 0x9E3779B9U);
                const auto holds_sheet = entered && fraction_of_bits(random, 0, 8) < floats(of_.fill);
                if (bits_of(holds_sheet) == 0) continue;
                in.x = {x.first - floats_of<max_simd_width>(number), x.step};
                cross(in, random, holds_sheet, points);
            }
        }
        rows.count = 0;
    }

    // The line in cells: coordinates from their first corners, and where it passes them.
    struct cell_lanes {
        linear_lanes x, y, z;
        floats begin, end;
    };

    // Size, angle and place of the sheet in each cell, within which it stays, and the part of the line inside it. Its profile
    // ends at four standard deviations.
    INSONIFY_FN void cross(const cell_lanes& in, const bits& a, const lane_mask<max_simd_width>& holds_sheet,
                           const gain_points& points) const {
        const floats one(1.0F), half(0.5F);
        const bits b = mix_lanes<max_simd_width>(a + 0x51ED270BU);
        const floats half_length =
            floats(0.375F) * multiply_add(fraction_of_bits(a, 8, 8), floats(0.55F), floats(0.45F));
        const floats half_width =
            floats(0.4F * cell_.y) * multiply_add(fraction_of_bits(a, 16, 8), floats(0.4F), floats(0.6F));
        const floats angle = (fraction_of_bits(b, 14, 8) - half) * floats(2 * of_.turn), squared = angle * angle;
        const floats sine =
            angle * polynomial<max_simd_width>(squared, -1.9841270e-4F, 8.3333333e-3F, -0.16666667F, 1.0F);
        const floats cosine =
            polynomial<max_simd_width>(squared, 2.4801587e-5F, -1.3888889e-3F, 4.1666667e-2F, -0.5F, 1.0F);
        const auto from_centre = [&](const linear_lanes& at, const floats& extent, const floats& random,
                                     const floats& unit) -> linear_lanes {
            const floats e = min(extent, half);
            return {(at.first - multiply_add(one - (e + e), random, e)) * unit, at.step * unit};
        };
        const floats margin(1.5F * of_.thickness); // so that little of the profile is cut off at the sides of the cell
        const floats wide = half_width * cosine + margin * abs(sine), high = half_width * abs(sine) + margin * cosine;
        const linear_lanes x = from_centre(in.x, half_length, fraction_of_bits(a, 24, 8), one / half_length),
                           y = from_centre(in.y, wide * floats(1 / cell_.y), fraction_of_bits(b, 0, 7),
                                           floats(cell_.y)),
                           z = from_centre(in.z, high * floats(1 / cell_.z), fraction_of_bits(b, 7, 7),
                                           floats(cell_.z));
        const floats per_width = one / half_width, thicknesses(1 / of_.thickness);
        const linear_lanes across{(y.first * sine + z.first * cosine) * thicknesses,
                                  (y.step * sine + z.step * cosine) * thicknesses},
            within{(y.first * cosine - z.first * sine) * per_width, (y.step * cosine - z.step * sine) * per_width};
        floats begin = in.begin, end = in.end;
        across.clip(floats(-4.0F), floats(4.0F), begin, end);
        within.clip(-one, one, begin, end);
        x.clip(-one, one, begin, end);
        const floats per_point(1 / points.spacing);
        const bits first = floor_bits<max_simd_width>((floats(points.first) - begin) * per_point), // less than 0
            last = floor_bits<max_simd_width>((end - floats(points.first)) * per_point);
        std::uint32_t met =
            bits_of(holds_sheet && begin < end && -floats_of<max_simd_width>(first) <= floats_of<max_simd_width>(last));
        if (met == 0) return;

        const floats steps = floats_of<max_simd_width>(((b >> 22) & 31U) + (b >> 27)); // a sum of two, each 0 to 31
        const floats level_number =
            multiply_add(steps, floats(max_level_number / 32), floats(-max_level_number * 31 / 32));
        const floats level = multiply_add(level_number, floats(bits_per_decibel * of_.spread_db),
                                          floats(bits_per_decibel * of_.level_db));
        const floats facing = sine * floats(facing_y_) + cosine * floats(facing_z_);
        const floats turned = (facing * facing - one) * floats(per_lobe_);
        const floats echo = multiply_add(power_of_two<max_simd_width>(turned), floats(1 - diffuse_), floats(diffuse_));

        std::uint32_t from[max_simd_width], to[max_simd_width];
        store_bits<max_simd_width>(-first, from);
        store_bits<max_simd_width>(last, to);
        float sheet[7][max_simd_width];
        store(across.first, sheet[0]);
        store(across.step, sheet[1]);
        store(within.first, sheet[2]);
        store(within.step, sheet[3]);
        store(x.first, sheet[4]);
        store(x.step, sheet[5]);
        store(power_of_two<max_simd_width>(level) * echo, sheet[6]);
        for (std::uint32_t k = 0; met != 0; ++k, met >>= 1) {
            if ((met & 1U) == 0) continue;
            const auto at = [&](int which, const floats& distance) {
                return multiply_add(distance, floats(sheet[which + 1][k]), floats(sheet[which][k]));
            };
            const floats amplitude(sheet[6][k]), zero(0.0F), end_point(static_cast<float>(to[k]) + 0.5F);
            for (std::uint32_t i = from[k]; i <= to[k] && i < points.count; i += max_simd_width) {
                const floats distance = points.distances(i), offset = at(0, distance), w = at(2, distance),
                             l = at(4, distance);
                const floats outline = max(one - l * l, zero) * max(one - w * w, zero);
                const floats here =
                    power_of_two<max_simd_width>(offset * offset * floats(-0.72134752F)) * sqrt(outline) * amplitude;
                const auto inside = floats_of<max_simd_width>(steps_of_bits<max_simd_width>(i, 1)) < end_point;
                store(load<max_simd_width>(points.gain + i) + select(inside, here, zero), points.gain + i);
            }
        }
    }

    const structure::sheet_layer& of_;
    vec3 cell_, aside_;
    linear place_[3]; // coordinates in cells
    std::uint32_t key_;
    float facing_y_, facing_z_; // components of the direction of propagation
    float per_lobe_, diffuse_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
