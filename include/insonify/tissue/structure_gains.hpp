#ifndef INSONIFY_TISSUE_STRUCTURE_GAINS_HPP
#define INSONIFY_TISSUE_STRUCTURE_GAINS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/random.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/tissue/structure.hpp>
#include <cfloat>
#include <cmath>
#include <cstdint>

/// Factors on the amplitude of speckle along a line, a register at a time.
namespace insonify::inline INSONIFY_ABI::detail {

inline constexpr int wide_lanes = max_simd_width;
using wide_floats = lanes<wide_lanes>;
using wide_bits = bit_lanes<wide_lanes>;

/// first, first + 1, first + 2, ...
INSONIFY_FN INSONIFY_INLINE wide_floats whole_numbers(std::uint32_t first) {
    return floats_of<wide_lanes>(steps_of_bits<wide_lanes>(first, 1));
}

/// Fraction 0 to 1 of some of the bits.
INSONIFY_FN INSONIFY_INLINE wide_floats fraction_of_bits(const wide_bits& random, int shift, std::uint32_t count) {
    return floats_of<wide_lanes>((random >> shift) & ((1U << count) - 1)) *
           wide_floats(1 / static_cast<float>((1U << count) - 1));
}
/// A number between two others, by eight of the bits.
INSONIFY_FN INSONIFY_INLINE wide_floats between(const wide_bits& random, int shift, float lowest, float highest) {
    return multiply_add(fraction_of_bits(random, shift, 8), wide_floats(highest - lowest), wide_floats(lowest));
}

/// Amplitude of a level of `mean` plus `number` times `deviation`, dB.
INSONIFY_FN INSONIFY_INLINE wide_floats decibels(const wide_floats& number, float deviation, float mean = 0) {
    return power_of_two<wide_lanes>(
        multiply_add(number, wide_floats(bits_per_decibel * deviation), wide_floats(bits_per_decibel * mean)));
}
/// A Gaussian of standard deviation 1 and peak 1.
INSONIFY_FN INSONIFY_INLINE wide_floats gaussian(const wide_floats& x) {
    return power_of_two<wide_lanes>(x * x * wide_floats(-0.72134752F)); // -log2(e) / 2
}

/// A linear function of the distance along a line, metres.
struct linear_along {
    float first = 0; ///< at distance 0
    float step = 0;  ///< per metre

    INSONIFY_FN float at(float distance) const { return first + distance * step; }
    INSONIFY_FN INSONIFY_INLINE wide_floats at(const wide_floats& distance) const {
        return multiply_add(distance, wide_floats(step), wide_floats(first));
    }
};

/// Linear interpolation between values at whole numbers, for a register full of places at equal steps. Within the
/// register the slope changes at each whole number.
/// @param count  of values, at least 2; before the first one and behind the last one the slope is that beside it
/// @param first  of the places
INSONIFY_FN INSONIFY_INLINE wide_floats interpolate(const float* values, std::uint32_t count, float first, float step) {
    const auto whole = static_cast<std::uint32_t>(max(first, 0));
    const std::uint32_t before = whole + 2 < count ? whole : count - 2;
    const float part = first - static_cast<float>(before);
    const float* const at = values + before;
    const wide_floats away = whole_numbers(0) * wide_floats(step) + wide_floats(part);
    wide_floats sum = multiply_add(away, wide_floats(at[1] - at[0]), wide_floats(at[0]));
    for (std::uint32_t i = 1; static_cast<float>(i) < 1 + (wide_lanes - 1) * step && before + i + 1 < count; ++i)
        sum = multiply_add(max(away - wide_floats(static_cast<float>(i)), wide_floats(0.0F)),
                           wide_floats(at[i + 1] - 2 * at[i] + at[i - 1]), sum);
    return sum;
}

/// A quantity that varies slowly along a line: its values at nodes, linear in between. Nodes lie at whole multiples of
/// their distance in the material, so that neighbouring segments and lines share them.
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
        for (std::uint32_t i = 0; i < count_; i += wide_lanes)
            store(field(wide_floats(first_) + whole_numbers(i) * wide_floats(step_)), value_ + i);
    }

    /// The values at a register full of distances at equal steps, metres.
    INSONIFY_FN INSONIFY_INLINE wide_floats at(float distance, float step) const {
        return interpolate(value_, count_, min((distance - first_) / step_, static_cast<float>(count_ - 1)),
                           step / step_);
    }

    /// Calls visit(begin, end, values) for every piece of a part of the line on which the quantity is linear. Each
    /// begins exactly where the one before ends.
    template <class Visit>
    INSONIFY_FN void for_each_piece(float from, float to, const Visit& visit) const {
        float node = first_, next = first_;
        for (std::uint32_t i = 0; i + 1 < count_; ++i, node = next) {
            next = first_ + static_cast<float>(i + 1) * step_;
            const float begin = i == 0 ? from : max(node, from), end = i + 2 == count_ ? to : min(next, to);
            if (!(begin < end)) continue;
            const float slope = (value_[i + 1] - value_[i]) / step_;
            visit(begin, end, linear_along{value_[i] - slope * node, slope});
        }
    }

  private:
    static constexpr std::uint32_t max_count = 72;

    float first_ = 0, step_ = 1; // metres
    std::uint32_t count_ = 0;
    float value_[max_count + wide_lanes];
};

