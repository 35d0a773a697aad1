#ifndef INSONIFY_ACOUSTICS_SCATTERERS_CELL_LAYOUT_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_CELL_LAYOUT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/scatterers/scatter_numbers.hpp>
#include <insonify/acoustics/scatterers/scattering.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/simd.hpp>

/// The grid of a `cell_field` is fine along the viewing direction and coarse across it. Grids exist for a lattice of
/// directions; each line uses, slab by slab, a random one of the four around its own. Thus speckle persists while a
/// probe turns a little, and decorrelates gradually as it turns further.
namespace insonify::inline INSONIFY_ABI::detail {

/// Lattice directions lie on the six faces of a cube, an eighth of half an edge apart: 7 degrees in the middle of a
/// face.
inline constexpr float view_steps = 8;

/// Probability that two lines at this angle, radians, choose the same direction in a slab. Exact in the middle of a
/// face; an upper bound towards the edges of the cube, where directions are closer.
INSONIFY_FN inline float same_view_probability(float angle) { return max(0, 1 - view_steps * std::fabs(angle)); }

/// One of the four lattice directions around `towards`, chosen with bilinear weights: its mean is `towards`.
/// @param towards  not 0
/// @param bits     32 random bits
/// @return         whole numbers from -view_steps to view_steps; for the opposite direction, the opposite
INSONIFY_FN inline vec3 lattice_direction(vec3 towards, std::uint32_t bits) {
    const vec3 size = abs(towards);
    const float scale = view_steps / max(max(size.x, size.y), size.z);
    const auto rounded = [&](float coordinate, std::uint32_t random) { // the largest is a whole number already
        const float fraction = (static_cast<float>(random & 0x3FFU) + 0.5F) * 0x1p-10F;
        return std::copysign(std::floor(std::fabs(coordinate) * scale + fraction), coordinate);
    };
    return {rounded(towards.x, bits), rounded(towards.y, bits >> 10U), rounded(towards.z, bits >> 20U)};
}

/// A number for each lattice direction.
INSONIFY_FN inline std::uint32_t lattice_index(vec3 direction) {
    const auto digit = [](float coordinate) {
        return static_cast<std::uint32_t>(static_cast<std::int32_t>(coordinate) + 64);
    };
    return (digit(direction.x) << 16U) + (digit(direction.y) << 8U) + digit(direction.z);
}

/// Parallel oblique slabs that fill space; the view direction is chosen once for each.
struct view_slabs {
    static constexpr float thickness = 2e-3F; ///< metres

    /// Position of a point in slabs; its floor is the index of the slab.
    INSONIFY_FN static float position(vec3 point) { return dot(point, vec3{0.48F, 0.6F, 0.64F}) / thickness; }
};

/// A straight segment of a line in the undeformed material.
struct rest_line {
    vec3 origin{0, 0, 0};    ///< metres
    vec3 along{0, 0, 1};     ///< metres of material per metre of the line
    vec3 elevation{0, 1, 0}; ///< metres of material per metre out of the slice plane
    vec3 lateral{1, 0, 0};   ///< metres of material per metre across the line in the slice plane
    vec3 steering{0, 0, 0};  ///< see `line_frame::steering`
};

/// The normal of the slots of a segment that deformation shears out of the slice plane: slots lie in wave fronts there, since
/// no other lines show how echoes change out of the plane, and their phase must follow what moves in that direction.
/// @param normal  along the line, of tissue that is not sheared
/// @return        no more than 60 degrees from it, so that the line traverses the slots
INSONIFY_FN inline vec3 sheared_normal(vec3 normal, vec3 elevation) {
    const float size = dot(elevation, elevation);
    const vec3 sheared = size > 0 ? normal - (dot(normal, elevation) / size) * elevation : normal;
    if (4 * dot(sheared, sheared) >= dot(normal, normal)) return sheared;
    constexpr float steepest = 1.732F; // tan 60 degrees
    const vec3 forward = normalize(normal), aside = sheared - dot(sheared, forward) * forward;
    return dot(aside, aside) > 0 ? forward + steepest * normalize(aside) : forward;
}

/// The slots and cells that one segment of a line traverses.
struct cell_layout {
    double slot = 0;             ///< at the origin of the segment
    double slots_per_metre = 1;  ///< of the line
    vec2 across{0, 0};           ///< position of the origin in the slice plane and out of it, in cells
    vec2 across_per_slot{0, 0};  ///< its change from slot to slot, in cells
    std::uint32_t key = 0;       ///< hash of seed, object and layout direction
    float volume = 0;            ///< of a cell, m^3
    float scatterer_density = 0; ///< of the medium, per m^3
    vec2 slope{0, 0};            ///< see `scatterer_run`
    float level = 1;             ///< root of the slots' length along the segment over their spacing
    /// Phase over the height of a cell: rms over the slots, turns, at the origin; and its change from slot to slot.
    vec2 turns{0, 0};

