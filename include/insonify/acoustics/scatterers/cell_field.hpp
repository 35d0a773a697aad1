#ifndef INSONIFY_ACOUSTICS_SCATTERERS_CELL_FIELD_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_CELL_FIELD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/scatterers/scattering.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/tissue/structure_gains.hpp>
#include <cfloat>
#include <cmath>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// The contents of cells of a `cell_field`: one complex random number per lane, of mean power 1, computed from an
/// index.
template <int N>
struct complex_lanes {
    lanes<N> real{};      ///< real parts
    lanes<N> imaginary{}; ///< imaginary parts
};

} // namespace detail

/// Fully developed speckle: many scatterers per resolution cell, whose sum is complex Gaussian and whose envelope is
/// Rayleigh distributed.
/// Source: Goodman, Speckle Phenomena in Optics, 2007, chapter 3.
struct gaussian_numbers {
    /// @param index  hashes of the cells
    template <int N>
    INSONIFY_FN INSONIFY_INLINE detail::complex_lanes<N> operator()(const bit_lanes<N>& index, float, float) const {
        // Each part is the sum of four uniform 4-bit numbers, with mean 0 and variance 1/2; interpolation and
        // convolution make the distribution Gaussian. Both sums are computed at once, in the halves of a word.
        constexpr float scale = 0.076696499F; // sqrt(1/2) / sqrt(4 (16^2 - 1) / 12)
        constexpr std::uint32_t nibbles = 0x0F0F0F0FU, bytes = 0x00FF00FFU;
        const bit_lanes<N> bits = mix_lanes<N>(index), pairs = (bits & nibbles) + ((bits >> 4) & nibbles),
                           sums = (pairs & bytes) + ((pairs >> 8) & bytes);
        const auto part = [&](const bit_lanes<N>& sum) {
            return multiply_add(floats_of<N>(sum), lanes<N>(scale), lanes<N>(-30 * scale));
        };
        return {part(sums & 0xFFFFU), part(sums >> 16)};
    }

    friend bool operator==(const gaussian_numbers&, const gaussian_numbers&) = default;
};

/// Sparse speckle: a Poisson distributed number of scatterers per cell, with normally distributed amplitude and
/// uniformly distributed phase.
///
///     (A_1 exp(j theta_1) + ... + A_n exp(j theta_n)) / sqrt(mean),   n ~ Poisson(mean),   mean = density * volume
///
/// density is in 1/m^3, volume that of a cell in m^3; the A are standard normal, so the mean power is 1.
/// Source: a marked Poisson process; Wagner et al., "Statistics of speckle in ultrasound B-scans", 1983.
struct poisson_numbers {
    float density = 20e9F; ///< scatterers per m^3 in media without `scatterer_density`; 20 per mm^3

    /// @throws usage_error  if `density` is out of range
    void check() const {
        if (!is_finite(density) || !(density > 0))
            throw usage_error{
                "poisson_numbers: `density` must be a finite number above 0; use `no_scatterers` for no speckle"};
    }

    /// @param index              hashes of the cells
    /// @param volume             of a cell, m^3
    /// @param scatterer_density  of the medium, per m^3; 0: `density`
    template <int N>
    INSONIFY_FN detail::complex_lanes<N> operator()(const bit_lanes<N>& index, float volume,
                                                    float scatterer_density) const {
        const float mean = (scatterer_density > 0 ? scatterer_density : density) * volume;
        if (mean > 32) return gaussian_numbers{}.operator()<N>(index, volume, scatterer_density); // indistinguishable
        std::uint32_t each[N];
        store_bits<N>(index, each);
        float real[N], imaginary[N];
        for (int i = 0; i < N; ++i) {
            const vec2 sum = cell_sum(each[i], mean);
            real[i] = sum.x;
            imaginary[i] = sum.y;
        }
        return {load<N>(real), load<N>(imaginary)};
    }

    friend bool operator==(const poisson_numbers&, const poisson_numbers&) = default;