/// Points at equal steps of a line, and their gains.
struct gain_points {
    float first = 0;         ///< metres
    float spacing = 1;       ///< metres
    std::uint32_t count = 0; ///< of points
    float* gain = nullptr;   ///< with room for a register behind the last

    INSONIFY_FN float distance(std::uint32_t i) const { return first + static_cast<float>(i) * spacing; }
    INSONIFY_FN float last() const { return distance(count - 1); }
    INSONIFY_FN INSONIFY_INLINE wide_floats distances(std::uint32_t i) const {
        return wide_floats(first) + whole_numbers(i) * wide_floats(spacing);
    }
};

/// Value noise: random numbers at the points of the unit lattice, and cubic interpolation between them. Mean 0,
/// variance 1, approximately normally distributed.
/// Source: lattice value noise, Perlin & Hoffert 1989.
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> value_noise(std::uint32_t key, const lanes<N>& x, const lanes<N>& y,
                                                 const lanes<N>& z) {
    using floats = lanes<N>;
    using bits = bit_lanes<N>;
    constexpr std::uint32_t next_x = 0x9E3779B9U, next_y = 0x85EBCA6BU, next_z = 0xC2B2AE35U;
    const bits column = floor_bits<N>(x), row = floor_bits<N>(y), layer = floor_bits<N>(z);
    const auto smooth = [](const floats& t) { return t * t * (floats(3.0F) - (t + t)); };
    const floats right = smooth(x - floats_of<N>(column)), down = smooth(y - floats_of<N>(row)),
                 back = smooth(z - floats_of<N>(layer));
    const bits first = column * next_x + row * next_y + layer * next_z + key;
    const auto corner = [&](std::uint32_t offset) {
        constexpr std::uint32_t bytes = 0x00FF00FFU;
        const bits random = mix_lanes<N>(first + offset), pairs = (random & bytes) + ((random >> 8) & bytes);
        return floats_of<N>((pairs & 0xFFFFU) + (pairs >> 16)); // the sum of four bytes
    };
    const auto between = [](const floats& a, const floats& b, const floats& part) {
        return multiply_add(part, b - a, a);
    };
    const auto side = [&](std::uint32_t offset) {
        return between(between(corner(offset), corner(offset + next_x), right),
                       between(corner(offset + next_y), corner(offset + next_y + next_x), right), down);
    };
    // The variance of four bytes, and the mean of the squared weights over the cell: 0.743^3.
    constexpr float deviation = 147.8F * 0.6403F;
    return (between(side(0), side(next_z), back) - floats(510.0F)) * floats(1 / deviation);
}

/// The ends of fibres on the sheath of their object, into which they curve as parabolas: at a depth d below it the
/// structure is displaced along the normal by
///
///     u(d) = (sqrt(D) - sqrt(d))^2   above D,   0 below
///
/// so that the component of the fibres along the normal falls as sqrt(d / D), to 0 where they end.
struct fibre_insertion {
    vec3 normal{0, 0, 0}; ///< outwards, in the coordinates of the structure, of length 1 in tissue at rest
    float end = 0;        ///< where fibres end, metres along the line from the origin of the segment
    float cosine = 0; ///< of the angle of incidence; negative where the line leaves the object, 0: fibres do not end
    float depth = 0;  ///< D, metres; 0: fibres stay straight

    /// Depth below the sheath at distances along the segment, metres.
    INSONIFY_FN INSONIFY_INLINE wide_floats below(const wide_floats& distance) const {
        return (distance - wide_floats(end)) * wide_floats(cosine);
    }
    /// Whether fibres curve at one of these distances.
    INSONIFY_FN INSONIFY_INLINE bool curves(const wide_floats& distance) const {
        return depth > 0 && bits_of(below(distance) < wide_floats(depth)) != 0;
    }
    /// u at distances along the segment, metres.
    INSONIFY_FN INSONIFY_INLINE wide_floats displacement(const wide_floats& distance) const {
        const wide_floats largest(depth);
        const wide_floats missing = sqrt(largest) - sqrt(min(max(below(distance), wide_floats(0.0F)), largest));
        return missing * missing;
    }
};

/// What the insertions of fibres do to a structure along a segment of a line.
class fibre_course {
  public:
    /// A part of the line where the displacement is linear.
    struct piece {
        float end = FLT_MAX;  ///< metres from the origin of the segment
        linear_along aside{}; ///< metres along the normal
        float stretch = 0;    ///< displacement per metre that the depth decreases
        float steepness = 0;  ///< root of (1 + stretch)^2 - 1
        int at_exit = 0;      ///< 1: the normal is that of the surface at which the line leaves the object
    };

    fibre_course() = default; ///< straight fibres without ends
    /// Where a line enters and leaves an object; the parts of it where fibres curve do not overlap.
    INSONIFY_FN fibre_course(const fibre_insertion& entry, const fibre_insertion& exit) : insertions_{entry, exit} {
        count_ = 0;
        if (entry.cosine != 0) begin_ = entry.end;
        for (int k = 0; k < parts && entry.depth > 0; ++k) add(0, k, k + 1);
        pieces_[count_++].end = exit.cosine != 0 ? place(exit, parts) : FLT_MAX;
        for (int k = parts - 1; k >= 0 && exit.depth > 0; --k) add(1, k, k);
    }