    /// Sets `turns` for a segment that begins at a distance along the line, metres.
    INSONIFY_FN void set_phase_spread(const material_line& line, float begin) {
        constexpr float ahead = 2e-3F;
        const float first = line.phase_spread(begin), last = line.phase_spread(begin + ahead);
        const auto per_slot = static_cast<float>(1 / (static_cast<double>(ahead) * slots_per_metre));
        turns = vec2{first, (last - first) * per_slot} * (line.height / (2 * pi));
    }

    /// Values of N consecutive slots, interpolated between the four cells around the line: linearly out of the slice plane,
    /// and in it linearly too, or so that the field has the spectrum of white noise, as far as a beam can tell.
    /// @tparam Linear     whether linearly
    /// @param first_slot  index of the first slot
    /// @param offset      slots from the origin to the centre of each
    /// @param numbers     the contents of the cells, such as `gaussian_numbers`
    template <int N, bool Linear = false, class Numbers>
    INSONIFY_FN INSONIFY_INLINE detail::complex_lanes<N> values(std::uint32_t first_slot, const lanes<N>& offset,
                                                                const Numbers& numbers) const {
        using floats = lanes<N>;
        using bits = bit_lanes<N>;
        constexpr std::uint32_t next_column = 0x85EBCA6BU, next_row = 0xC2B2AE35U;
        // Its upper and its lower half displace the cells of each slot. From slot to slot the upper one grows by the golden
        // section, so that the few slots of a pulse cut cells in places that are spread evenly.
        const bits slot_hash = steps_of_bits<N>(key + first_slot * 0x9E3779B9U, 0x9E3779B9U);
        const floats one(1.0F), to_cells(0x1p-16F);
        const floats x =
            floats(across.x) + offset * floats(across_per_slot.x) + floats_of<N>(slot_hash >> 16) * to_cells;
        const floats y =
            floats(across.y) + offset * floats(across_per_slot.y) + floats_of<N>(slot_hash & 0xFFFFU) * to_cells;
        const bits column = floor_bits<N>(x), row = floor_bits<N>(y);
        const floats past_column = x - floats_of<N>(column), upper = y - floats_of<N>(row), lower = one - upper;
        const floats left = lateral_weight<N, Linear>(past_column),
                     right = lateral_weight<N, Linear>(one - past_column);
        const bits index = slot_hash + column * next_column + row * next_row + 0x51ED270BU;
        const detail::complex_lanes<N> a = numbers.template operator()<N>(index, volume, scatterer_density),
                                       b = numbers.template operator()<N>(index + next_column, volume,
                                                                          scatterer_density),
                                       c = numbers.template operator()<N>(index + next_row, volume, scatterer_density),
                                       d = numbers.template operator()<N>(index + (next_column + next_row), volume,
                                                                          scatterer_density);
        const floats scale = (Linear ? unit_power_scale<N>(past_column) : floats(level)) * unit_power_scale<N>(upper);
        const auto row_of = [&](const detail::complex_lanes<N>& at_left, const detail::complex_lanes<N>& at_right,
                                const floats& weight) {
            return detail::complex_lanes<N>{weight * (left * at_left.real + right * at_right.real),
                                            weight * (left * at_left.imaginary + right * at_right.imaginary)};
        };
        detail::complex_lanes<N> one_row = row_of(a, b, lower), next = row_of(c, d, upper);
        if (!Linear && (turns.x != 0 || turns.y != 0)) {
            // Phases of rms 1 whose mean of cos(q x) is exp(-x^2 / 2) within 0.02: a normal distribution's, from uniform numbers.
            const floats uniform = floats_of<N>(slot_hash >> 16) * floats(0x1p-15F) - one, squared = uniform * uniform;
            const floats spread = max(floats(turns.x) + offset * floats(turns.y), floats(0.0F)) * uniform *
                                  polynomial<N>(squared * squared, 1.11F, 1.2243671F);
            one_row = turned<N>(one_row, upper * spread);
            next = turned<N>(next, floats(0.0F) - lower * spread);
        }
        return {(one_row.real + next.real) * scale, (one_row.imaginary + next.imaginary) * scale};
    }

  private:
    // Keeps the power of linear interpolation: 1 / sqrt(w^2 + (1 - w)^2) = sqrt(2 / (1 + u)), u = (2 w - 1)^2, as a
    // polynomial in u within 1e-4.
    template <int N>
    INSONIFY_FN INSONIFY_INLINE static lanes<N> unit_power_scale(const lanes<N>& weight) {
        const lanes<N> twice = weight + weight - lanes<N>(1.0F);
        return polynomial<N>(twice * twice, 0.070276911F, -0.26038293F, 0.47710252F, -0.70102729F, 1.4140941F);
    }