  private:
    // Sum of the scatterers of one cell; their number by inversion of the cumulative distribution.
    INSONIFY_FN static vec2 cell_sum(std::uint32_t index, float mean) {
        const float uniform = static_cast<float>(mix_bits(index) >> 8U) * 0x1p-24F;
        float probability = std::exp(-mean), cumulative = probability; // of 0 scatterers
        vec2 sum{0, 0};
        for (std::uint32_t count = 1; uniform >= cumulative && count < 64; ++count) {
            const float angle = 2 * pi * static_cast<float>(mix_bits(index + count * 0x632BE5ABU) >> 8U) * 0x1p-24F;
            sum += hash_normal(index, count).x * vec2{std::cos(angle), std::sin(angle)};
            probability *= mean / static_cast<float>(count);
            cumulative += probability;
        }
        return sum / std::sqrt(mean);
    }
};

namespace detail {

/// The grid of a `cell_field` is fine along the viewing direction and coarse across it. Each line uses, slab by slab, a
/// random one of the four lattice directions around its own, so that speckle decorrelates gradually as a probe turns.
/// They lie on the six faces of a cube, an eighth of half an edge apart: 7 degrees in the middle of a face.
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

/// Position of a point in parallel oblique slabs of 2 mm that fill space; its floor is the index of its slab. The view
/// direction is chosen once for each.
INSONIFY_FN inline double slab_position(vec3 point) {
    return static_cast<double>(dot(point, vec3{0.48F, 0.6F, 0.64F}) / 2e-3F);
}

/// A straight segment of a line in the undeformed material.
struct rest_line : material_line {
    vec3 lateral{1, 0, 0}; ///< metres of material per metre across the line in the slice plane

    template <class Turned>
    INSONIFY_FN void turn(const Turned& turned) {
        for (vec3* each : {&along, &elevation, &lateral, &steering, &own_begin.normal, &own_end.normal})
            *each = turned(*each);
    }
};

/// The normal of the slots of a segment that deformation shears out of the slice plane: slots lie in wave fronts there,
/// so that their phase follows what moves in that direction.
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