    /// Calls visit(begin, end, piece) for the pieces of a part of the line where there are fibres. Each begins exactly
    /// where the one before ends.
    template <class Visit>
    INSONIFY_FN void for_each_piece(float from, float to, const Visit& visit) const {
        from = max(from, begin_);
        for (std::uint32_t i = 0; i < count_ && from < to; ++i) {
            const float end = min(pieces_[i].end, to);
            if (!(from < end)) continue;
            visit(from, end, pieces_[i]);
            from = end;
        }
    }
    /// Where the line enters the object, and where it leaves it.
    INSONIFY_FN const fibre_insertion (&insertions() const)[2] { return insertions_; }

  private:
    // Pieces end at depths of D (k / parts)^2: equal steps of the tangent of the angle between fibres and surface.
    static constexpr int parts = 2;

    INSONIFY_FN static float place(const fibre_insertion& of, int k) {
        const float part = static_cast<float>(k) / parts;
        return of.end + of.depth * part * part / of.cosine;
    }
    // The piece between the depths of steps k and k + 1, of which the line passes `last` last.
    INSONIFY_FN void add(int at_exit, int k, int last) {
        const fibre_insertion& of = insertions_[at_exit];
        const float missing = 1 - static_cast<float>(k) / parts, longer = 2.0F * parts / static_cast<float>(2 * k + 1);
        piece& one = pieces_[count_++];
        one.end = place(of, last);
        one.stretch = longer - 1;
        one.steepness = std::sqrt(longer * longer - 1);
        one.aside.step = -one.stretch * of.cosine;
        one.aside.first = of.depth * missing * missing - one.aside.step * place(of, k);
        one.at_exit = at_exit;
    }

    fibre_insertion insertions_[2] = {};
    piece pieces_[2 * parts + 1] = {};
    std::uint32_t count_ = 1;
    float begin_ = -FLT_MAX; // of the first piece
};

/// A straight segment of a line in an object.
struct object_segment {
    vec3 origin{0, 0, 0};      ///< metres
    vec3 along{0, 0, 1};       ///< metres of material per metre of the line
    vec3 propagation{0, 0, 1}; ///< of sound, length 1
    float fnumber = 2;         ///< of the receiving aperture
    std::uint32_t key = 0;     ///< of the object
    float length = 0;          ///< metres of the line

    /// Distance of the origin in the material, metres along the line.
    INSONIFY_FN float place() const { return dot(origin, along) / dot(along, along); }
    /// The coordinate along an axis, in units of some metres.
    INSONIFY_FN linear_along coordinate(vec3 axis, float unit) const {
        return {dot(axis, origin) / unit, dot(axis, along) / unit};
    }
    /// `value_noise` of cells of a size along axes.
    INSONIFY_FN wide_floats noise(const mat3& axes, vec3 size, std::uint32_t random, const wide_floats& distance,
                                  const fibre_course& course = {}) const {
        wide_floats place[3];
        for (int i = 0; i < 3; ++i) place[i] = coordinate(axes[i], size[i]).at(distance);
        for (const fibre_insertion& one : course.insertions()) {
            if (!one.curves(distance)) continue;
            const wide_floats aside = one.displacement(distance);
            for (int i = 0; i < 3; ++i)
                place[i] = multiply_add(aside, wide_floats(dot(axes[i], one.normal) / size[i]), place[i]);
        }
        return value_noise<wide_lanes>(mix_bits(random), place[0], place[1], place[2]);
    }
};

/// One lattice of sheets along a segment of a line. The cells that the line passes are listed, layer by layer and row
/// by row, and only the points inside their sheets are evaluated.
class sheet_crossings {
    using floats = wide_floats;
    using bits = wide_bits;

  public:
    /// @param all, k  the layer of sheets, and the number of the lattice
    /// @param lobe    see `lobe_of`
    INSONIFY_FN sheet_crossings(const placed_structure::sheets& all, std::uint32_t k, const object_segment& segment,
                                const fibre_course& course, float lobe)
        : of_{all.of}, lattice_{all.lattices[k]}, course_{course}, key_{lattice_.key ^ segment.key},
          per_lobe_{1 / (lobe * lobe)}, diffuse_{all.diffuse}, facing_{across(segment.propagation)} {
        for (int i = 0; i < 2; ++i) {
            const vec3 normal = course.insertions()[i].normal;
            for (int axis = 0; axis < 3; ++axis) normals_[i].cells[axis] = dot(lattice_.cells[axis], normal);
            normals_[i].across = across(normal);
            normals_[i].facing = dot(normal, segment.propagation);
        }
        for (int i = 0; i < 3; ++i) place_[i] = segment.coordinate(lattice_.cells[i], 1);
        place_[2].first += static_cast<float>(key_ & 0xFFFFU) * 0x1p-16F; // of each object by itself
    }