    // A number times exp(2 pi j turns), by the half angle within a quarter turn, to 5e-5.
    template <int N>
    INSONIFY_FN INSONIFY_INLINE static detail::complex_lanes<N> turned(const detail::complex_lanes<N>& value,
                                                                       const lanes<N>& turns) {
        const lanes<N> part = turns - floats_of<N>(floor_bits<N>(turns + lanes<N>(0.5F))), squared = part * part;
        const lanes<N> sine =
                           part * polynomial<N>(squared, 0.0821459F, -0.5992645F, 2.5501640F, -5.1677128F, 3.1415927F),
                       cosine = polynomial<N>(squared, 0.2353306F, -1.3352628F, 4.0587121F, -4.9348022F, 1.0F);
        const lanes<N> x = cosine * cosine - sine * sine, y = (sine + sine) * cosine;
        return {value.real * x - value.imaginary * y, value.real * y + value.imaginary * x};
    }

    // Weight of a cell at a lateral distance of 0 to 1 cells from its centre: 1.26 (1 - d^2) (1 - 7/3 d^2), of mean power 1
    // and without a second moment. Positive weights would smooth the field, and speckle would be wider than the beam.
    template <int N, bool Linear>
    INSONIFY_FN INSONIFY_INLINE static lanes<N> lateral_weight(const lanes<N>& distance) {
        if constexpr (Linear) return lanes<N>(1.0F) - distance;
        const lanes<N> squared = distance * distance;
        return polynomial<N>(squared, 2.9348392F, -4.1926275F, 1.2577882F);
    }
};

/// The layout of cells for one segment of a line in one slab.
/// @param cell     size of a cell in the slice plane, metres; out of it, it is as high as the line's tissue
/// @param spacing  length of a slot, metres
INSONIFY_FN inline cell_layout make_cell_layout(std::uint32_t seed, float cell, const material_line& line,
                                                const rest_line& segment, double slab, float spacing) {
    const std::uint32_t object_hash =
        mix_bits(seed * 0x9E3779B9U + line.object + line.plane * 0x85EBCA6BU + line.frame_number * 0xC2B2AE35U);
    const auto slab_index = static_cast<std::uint32_t>(static_cast<std::int64_t>(slab));
    const std::uint32_t random = mix_bits(object_hash + slab_index * 0x9E3779B9U);
    // The axes of the grid: along the line and along its elevation, whose sign does not matter. Steered lines
    // use the grid of straight ones, so that the looks of a compounded image see the same scatterers.
    const vec3 along = segment.along - line.tilt * segment.elevation - segment.steering,
               normal = line.displacement != nullptr ? sheared_normal(along, segment.elevation) : along;
    const vec3 towards = lattice_direction(normal, random), view = normalize(towards);
    const vec3 chosen = lattice_direction(segment.elevation, mix_bits(random + 1));
    const bool down = chosen.x != 0 ? chosen.x < 0 : chosen.y != 0 ? chosen.y < 0 : chosen.z < 0;
    const vec3 upwards = down ? -chosen : chosen;
    const vec3 upright = upwards - dot(upwards, view) * view;
    const vec3 up = dot(upright, upright) > 1 ? normalize(upright) : orthonormal_basis{view}.second;
    const vec3 right = cross(up, view);
    const vec2 to_cells{1 / cell, 1 / (line.height > 0 ? line.height : cell)};
    const float advance = dot(segment.along, view);
    cell_layout cells;
    cells.slot = static_cast<double>(dot(segment.origin, view)) / spacing;
    cells.slots_per_metre = static_cast<double>(advance) / spacing;
    cells.across = vec2{dot(segment.origin, right), dot(segment.origin, up)} * to_cells;
    cells.across_per_slot = vec2{dot(segment.along, right), dot(segment.along, up)} * to_cells * (spacing / advance);
    cells.key = mix_bits(mix_bits(object_hash ^ lattice_index(towards)) ^ lattice_index(upwards));
    cells.volume = spacing / (to_cells.x * to_cells.y);
    cells.scatterer_density = line.scatterer_density;
    cells.level = std::sqrt(length(segment.along) / advance);
    cells.slope = vec2{dot(segment.lateral, view), dot(segment.elevation, view)} / -advance;
    return cells;
}

/// The point itself, or the origin for points so far away (about 100 km) that floats do not resolve the cells, or that
/// integers do not count the slots.
INSONIFY_FN inline vec3 resolvable(vec3 point, float cell, float spacing) {
    const vec3 size = abs(point);
    const float max_coordinate = min(0x1p29F * min(cell, 1e-3F), 0x1p50F * spacing);
    return size.x < max_coordinate && size.y < max_coordinate && size.z < max_coordinate ? point : vec3{0, 0, 0};
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