    /// Values of N consecutive slots, interpolated between the four cells around the line: linearly out of the slice
    /// plane, and in it linearly too, or so that the field has the spectrum of white noise, as far as a beam can tell.
    /// @tparam Linear     whether linearly
    /// @param first_slot  index of the first slot
    /// @param offset      slots from the origin to the centre of each
    /// @param numbers     the contents of the cells, such as `gaussian_numbers`
    template <int N, bool Linear = false, class Numbers>
    INSONIFY_FN INSONIFY_INLINE complex_lanes<N> values(std::uint32_t first_slot, const lanes<N>& offset,
                                                        const Numbers& numbers) const {
        using floats = lanes<N>;
        using bits = bit_lanes<N>;
        constexpr std::uint32_t next_column = 0x85EBCA6BU, next_row = 0xC2B2AE35U;
        // Its upper and its lower half displace the cells of each slot. From slot to slot the upper one grows by the
        // golden section, so that the few slots of a pulse cut cells in places that are spread evenly.
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
        const floats scale = (Linear ? unit_power_scale<N>(past_column) : floats(level)) * unit_power_scale<N>(upper);
        const auto row_of = [&](std::uint32_t cells, const floats& weight) {
            const auto number = [&](std::uint32_t cell) {
                return numbers.template operator()<N>(index + (cells + cell), volume, scatterer_density);
            };
            const complex_lanes<N> at_left = number(0), at_right = number(next_column);
            return complex_lanes<N>{weight * (left * at_left.real + right * at_right.real),
                                    weight * (left * at_left.imaginary + right * at_right.imaginary)};
        };
        complex_lanes<N> one_row = row_of(0, lower), next = row_of(next_row, upper);
        if (!Linear && (turns.x != 0 || turns.y != 0)) {
            // Phases of rms 1 whose mean of cos(q x) is exp(-x^2 / 2) within 0.02: a normal distribution's, from
            // uniform numbers.
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
    INSONIFY_FN INSONIFY_INLINE static complex_lanes<N> turned(const complex_lanes<N>& value, const lanes<N>& turns) {
        const lanes<N> part = turns - floats_of<N>(floor_bits<N>(turns + lanes<N>(0.5F))), squared = part * part;
        const lanes<N> sine =
                           part * polynomial<N>(squared, 0.0821459F, -0.5992645F, 2.5501640F, -5.1677128F, 3.1415927F),
                       cosine = polynomial<N>(squared, 0.2353306F, -1.3352628F, 4.0587121F, -4.9348022F, 1.0F);
        const lanes<N> x = cosine * cosine - sine * sine, y = (sine + sine) * cosine;
        return {value.real * x - value.imaginary * y, value.real * y + value.imaginary * x};
    }

    // Weight of a cell at a lateral distance of 0 to 1 cells from its centre: 1.26 (1 - d^2) (1 - 7/3 d^2), of mean
    // power 1 and without a second moment: positive weights would make speckle wider than the beam.
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
INSONIFY_FN inline cell_layout make_cell_layout(std::uint32_t seed, float cell, const rest_line& line, double slab,
                                                float spacing) {
    const std::uint32_t object_hash =
        mix_bits(seed * 0x9E3779B9U + line.object + line.plane * 0x85EBCA6BU + line.frame_number * 0xC2B2AE35U);
    const auto slab_index = static_cast<std::uint32_t>(static_cast<std::int64_t>(slab));
    const std::uint32_t random = mix_bits(object_hash + slab_index * 0x9E3779B9U);
    // The axes of the grid: along the line and along its elevation, whose sign does not matter. Steered lines
    // use the grid of straight ones, so that the looks of a compounded image see the same scatterers.
    const vec3 along = line.along - line.tilt * line.elevation - line.steering,
               normal = line.displacement != nullptr ? sheared_normal(along, line.elevation) : along;
    const vec3 towards = lattice_direction(normal, random), view = normalize(towards);
    const vec3 chosen = lattice_direction(line.elevation, mix_bits(random + 1));
    const bool down = chosen.x != 0 ? chosen.x < 0 : chosen.y != 0 ? chosen.y < 0 : chosen.z < 0;
    const vec3 upwards = down ? -chosen : chosen;
    const vec3 upright = upwards - dot(upwards, view) * view;
    const vec3 up = dot(upright, upright) > 1 ? normalize(upright) : orthonormal_basis{view}.second;
    const vec3 right = cross(up, view);
    const vec2 to_cells{1 / cell, 1 / (line.height > 0 ? line.height : cell)};
    const float advance = dot(line.along, view);
    cell_layout cells;
    cells.slot = static_cast<double>(dot(line.origin, view)) / spacing;
    cells.slots_per_metre = static_cast<double>(advance) / spacing;
    cells.across = vec2{dot(line.origin, right), dot(line.origin, up)} * to_cells;
    cells.across_per_slot = vec2{dot(line.along, right), dot(line.along, up)} * to_cells * (spacing / advance);
    cells.key = mix_bits(mix_bits(object_hash ^ lattice_index(towards)) ^ lattice_index(upwards));
    cells.volume = spacing / (to_cells.x * to_cells.y);
    cells.scatterer_density = line.scatterer_density;
    cells.level = std::sqrt(length(line.along) / advance);
    cells.slope = vec2{dot(line.lateral, view), dot(line.elevation, view)} / -advance;
    return cells;
}

/// The point itself, or the origin for points so far away (about 100 km) that floats do not resolve the cells, or that
/// integers do not count the slots.
INSONIFY_FN inline vec3 resolvable(vec3 point, float cell, float spacing) {
    const vec3 size = abs(point);
    const float max_coordinate = min(0x1p29F * min(cell, 1e-3F), 0x1p50F * spacing);
    return size.x < max_coordinate && size.y < max_coordinate && size.z < max_coordinate ? point : vec3{0, 0, 0};
}

/// Part of a line as it was at rest, which is curved where tissue is deformed: points at equal steps, of which the last
/// may be up to half a step shorter or longer.
class rest_curve {
  public:
    /// @param begin  metres along the line
    /// @param end    metres along the line; the curve ends before it where it would have too many points
    /// @param chart  in whose coordinates it is; null: those of the object
    INSONIFY_FN rest_curve(const material_line& line, float begin, float end, const fibre_chart* chart)
        : begin_{begin} {
        step_ = line.chart() != nullptr ? of_fibres : FLT_MAX;
        if (line.displacement != nullptr) step_ = min(step_, line.displacement->straight_length);
        step_ /= length(line.along);
        const float steps = (end - begin) / step_;
        last_ = static_cast<std::uint32_t>(clamp(steps + 0.5F, 1, max_steps));
        end_ = steps < static_cast<float>(max_steps) + 0.5F ? end : begin + static_cast<float>(max_steps) * step_;
        for (std::uint32_t i = 0; i <= last_; ++i) {
            const vec3 rest = line.rest(line.at(distance(i)));
            point_[i] = chart == nullptr ? rest : (*chart)(rest);
        }
    }

    INSONIFY_FN std::uint32_t last() const { return last_; }
    /// Of a point, metres along the line.
    INSONIFY_FN float distance(std::uint32_t i) const {
        return i == last_ ? end_ : begin_ + static_cast<float>(i) * step_;
    }
    /// In tissue at rest.
    INSONIFY_FN vec3 point(std::uint32_t i) const { return point_[i]; }
    /// Metres of tissue at rest per metre of the line, from one point straight to another.
    INSONIFY_FN vec3 along(std::uint32_t from, std::uint32_t to) const {
        return (point_[to] - point_[from]) * (1 / (distance(to) - distance(from)));
    }

    /// The end of a straight piece from a point on: no point of the curve between is further from it than `tolerance`,
    /// metres.
    /// @param largest  the last point that it may reach
    INSONIFY_FN std::uint32_t straight_until(std::uint32_t from, std::uint32_t largest, float tolerance) const {
        std::uint32_t to = from + 1;
        while (to < largest && is_straight(from, to + 1, tolerance)) ++to;
        return to;
    }

  private:
    static constexpr std::uint32_t max_steps = 32;
    static constexpr float of_fibres = 2e-3F; // metres over which fibres count as straight

    INSONIFY_FN bool is_straight(std::uint32_t from, std::uint32_t to, float tolerance) const {
        const vec3 step = along(from, to);
        for (std::uint32_t i = from + 1; i < to; ++i) {
            const vec3 aside = point_[i] - point_[from] - (distance(i) - distance(from)) * step;
            if (dot(aside, aside) > tolerance * tolerance) return false;
        }
        return true;
    }

    float begin_, step_ = 1, end_ = 0; // metres along the line
    std::uint32_t last_ = 0;
    vec3 point_[max_steps + 1];
};

/// What the structure of its medium does to the speckle along one straight segment of a line.
class structured_line {
  public:
    /// @param line        the segment, in a medium that has a structure
    /// @param begin, end  of the segment, metres along the line
    INSONIFY_FN structured_line(const rest_line& line, float begin, float end, std::uint32_t key)
        : begin_{begin}, segment_{.origin = line.origin,
                                  .along = line.along,
                                  .propagation = normalize(line.along - line.tilt * line.elevation),
                                  .fnumber = line.fnumber,
                                  .key = key,
                                  .length = end - begin},
          gains_{*line.structure, segment_, course_of(line)}, behind_entry_{sheath_at(line, line.surfaces.x,
                                                                                      line.own_begin.cosine)},
          before_exit_{sheath_at(line, line.surfaces.y, -line.own_end.cosine)} {}
    structured_line(const structured_line&) = delete;

    /// Multiplies `count` complex amplitudes, at equal steps from a distance on, metres along the line; distances never
    /// decrease. The arrays have room for whole registers.
    INSONIFY_FN void multiply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        gains_.multiply(first - begin_, step, count, real, imaginary);
        behind_entry_.multiply(first - begin_, step, count, real, imaginary);
        before_exit_.multiply(first - begin_, step, count, real, imaginary);
    }

  private:
    // Length of the line that belongs to each of its surfaces, metres: to the middle of a thin object.
    INSONIFY_FN static float max_range(const rest_line& line) {
        const bool both_own = line.own_begin.cosine != 0 && line.own_end.cosine != 0;
        return both_own ? 0.5F * (line.surfaces.y - line.surfaces.x) : FLT_MAX;
    }
    INSONIFY_FN sheath_gains sheath_at(const rest_line& line, float surface, float cosine) const {
        return {line.structure->of.sheath, segment_, surface - begin_, cosine, max_range(line)};
    }
    INSONIFY_FN fibre_course course_of(const rest_line& line) const {
        const structure::sheath_layer& sheath = line.structure->of.sheath;
        if (sheath.insertion == 0) return {};
        // A fibre at an angle a to the surface curves over its last `insertion` metres, from D = insertion / 2 sin a
        // on.
        const auto insertion = [&](float surface, float cosine, vec3 normal) -> fibre_insertion {
            if (cosine == 0) return {};
            constexpr float of_half = 0.4F; // of a thin object, so that fibres remain between both ends
            const float half = std::fabs(cosine) * max_range(line), above = min(sheath.thickness, of_half * half);
            const float sine = std::fabs(dot(line.structure->axes[0], normal));
            return {dot(normal, line.along) * cosine < 0 ? normal : -normal, surface - begin_ + above / cosine, cosine,
                    min(0.5F * sheath.insertion * sine, half - above)};
        };
        return {insertion(line.surfaces.x, line.own_begin.cosine, line.own_begin.normal),
                insertion(line.surfaces.y, -line.own_end.cosine, line.own_end.normal)};
    }

    float begin_; // metres along the line
    object_segment segment_;
    structure_gains gains_;
    sheath_gains behind_entry_, before_exit_;
};

} // namespace detail

/// A random scatterer field on a grid that is fixed in the material, so that speckle moves with the tissue.
///
/// Along the line the grid consists of slots, each with one scatterer; across the line it consists of cells, with
/// interpolation between them. The cells of each slot are displaced at random, so no line spacing coincides with their
/// period. The grid is aligned with one of a fixed set of directions, close to that of the line.
/// Source: the convolution model of speckle, Bamber & Dickinson 1980; the grid is the library's own.
/// @tparam Numbers  the contents of a cell: `gaussian_numbers` or `poisson_numbers`
template <class Numbers>
struct cell_field {
    std::uint32_t seed = 1; ///< each seed gives an independent field of the same statistics
    /// Size of a cell across the line, metres: 1.25 times the spacing of the lines or more, and no more than twice the
    /// standard deviation of the beam; else speckle decorrelates too fast between lines (by 6 % of its width where the
    /// two are equal), or too slowly.
    float cell = 0.22e-3F;
    Numbers numbers{}; ///< contents of the cells