    /// Adds the amplitudes of the sheets.
    /// @param waves  displacement of the sheets along z of the structure, metres
    INSONIFY_FN void add(const line_nodes& waves, const gain_points& points) const {
        passage_list rows;
        waves.for_each_piece(points.first, points.last() + 1e-3F * points.spacing,
                             [&](float from, float to, const linear_along& wave) {
                                 course_.for_each_piece(from, to, [&](float a, float b, const fibre_course::piece& of) {
                                     list_rows(straight(a, b, wave, of), rows, points);
                                 });
                             });
        enter_cells(rows, points);
    }

  private:
    static constexpr std::uint32_t max_cells = 256; // along one axis; of more, that many

    // Values that are linear along the line, one in each lane.
    struct linear_lanes {
        floats first, step;

        INSONIFY_FN INSONIFY_INLINE floats at(const floats& distance) const {
            return multiply_add(distance, step, first);
        }
        // Shortens an interval to its part where smallest <= value < largest; never beyond its ends.
        INSONIFY_FN INSONIFY_INLINE void clip(const floats& smallest, const floats& largest, floats& begin,
                                              floats& end) const {
            const floats zero(0.0F), one(1.0F);
            const floats size = max(abs(step), floats(1e-3F)), // no select: compilers divide on both sides of it
                per_step = select(step < zero, -one, one) / size;
            const floats a = (smallest - first) * per_step, b = (largest - first) * per_step;
            const floats from = min(max(begin, min(a, b)), end);
            end = max(min(end, max(a, b)), begin);
            begin = from;
        }
    };

    // A part of the line that is straight in the coordinates of the lattice, which are in cells.
    struct straight_part {
        float begin, end; // metres along the line
        linear_along x, y, z;
        // A normal n of a sheet, given by its components along y and z, is |n + its component along `steep`| times as
        // long where fibres curve, and has the component n . facing along the propagation of sound.
        vec2 facing, steep;
    };

    // Parts of the line, each within one row of cells of one layer.
    struct passage_list {
        static constexpr std::uint32_t room = 64;
        float begin[room], end[room], layer[room], row[room];
        float x[room], x_step[room], y[room], y_step[room], z[room], z_step[room]; // see `straight_part`
        float facing_y[room], facing_z[room], steep_y[room], steep_z[room];
        std::uint32_t of_layer[room]; // random bits
        std::uint32_t count = 0;

        INSONIFY_FN void push(const straight_part& of, float from, float to, float in_layer, float in_row,
                              std::uint32_t random) {
            begin[count] = from;
            end[count] = to;
            layer[count] = in_layer;
            row[count] = in_row;
            x[count] = of.x.first;
            x_step[count] = of.x.step;
            y[count] = of.y.first;
            y_step[count] = of.y.step;
            z[count] = of.z.first;
            z_step[count] = of.z.step;
            facing_y[count] = of.facing.x;
            facing_z[count] = of.facing.y;
            steep_y[count] = of.steep.x;
            steep_z[count] = of.steep.y;
            of_layer[count++] = random;
        }
    };

    // The components along axes 1 and 2.
    INSONIFY_FN vec2 across(vec3 v) const { return {dot(lattice_.axes[1], v), dot(lattice_.axes[2], v)}; }

    INSONIFY_FN straight_part straight(float begin, float end, const linear_along& wave,
                                       const fibre_course::piece& course) const {
        const surface_normal& normal = normals_[course.at_exit];
        const auto displaced = [&](int axis) -> linear_along {
            const float aside = lattice_.aside[axis], turned = normal.cells[axis];
            return {place_[axis].first + aside * wave.first + turned * course.aside.first,
                    place_[axis].step + aside * wave.step + turned * course.aside.step};
        };
        return {begin,
                end,
                displaced(0),
                displaced(1),
                displaced(2),
                facing_ + course.stretch * normal.facing * normal.across,
                course.steepness * normal.across};
    }
    // Divides a part into rows of cells.
    INSONIFY_FN void list_rows(const straight_part& of, passage_list& rows, const gain_points& points) const {
        const float per_step = (of.z.step < 0 ? -1.0F : 1.0F) / max(std::fabs(of.z.step), 1e-3F);
        for_each_cell(of.z.at(of.begin), of.z.at(of.end), [&](float layer) {
            const float a = (layer - of.z.first) * per_step, b = (layer + 1 - of.z.first) * per_step;
            const float begin = max(of.begin, min(a, b)), end = min(of.end, max(a, b));
            if (!(begin < end)) return;
            // Rows within a layer are shifted at random.
            const auto number = static_cast<std::uint32_t>(static_cast<std::int64_t>(layer));
            const std::uint32_t random = mix_bits(number * 0xC2B2AE35U + key_);
            const float shift = static_cast<float>(random & 0xFFFFU) * (1.0F / 0xFFFF);
            for_each_cell(of.y.at(begin) + shift, of.y.at(end) + shift, [&](float row) {
                if (rows.count == passage_list::room) enter_cells(rows, points);
                rows.push(of, begin, end, layer, row, random);
            });
        });
    }
    template <class Visit>
    INSONIFY_FN static void for_each_cell(float from, float to, const Visit& visit) {
        const float first = std::floor(min(from, to)), others = std::floor(max(from, to)) - first;
        if (!is_finite(others)) return;
        const float step = 1 + std::floor(others * (1.0F / max_cells));
        for (std::uint32_t i = 0; static_cast<float>(i) * step <= others; ++i)
            visit(first + static_cast<float>(i) * step);
    }

    // Cells within a row are shifted too.
    INSONIFY_FN void enter_cells(passage_list& rows, const gain_points& points) const {
        const floats zero(0.0F);
        for (std::uint32_t i = 0; i < rows.count; i += wide_lanes) {
            const auto listed = whole_numbers(i) < floats(static_cast<float>(rows.count));
            const auto at = [&](const float* list) { // behind the end of the list all is 0, so that parts are empty
                return select(listed, load<wide_lanes>(list + i), zero);
            };
            const bits of_layer = load_bits<wide_lanes>(rows.of_layer + i);
            const floats row = at(rows.row);
            linear_lanes x{at(rows.x), at(rows.x_step)};
            cell_lanes in{{},
                          {at(rows.y), at(rows.y_step)},
                          {at(rows.z), at(rows.z_step)},
                          at(rows.begin),
                          at(rows.end),
                          at(rows.facing_y),
                          at(rows.facing_z),
                          at(rows.steep_y),
                          at(rows.steep_z)};
            in.y.first = in.y.first + fraction_of_bits(of_layer, 0, 16) - row;
            in.y.clip(zero, floats(1.0F), in.begin, in.end);
            in.z.first = in.z.first - at(rows.layer);
            const bits column = mix_lanes<wide_lanes>(bits_of_whole<wide_lanes>(row) * 0x85EBCA6BU + of_layer);
            x.first = x.first + fraction_of_bits(column, 0, 16);
            const floats from = x.at(in.begin), to = x.at(in.end), lowest = min(from, to), highest = max(from, to);
            const auto passed = in.begin < in.end;
            bits number = floor_bits<wide_lanes>(lowest);
            for (std::uint32_t tries = 0; tries < max_cells; ++tries, number = number + 1U) {
                const auto entered = passed && floats_of<wide_lanes>(number) <= highest;
                if (bits_of(entered) == 0) break;
                const bits random = mix_lanes<wide_lanes>(column + number * 0x9E3779B9U);
                const auto holds_sheet = entered && fraction_of_bits(random, 0, 8) < floats(of_.fill);
                if (bits_of(holds_sheet) == 0) continue;
                in.x = {x.first - floats_of<wide_lanes>(number), x.step};
                cross(in, random, holds_sheet, points);
            }
        }
        rows.count = 0;
    }

    // The line in cells: coordinates from their first corners, and where it passes them.
    struct cell_lanes {
        linear_lanes x, y, z;
        floats begin, end;
        floats facing_y, facing_z, steep_y, steep_z; // see `straight_part`
    };