    /// Each elevation plane of a frame has scatterers of its own.
    static constexpr bool independent_planes = true;

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(cell) || !(cell > 0))
            throw usage_error{"cell_field: `cell` must be a finite number of metres above 0, such as 0.2_mm"};
        if constexpr (requires { numbers.check(); }) numbers.check();
    }

    /// Covariance of the scatterers of two lines, 1 at most, averaged over the positions of the lines in their cells.
    /// @param distance  between the lines, metres
    /// @param angle     between their directions, radians
    INSONIFY_FN float covariance(float distance, float angle) const {
        const float cells = std::fabs(distance) / cell;
        if (!(cells < 2)) return 0;
        const float end = 1 - 0.5F * cells;
        const float factor =
            1 + cells * (1.5F +
                         cells * (-2.25F + cells * (-2.5F + cells * (0.75F + cells * (0.65625F + cells * 0.109375F)))));
        return end * end * end * factor * detail::same_view_probability(angle);
    }
    /// The same of `surface_values`: of linear interpolation that keeps the power.
    INSONIFY_FN float value_covariance(float distance, float angle) const {
        // At distances of eighths of a cell, by numerical integration; linear in between.
        constexpr float eighths[] = {1,        0.9804F,  0.9248F,  0.84031F, 0.73599F, 0.62104F,
                                     0.50348F, 0.38981F, 0.2854F,  0.19486F, 0.12178F, 0.06792F,
                                     0.03254F, 0.01253F, 0.00333F, 0.00037F, 0};
        const detail::table_place at{8 * std::fabs(distance / cell), 17};
        return ((1 - at.part) * eighths[at.above] + at.part * eighths[at.below]) * detail::same_view_probability(angle);
    }
    /// Emits the scatterers from `begin` to `end`, metres along the line: see `scattering_field`.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line& line, float begin, float end, float spacing, Emit&& emit) const {
        // More slots than any line has samples: the sound speed is close to 0, and floats barely resolve the interval.
        if (!(end - begin < 0x1p25F * spacing)) return;
        if (!line.bends()) {
            const detail::rest_line rest = rest_at(line, begin, spacing);
            return with_structure(rest, begin, end, [&](detail::structured_line* structure) {
                scatter_slabs(rest, begin, end, spacing, structure, emit);
            });
        }
        for (float from = begin; from < end;) {
            const detail::rest_curve curve{line, from, end, nullptr};
            if (line.chart() == nullptr)
                scatter_curved(line, curve, curve, spacing, emit);
            else
                scatter_curved(line, curve, detail::rest_curve{line, from, end, line.chart()}, spacing, emit);
            from = curve.distance(curve.last());
        }
    }

    /// Values of the field at points of one line, interpolated between slots too: for surfaces, which have no volume.
    /// Within the few millimetres that a surface takes of it, the line counts as straight in tissue at rest.
    class surface_values {
      public:
        /// Of a line, around a distance along it, metres; the spacing of scatterers is in metres.
        INSONIFY_FN surface_values(const cell_field& field, const material_line& line, float around, float spacing)
            : field_{field}, around_{around}, spacing_{spacing}, line_{field.rest_at(line, around, spacing)} {
            line_.displacement = nullptr; // at rest, so that the tilt of its plane is not taken for shear
        }

        /// At a distance along the line, metres.
        INSONIFY_FN vec2 operator()(float distance) {
            detail::rest_line line = line_;
            line.origin = line_.at(distance - around_);
            const double slab = std::floor(detail::slab_position(line.origin));
            if (slab != slab_) { // points of one slab have one layout
                cells_ = detail::make_cell_layout(field_.seed, field_.cell, line, slab, spacing_);
                slab_ = slab;
                origin_ = distance;
                first_ = INT64_MAX;
            }
            const double slot = cells_.slot + static_cast<double>(distance - origin_) * cells_.slots_per_metre,
                         below = std::floor(slot);
            const auto number = static_cast<std::int64_t>(below);
            if (number < first_ || number - first_ > room - 2) compute_from(number);
            const auto i = static_cast<std::size_t>(number - first_);
            const auto weight = static_cast<float>(slot - below);
            const vec2 sum =
                (1 - weight) * vec2{real_[i], imaginary_[i]} + weight * vec2{real_[i + 1], imaginary_[i + 1]};
            return sum / std::sqrt((1 - weight) * (1 - weight) + weight * weight);
        }

      private:
        const cell_field& field_;
        float around_, spacing_;
        detail::rest_line line_;
        double slab_ = FLT_MAX; // none yet
        float origin_ = 0;      // of the layout, metres along the line
        detail::cell_layout cells_{};
        // Values are computed for some slots at a time: points follow each other closely.
        static constexpr int room = max_simd_width;
        std::int64_t first_ = 0;
        float real_[room] = {}, imaginary_[room] = {};

        INSONIFY_FN void compute_from(std::int64_t slot) {
            first_ = slot;
            const auto offset = static_cast<float>(static_cast<double>(slot) + 0.5 - cells_.slot);
            const detail::complex_lanes<room> some = cells_.template values<room, true>(
                static_cast<std::uint32_t>(slot), floats_of<room>(steps_of_bits<room>(0, 1)) + lanes<room>(offset),
                field_.numbers);
            store(some.real, real_);
            store(some.imaginary, imaginary_);
        }
    };

    friend bool operator==(const cell_field&, const cell_field&) = default;

  private:
    static constexpr std::uint32_t run_length = 96;
    static_assert(run_length % max_simd_width == 0, "levels of structure are computed by whole registers");

    // The line in tissue at rest, straight as it is at a distance along it, where its origin is.
    INSONIFY_FN detail::rest_line rest_at(const material_line& line, float distance, float spacing) const {
        detail::rest_line rest{line, cross(line.elevation, line.along)};
        vec3 point = line.at(distance);
        if (line.displacement != nullptr) {
            const mat3 gradient = line.displacement->gradient(point);
            rest.turn([&](vec3 v) { return gradient * v; });
            point = line.displacement->rest(point);
        }
        rest.origin = detail::resolvable(point, cell, spacing);
        return rest;
    }
    // The same in the coordinates in which the fibres of its structure are straight.
    INSONIFY_FN detail::rest_line structure_at(const material_line& line, float distance, float spacing) const {
        detail::rest_line rest = rest_at(line, distance, spacing);
        if (const fibre_chart* const chart = line.chart()) {
            constexpr float step = 0.5e-3F; // metres
            const vec3 point = rest.origin;
            rest.turn(
                [&](vec3 v) { return ((*chart)(point + step * v) - (*chart)(point - step * v)) * (0.5F / step); });
            rest.origin = (*chart)(point);
        }
        return rest;
    }

    // Calls use(what the structure does along a segment), or use(nullptr) in a medium without one.
    template <class Use>
    INSONIFY_FN void with_structure(const detail::rest_line& line, float begin, float end, const Use& use) const {
        if (line.structure == nullptr) return use(nullptr);
        if (line.along == vec3{0, 0, 0}) return;
        detail::structured_line structure{line, begin, end, mix_bits(seed + line.object)};
        use(&structure);
    }

    // Straight from point to point of a curve: over short pieces for the scatterers, whose phases count, and over
    // longer ones for the structure.
    // @param charted  the curve in the coordinates of the structure
    template <class Emit>
    INSONIFY_FN void scatter_curved(const material_line& line, const detail::rest_curve& curve,
                                    const detail::rest_curve& charted, float spacing, Emit&& emit) const {
        const auto segment = [&](detail::rest_line rest, const detail::rest_curve& of, std::uint32_t from,
                                 std::uint32_t to) {
            rest.origin = detail::resolvable(of.point(from), cell, spacing);
            rest.along = of.along(from, to);
            return rest;
        };
        const auto middle = [&](std::uint32_t from, std::uint32_t to) {
            return 0.5F * (curve.distance(from) + curve.distance(to));
        };
        for (std::uint32_t first = 0; first < curve.last();) {
            const std::uint32_t last =
                line.structure == nullptr
                    ? curve.last()
                    : charted.straight_until(first, curve.last(), 0.5F * detail::gain_spacing(line.structure->of));
            with_structure(segment(structure_at(line, middle(first, last), spacing), charted, first, last),
                           curve.distance(first), curve.distance(last), [&](detail::structured_line* structure) {
                               for (std::uint32_t from = first; from < last;) {
                                   const std::uint32_t to = curve.straight_until(from, last, spacing / 16);
                                   const detail::rest_line rest =
                                       segment(rest_at(line, middle(from, to), spacing), curve, from, to);
                                   if (rest.along != vec3{0, 0, 0})
                                       scatter_slabs(rest, curve.distance(from), curve.distance(to), spacing, structure,
                                                     emit);
                                   from = to;
                               }
                           });
            first = last;
        }
    }

    // Divides a straight segment where it leaves a slab: each slab has its own layout.
    template <class Emit>
    INSONIFY_FN void scatter_slabs(const detail::rest_line& line, float begin, float end, float spacing,
                                   detail::structured_line* structure, Emit&& emit) const {
        const double position = detail::slab_position(line.origin);
        const double slabs_per_metre = detail::slab_position(line.along);
        const bool ascending = slabs_per_metre > 0;
        const auto end_of = [&](double slab, float from) {
            if (!(std::fabs(slabs_per_metre) > 1e-3)) return end;
            const double border = slab + (ascending ? 1 : 0);
            return clamp(static_cast<float>(static_cast<double>(begin) + (border - position) / slabs_per_metre), from,
                         end);
        };
        const auto layout_at = [&](float from, double slab) {
            detail::rest_line rest = line;
            rest.origin = line.at(from - begin);
            detail::cell_layout cells = detail::make_cell_layout(seed, cell, rest, slab, spacing);
            constexpr float ahead = 2e-3F;
            const float first = line.phase_spread(from), more = line.phase_spread(from + ahead) - first;
            const auto per_slot = static_cast<float>(1 / (double{ahead} * cells.slots_per_metre));
            cells.turns = vec2{first, more * per_slot} * (line.height / (2 * pi));
            return cells;
        };
        // Where slots are of one layout in one layer, metres along the line.
        vec2 whole = line.surfaces.x < line.surfaces.y ? line.surfaces : vec2{-FLT_MAX, FLT_MAX};
        const float surface = whole.y;
        double slab = std::floor(position);
        detail::cell_layout cells{};
        for (float from = begin, to = begin;; slab += ascending ? 1 : -1) { // from the slab before to the next one
            const bool last = !(to < end);
            const detail::cell_layout next = last ? cells : layout_at(to, slab);
            const bool divided = next.key != cells.key;
            whole.y = divided ? to : surface;
            if (to > from) scatter_slab(cells, structure, from, to, whole, emit);
            if (last) return;
            if (divided && to > begin) whole.x = to;
            cells = next;
            from = to;
            to = end_of(slab, from);
        }
    }

    template <class Emit>
    INSONIFY_FN void scatter_slab(const detail::cell_layout& cells, detail::structured_line* structure, float begin,
                                  float end, vec2 whole, Emit&& emit) const {
        const double from = cells.slot;
        const auto slot_at = [&](float distance) {
            return from + static_cast<double>(distance - begin) * cells.slots_per_metre;
        };
        const double to = slot_at(end), whole_begin = slot_at(whole.x), whole_end = slot_at(whole.y);
        const auto first_slot = static_cast<std::int64_t>(std::floor(from));
        const auto end_slot = static_cast<std::int64_t>(std::floor(to)) + 1;
        float real[run_length], imaginary[run_length];
        for (std::int64_t slot = first_slot; slot < end_slot;) {
            const std::int64_t remaining = end_slot - slot;
            const auto count = static_cast<std::uint32_t>(remaining < run_length ? remaining : run_length);
            const double offset = static_cast<double>(slot) + 0.5 - from;
            for (std::uint32_t i = 0; i < count; i += detail::wide_lanes) {
                const auto value = cells.values<detail::wide_lanes>(
                    static_cast<std::uint32_t>(slot) + i,
                    detail::whole_numbers(i) + detail::wide_floats(static_cast<float>(offset)), numbers);
                store(value.real, real + i);
                store(value.imaginary, imaginary + i);
            }
            if (structure != nullptr)
                structure->multiply(begin + static_cast<float>(offset / cells.slots_per_metre),
                                    static_cast<float>(1 / cells.slots_per_metre), count, real, imaginary);
            // A slot that is cut is weighted by its part inside, so that its parts add up to it; where other scatterers
            // follow, at a surface or in another layout, by the root of that, which keeps the power.
            const auto weight = [&](std::uint32_t i) {
                const double own = static_cast<double>(slot + i),
                             inside = std::fmin(to, own + 1) - std::fmax(from, own),
                             left = std::fmin(whole_end, own + 1) - std::fmax(whole_begin, own);
                const auto factor = static_cast<float>(left < 1 ? inside / std::sqrt(std::fmax(left, 1e-12)) : inside);
                real[i] *= factor;
                imaginary[i] *= factor;
            };
            if (slot == first_slot) weight(0);
            if (slot + count == end_slot && end_slot > first_slot + 1) weight(count - 1);
            emit(scatterer_run{.first = begin + static_cast<float>(offset / cells.slots_per_metre),
                               .step = static_cast<float>(1 / cells.slots_per_metre),
                               .count = count,
                               .real = real,
                               .imaginary = imaginary,
                               .slope = cells.slope});
            slot += count;
        }
    }
};

/// Fully developed speckle, as in most tissue.
using gaussian_field = cell_field<gaussian_numbers>;

/// Sparse scatterers, whose speckle statistics depend on their number: `medium::scatterer_density`, or for media
/// without one `{.numbers = {.density = 5e9F}}`.
using poisson_scatterers = cell_field<poisson_numbers>;

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