    // Size, angle and place of the sheet in each cell, within which it stays, and the part of the line inside it. Its
    // profile ends at four standard deviations.
    INSONIFY_FN void cross(const cell_lanes& in, const bits& a, const lane_mask<wide_lanes>& holds_sheet,
                           const gain_points& points) const {
        const floats one(1.0F), half(0.5F);
        const bits b = mix_lanes<wide_lanes>(a + 0x51ED270BU);
        const floats half_length = floats(0.375F) * between(a, 8, 0.45F, 1);
        const floats half_width = floats(0.4F * lattice_.cell.y) * between(a, 16, 0.6F, 1);
        const floats angle = between(b, 14, -of_.turn, of_.turn), squared = angle * angle;
        const floats sine = angle * polynomial<wide_lanes>(squared, -1.9841270e-4F, 8.3333333e-3F, -0.16666667F, 1.0F);
        const floats cosine =
            polynomial<wide_lanes>(squared, 2.4801587e-5F, -1.3888889e-3F, 4.1666667e-2F, -0.5F, 1.0F);
        const auto from_centre = [&](const linear_lanes& at, const floats& extent, const floats& random,
                                     const floats& unit) -> linear_lanes {
            const floats e = min(extent, half);
            return {(at.first - multiply_add(one - (e + e), random, e)) * unit, at.step * unit};
        };
        // The bend shares bits with places within the cell, which does not show.
        const floats bend = between(b, 3, -of_.bend, of_.bend), rise = half * half_width * bend; // of its edges
        // So that little of the profile is cut off at the sides of the cell.
        const floats margin = multiply_add(half, abs(rise), floats(1.5F * of_.thickness));
        const floats y_extent = half_width * cosine + margin * abs(sine),
                     z_extent = half_width * abs(sine) + margin * cosine;
        const linear_lanes x = from_centre(in.x, half_length, fraction_of_bits(a, 24, 8), one / half_length),
                           y = from_centre(in.y, y_extent * floats(1 / lattice_.cell.y), fraction_of_bits(b, 0, 7),
                                           floats(lattice_.cell.y)),
                           z = from_centre(in.z, z_extent * floats(1 / lattice_.cell.z), fraction_of_bits(b, 7, 7),
                                           floats(lattice_.cell.z));
        const floats per_width = one / half_width, thicknesses(1 / of_.thickness);
        const linear_lanes across{(y.first * sine + z.first * cosine) * thicknesses,
                                  (y.step * sine + z.step * cosine) * thicknesses},
            within{(y.first * cosine - z.first * sine) * per_width, (y.step * cosine - z.step * sine) * per_width};
        const floats risen = rise * thicknesses, beyond = multiply_add(half, abs(risen), floats(4.0F));
        floats begin = in.begin, end = in.end;
        across.clip(-beyond, beyond, begin, end);
        within.clip(-one, one, begin, end);
        x.clip(-one, one, begin, end);
        const floats per_point(1 / points.spacing);
        // The points of [begin, end): one where two pieces of the line meet, as at a node of the wave, belongs to the
        // second alone.
        const auto first_from = [&](const floats& distance) { // on which points lie, rounded up
            return -floor_bits<wide_lanes>((floats(points.first) - distance) * per_point);
        };
        const bits first = first_from(begin), behind = first_from(end);
        std::uint32_t met =
            bits_of(holds_sheet && begin < end && floats_of<wide_lanes>(first) < floats_of<wide_lanes>(behind));
        if (met == 0) return;

        const floats steps = floats_of<wide_lanes>(((b >> 22) & 31U) + (b >> 27)); // a sum of two, each 0 to 31
        const floats level_number =
            multiply_add(steps, floats(max_level_number / 32), floats(-max_level_number * 31 / 32));
        const floats level = decibels(level_number, of_.spread_db, of_.level_db);
        // The normal of a bent sheet leans against w, the place across it, by the slope w bend: its cosine to the beam
        // is (facing - w bend leaning) / sqrt(1 + (w bend)^2), where fibres are straight.
        const floats facing = sine * in.facing_y + cosine * in.facing_z,
                     leaning = cosine * in.facing_y - sine * in.facing_z,
                     steep = sine * in.steep_y + cosine * in.steep_z,
                     steep_leaning = cosine * in.steep_y - sine * in.steep_z;

        std::uint32_t from[wide_lanes], to[wide_lanes];
        store_bits<wide_lanes>(first, from);
        store_bits<wide_lanes>(behind, to);
        float sheet[13][wide_lanes]; // three coordinates, and the seven values below
        const linear_lanes* const coordinates[] = {&across, &within, &x};
        for (std::size_t k = 0; k < 3; ++k) {
            store(coordinates[k]->first, sheet[2 * k]);
            store(coordinates[k]->step, sheet[2 * k + 1]);
        }
        const floats* const values[] = {&level, &risen, &bend, &facing, &leaning, &steep, &steep_leaning};
        for (std::size_t k = 0; k < 7; ++k) store(*values[k], sheet[6 + k]);
        for (std::uint32_t k = 0; met != 0; ++k, met >>= 1) {
            if ((met & 1U) == 0) continue;
            const auto at = [&](int which, const floats& distance) {
                return multiply_add(distance, floats(sheet[which + 1][k]), floats(sheet[which][k]));
            };
            const auto value = [&](int which) { return floats(sheet[6 + which][k]); };
            const floats zero(0.0F), end_point(static_cast<float>(to[k]));
            for (std::uint32_t i = from[k]; i < to[k] && i < points.count; i += wide_lanes) {
                const floats distance = points.distances(i), w = at(2, distance), l = at(4, distance), ww = w * w,
                             offset = at(0, distance) - value(1) * (ww - half);
                const floats slope = w * value(2), cosine_here = value(3) - slope * value(4),
                             steep_here = value(5) - slope * value(6);
                const floats squared_length = multiply_add(steep_here, steep_here, multiply_add(slope, slope, one));
                const floats turned = (cosine_here * cosine_here / squared_length - one) * floats(per_lobe_);
                const floats echo =
                    multiply_add(power_of_two<wide_lanes>(turned), floats(1 - diffuse_), floats(diffuse_));
                const floats outline = max(one - l * l, zero) * max(one - ww, zero);
                const floats here = gaussian(offset) * sqrt(outline) * echo * value(0);
                const auto inside = whole_numbers(i) < end_point;
                store(load<wide_lanes>(points.gain + i) + select(inside, here, zero), points.gain + i);
            }
        }
    }

    const structure::sheet_layer& of_;
    const placed_structure::lattice& lattice_;
    const fibre_course& course_;
    // The normal of a surface on which fibres end.
    struct surface_normal {
        vec3 cells;   // per metre, in coordinates of the lattice
        vec2 across;  // its components along axes 1 and 2
        float facing; // along the propagation of sound
    };

    linear_along place_[3]; // coordinates in cells
    std::uint32_t key_;
    float per_lobe_, diffuse_;
    vec2 facing_; // components of the propagation of sound along axes 1 and 2
    surface_normal normals_[2];
};

/// Distance of points between which the gains of a structure are as good as linear, metres: less than the thickness of
/// sheets.
INSONIFY_FN inline float gain_spacing(const structure& of) {
    float smallest = 0.16e-3F;
    for (const structure::sheet_layer* layer : {&of.sheets, &of.septa})
        if (layer->fill > 0) smallest = min(smallest, layer->thickness);
    return 0.85F * max(smallest, 0.03e-3F);
}

/// Factors on the amplitude of speckle along a straight segment of a line in an object: see `structure`. Not
/// normalised: `placed_structure::rms` is their rms value.
class structure_gains {
    using floats = wide_floats;
    using bits = wide_bits;

  public:
    INSONIFY_FN structure_gains(const placed_structure& tissue, const object_segment& segment,
                                const fibre_course& course = {})
        : tissue_{tissue}, segment_{segment}, course_{course} {}

    /// Computes the gains at points.
    INSONIFY_FN void compute(const gain_points& points) const {
        const structure& of = tissue_.of;
        const auto evaluate = [&](line_nodes& nodes, float apart, const auto& field) {
            nodes.evaluate(points.first, points.last(), max(apart, 4 * points.spacing), segment_.place(), field);
        };
        line_nodes mottling, grain, waves;
        const auto vary = [&](line_nodes& nodes, const structure::variation& v, std::uint32_t number) {
            if (v.deviation_db == 0) return;
            const float shortest = min(v.size.x, min(v.size.y, v.size.z));
            evaluate(nodes, 0.5F * shortest,
                     [&](const floats& distance) { return decibels(noise(v.size, number, distance), v.deviation_db); });
        };
        vary(mottling, of.mottling, 1);
        vary(grain, of.grain, 2);
        evaluate(waves, of.wave > 0 ? 0.5F * of.wave_length : 1.0F, [&](const floats& distance) {
            return of.wave > 0 ? noise(of.wave_length * vec3{1, 0.6F, 0.6F}, 3, distance) * floats(of.wave)
                               : floats(0.0F);
        });
        for (std::uint32_t i = 0; i < points.count; i += wide_lanes) {
            const float here = points.distance(i);
            floats between = of.grain.deviation_db == 0 ? floats(1.0F) : grain.at(here, points.spacing);
            if (of.bundles.spacing > 0)
                between = between * bundles(points.distances(i), waves.at(here, points.spacing));
            store(between, points.gain + i);
        }
        // Registers of sheets begin at any point, and reach beyond the last.
        store(floats(0.0F), points.gain + points.count);
        for (const placed_structure::sheets& all : tissue_.layers)
            for (std::uint32_t k = 0; k < all.count; ++k)
                sheet_crossings{all, k, segment_, course_, lobe_of(all.of.waviness, segment_.fnumber)}.add(waves,
                                                                                                           points);
        if (of.mottling.deviation_db == 0) return;
        for (std::uint32_t i = 0; i < points.count; i += wide_lanes)
            store(load<wide_lanes>(points.gain + i) * mottling.at(points.distance(i), points.spacing), points.gain + i);
    }

    /// Multiplies `count` complex amplitudes, at equal steps from a distance on; distances never decrease. The gains
    /// are computed as far ahead as there is room for. The arrays have room for whole registers.
    INSONIFY_FN void multiply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        for (std::uint32_t i = 0; i < count; i += wide_lanes) {
            const floats gain = at(first + static_cast<float>(i) * step, step);
            store(load<wide_lanes>(real + i) * gain, real + i);
            store(load<wide_lanes>(imaginary + i) * gain, imaginary + i);
        }
    }

  private:
    INSONIFY_FN floats noise(vec3 size, std::uint32_t number, const floats& distance) const {
        return segment_.noise(tissue_.axes, size, segment_.key + number, distance, course_);
    }

    // 1 between the bundles, their level inside.
    INSONIFY_FN INSONIFY_INLINE floats bundles(const floats& distance, const floats& aside) const {
        constexpr float edge = 0.15F; // of the spacing
        const structure::bundle_layer& of = tissue_.of.bundles;
        const auto place = [&](int i) { return segment_.coordinate(tissue_.axes[i], of.spacing).at(distance); };
        const floats z = place(2) + aside * floats(1 / of.spacing);
        const bits layer = floor_bits<wide_lanes>(z),
                   row_bits = mix_lanes<wide_lanes>(layer * 0x9E3779B9U + segment_.key);
        const floats y = place(1) + aside * floats(0.7F / of.spacing) +
                         fraction_of_bits(row_bits, 0, 16); // each row by itself, or bundles would be in columns
        const bits row = floor_bits<wide_lanes>(y);
        const bits random =
            mix_lanes<wide_lanes>(row * 0x85EBCA6BU + layer * 0xC2B2AE35U + (segment_.key ^ 0x2545F491U));
        const floats radius = floats(0.5F * of.diameter / of.spacing) * between(random, 0, 0.6F, 1);
        const auto from_centre = [&](const floats& at, const bits& cell, int shift) {
            return at - floats_of<wide_lanes>(cell) -
                   multiply_add(floats(1.0F) - (radius + radius), fraction_of_bits(random, shift, 8), radius);
        };
        const floats dy = from_centre(y, row, 8), dz = from_centre(z, layer, 16);
        const floats outside = (sqrt(dy * dy + dz * dz) - radius) * floats(1 / edge);
        const floats inside = min(max(floats(0.5F) - outside, floats(0.0F)), floats(1.0F));
        return multiply_add(inside, floats(amplitude_of_decibels(of.level_db) - 1), floats(1.0F));
    }

    // At a register full of distances.
    INSONIFY_FN INSONIFY_INLINE floats at(float distance, float step) {
        const float end = max(segment_.length, distance) + 2 * step; // slabs overlap by a step
        const float last = min(distance + (wide_lanes - 1) * step, end);
        if (count_ == 0 || (last - begin_) * per_point_ > static_cast<float>(count_ - 2))
            fill(distance - 2 * step, end);
        return interpolate(gain_, count_, (distance - begin_) * per_point_, step * per_point_);
    }
    // From the last point before a distance on. Points lie at whole multiples of their distance in the material.
    INSONIFY_FN void fill(float from, float to) {
        const float spacing = gain_spacing(tissue_.of), origin = segment_.place();
        per_point_ = 1 / spacing;
        begin_ = min(std::floor((origin + from) * per_point_) * spacing - origin, from);
        count_ = static_cast<std::uint32_t>(min((to - begin_) * per_point_ + 3, static_cast<float>(max_points)));
        compute({begin_, spacing, count_, gain_});
    }

    static constexpr std::uint32_t max_points = 256; // at a time

    const placed_structure& tissue_;
    object_segment segment_;
    fibre_course course_;
    float begin_ = 0, per_point_ = 1; // of the points
    std::uint32_t count_ = 0;
    float gain_[max_points + wide_lanes];
};

/// Factors on the amplitude of speckle in the sheath of an object, below one surface of a segment of a line: see
/// `structure::sheath_layer`.
class sheath_gains {
    using floats = wide_floats;

  public:
    /// @param surface    distance of the surface, metres from the origin of the segment
    /// @param cosine     of the angle of incidence on it; negative where the line leaves the object, 0: no sheath
    /// @param max_range  length of the line that the sheath may take, metres: to the middle of a thin object, where it
    ///                   meets the sheath of the surface on the other side
    INSONIFY_FN sheath_gains(const structure::sheath_layer& of, const object_segment& segment, float surface,
                             float cosine, float max_range)
        : of_{of}, segment_{segment}, surface_{surface}, cosine_{cosine} {
        if (!(of.thickness > 0) || cosine == 0) return;
        range_ = min(2 * of.thickness / max(std::fabs(cosine), 1e-3F), max_range);
        begin_ = max(cosine > 0 ? surface : surface - range_, 0);
        end_ = min(cosine > 0 ? surface + range_ : surface, segment.length);
        if (begin_ < end_) prepare();
    }

    /// Multiplies complex amplitudes at equal steps from a distance on; metres from the origin of the segment. The
    /// arrays have room for whole registers.
    INSONIFY_FN void multiply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        const auto slot = [&](float distance) {
            return static_cast<std::uint32_t>(clamp((distance - first) / step, 0, static_cast<float>(count)));
        };
        if (!(begin_ < end_)) return;
        const std::uint32_t from = slot(begin_) / wide_lanes * wide_lanes,
                            to = slot(end_ + 1.5F * step); // past the slot that the end cuts
        if (from >= to) return;
        const floats per_width(1 / min(0.12e-3F / of_.thickness, 0.25F)); // standard deviation of a line
        for (std::uint32_t i = from; i < to; i += wide_lanes) {
            const float here = first + static_cast<float>(i) * step;
            const floats distance = floats(here - surface_) + whole_numbers(0) * floats(step);
            const floats within = distance * floats(cosine_ / of_.thickness) / thickness_.at(here, step);
            const auto line = [&](float place) { return gaussian((within - floats(place)) * per_width); };
            const floats both = multiply_add(line(0.85F), other_.at(here, step), line(0.1F)), one(1.0F);
            const floats gain =
                select(abs(distance) < floats(range_), multiply_add(level_.at(here, step), both, one), one);
            store(load<wide_lanes>(real + i) * gain, real + i);
            store(load<wide_lanes>(imaginary + i) * gain, imaginary + i);
        }
    }

  private:
    INSONIFY_FN void prepare() {
        const auto evaluate = [&](line_nodes& nodes, float size, std::uint32_t number, float factor, float offset) {
            nodes.evaluate(begin_, end_, 0.2F * size, segment_.place(), [&](const floats& distance) {
                const floats noise =
                    segment_.noise(mat3{1}, vec3{size}, segment_.key ^ (number * 0x632BE5ABU), distance);
                return power_of_two<wide_lanes>(multiply_add(noise, floats(factor), floats(offset)));
            });
        };
        const float sine_squared = 1 - min(cosine_ * cosine_, 1), diffuse = amplitude_of_decibels(of_.diffuse_db);
        const float lobe = lobe_of(of_.waviness, segment_.fnumber);
        const float echo = diffuse + (1 - diffuse) * std::exp2(-sine_squared / (lobe * lobe));
        evaluate(thickness_, 6e-3F, 1, 0.3F, 0);
        evaluate(level_, 5e-3F, 2, bits_per_decibel * of_.spread_db,
                 bits_per_decibel * of_.level_db + std::log2(max(echo, 1e-12F)));
        evaluate(other_, 5e-3F, 3, 2, -1.5F);
    }

    const structure::sheath_layer& of_;
    const object_segment& segment_;
    float surface_, cosine_;
    float range_ = 0;           // length of the sheath, metres along the line
    float begin_ = 0, end_ = 0; // of it, metres from the origin
    // Thickness relative to the mean; amplitude of the first line, and of the other relative to it.
    line_nodes thickness_, level_, other_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
