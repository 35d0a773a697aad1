#ifndef INSONIFY_ACOUSTICS_CELL_FIELD_HPP
#define INSONIFY_ACOUSTICS_CELL_FIELD_HPP

#include <insonify/acoustics/scatter_numbers.hpp>
#include <insonify/acoustics/scattering.hpp>
#include <insonify/acoustics/view_direction.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/simd_math.hpp>
#include <type_traits>

namespace insonify::inline INSONIFY_ABI {

/// Scatterers in cells that are fixed in the material.
///
/// Along the line one value per slot; the slots are fixed in the material, so each echo moves with it. Across the line
/// cells, linear between two. Each slot's cells are displaced by chance, so that no spacing of lines keeps step with
/// them. Both are laid out for a `view_direction` near the line's.
/// @tparam Numbers   what a cell holds: `gaussian_numbers` or `poisson_numbers`
/// @tparam Material  vec3(std::uint32_t object, vec3 point): where the tissue now at `point` (object's coordinates) is
///                   when at rest; smooth over half a millimetre
template <class Numbers, class Material>
struct cell_field {
    std::uint32_t seed = 1; ///< another one, another texture of the same kind
    float cell = 0.2e-3F;   ///< metres, across the line
    Numbers numbers{};      ///< what a cell holds
    Material material{};    ///< where tissue is when at rest

    /// @throws usage_error  where the cells have no size
    void check() const {
        if (!is_finite(cell) || !(cell > 0))
            throw usage_error{"cell_field: `cell` must be a finite number of metres above 0, such as 0.2_mm"};
        if constexpr (requires { numbers.check(); }) numbers.check();
    }

    /// Mean of what two lines have in common, whose values are linear between cells and scaled to power 1.
    /// @param apart   metres
    /// @param turned  radians between their directions
    INSONIFY_FN float covariance(float apart, float turned) const {
        // Integrals over the places of a line within its cell, at distances of eighths of a cell; linear between them.
        constexpr float eighths[] = {1,        0.9804F,  0.9248F,  0.84031F, 0.73599F, 0.62104F,
                                     0.50348F, 0.38981F, 0.2854F,  0.19486F, 0.12178F, 0.06792F,
                                     0.03254F, 0.01253F, 0.00333F, 0.00037F, 0};
        const float place = 8 * std::fabs(apart) / cell;
        if (!(place < 16)) return 0;
        const auto below = static_cast<int>(place);
        const float share = place - static_cast<float>(below);
        return ((1 - share) * eighths[below] + share * eighths[below + 1]) * same_view(turned);
    }

    /// Emits the scatterers from `begin` to `end`, metres along the line: see `scattering_field`.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line& line, float begin, float end, float spacing, Emit&& emit) const {
        // No line has so many samples: this is a stretch whose ends floats hardly tell apart, where sound all but stands still.
        if (!(end - begin < 0x1p25F * spacing)) return;
        // Between two points the map is taken as linear; without one, a straight line stays one.
        const float piece = std::is_same_v<Material, undeformed> ? end - begin : 0.5e-3F;
        for (float from = begin; from < end;) {
            const float to = from + 1.5F * piece < end ? from + piece : end;
            const vec3 first = material(line.object, line.at(from)), last = material(line.object, line.at(to));
            const vec3 course = std::is_same_v<Material, undeformed> ? line.along : (last - first) * (1 / (to - from));
            if (course != vec3{0, 0, 0})
                scatter_straight(line, from, to, {countable(first, spacing), course}, spacing, emit);
            from = to;
        }
    }

    /// The value at one point, linear between slots too: for what is no volume, such as a rough surface.
    INSONIFY_FN vec2 value(const material_line& line, float distance, float spacing) const {
        const vec3 point = countable(material(line.object, line.at(distance)), spacing);
        const layout cells = layout_for(line, {point, line.along}, std::floor(view_slabs::place(point)), spacing);
        const double below = std::floor(cells.slot);
        const auto share = static_cast<float>(cells.slot - below);
        const auto slot = static_cast<std::uint32_t>(static_cast<std::int64_t>(below));
        vec2 sum{0, 0};
        for (const std::uint32_t side : {0U, 1U}) {
            const complex_lanes<1> one = cells.template values<1>(slot + side, lanes<1>(0.0F), numbers);
            float real = 0, imaginary = 0;
            store(one.real, &real);
            store(one.imaginary, &imaginary);
            sum += (side == 0 ? 1 - share : share) * vec2{real, imaginary};
        }
        return sum / std::sqrt((1 - share) * (1 - share) + share * share);
    }

    friend bool operator==(const cell_field&, const cell_field&) = default;

  private:
    // A straight piece of a line at rest: where it begins, and metres there for a metre of the line.
    struct rest_line {
        vec3 origin{0, 0, 0};
        vec3 course{0, 0, 1};
    };

    // Slots and cells as one line meets them: `slot` at its origin, and where the line stands across, in cells.
    struct layout {
        double slot = 0;
        double slots_per_metre = 1;
        vec2 across{0, 0};
        vec2 across_per_slot{0, 0};
        std::uint32_t key = 0; // what its numbers depend on beside
        float volume = 0;      // of a cell
        float density = 0;
        vec2 slope{0, 0};

        // Of N slots, `past` slots beyond the origin: the four cells around the line, each with a number of its own.
        template <int N>
        INSONIFY_FN INSONIFY_INLINE complex_lanes<N> values(std::uint32_t first_slot, const lanes<N>& past,
                                                            const Numbers& number) const {
            using floats = lanes<N>;
            using bits = bit_lanes<N>;
            constexpr std::uint32_t next_column = 0x85EBCA6BU, next_row = 0xC2B2AE35U;
            const bits own = steps_of_bits<N>(key + first_slot * 0x9E3779B9U, 0x9E3779B9U);
            const bits chance = mix_lanes<N>(own);
            const floats one(1.0F), to_share(0x1p-16F);
            const floats x =
                floats(across.x) + past * floats(across_per_slot.x) + floats_of<N>(chance & 0xFFFFU) * to_share;
            const floats y =
                floats(across.y) + past * floats(across_per_slot.y) + floats_of<N>(chance >> 16) * to_share;
            const bits column = floor_bits<N>(x), row = floor_bits<N>(y);
            const floats right = x - floats_of<N>(column), upper = y - floats_of<N>(row);
            const floats left = one - right, lower = one - upper;
            const bits cell_of = own + column * next_column + row * next_row + 0x51ED270BU;
            const complex_lanes<N> a = number.template operator()<N>(cell_of, volume, density),
                                   b = number.template operator()<N>(cell_of + next_column, volume, density),
                                   c = number.template operator()<N>(cell_of + next_row, volume, density),
                                   d = number.template operator()<N>(cell_of + (next_column + next_row), volume,
                                                                     density);
            const floats scale = of_power_1<N>(right) * of_power_1<N>(upper);
            return {(lower * (left * a.real + right * b.real) + upper * (left * c.real + right * d.real)) * scale,
                    (lower * (left * a.imaginary + right * b.imaginary) +
                     upper * (left * c.imaginary + right * d.imaginary)) *
                        scale};
        }

        // 1 / sqrt(share^2 + (1 - share)^2) within 1e-4, as a polynomial in u = (2 share - 1)^2: sqrt(2 / (1 + u)).
        template <int N>
        INSONIFY_FN INSONIFY_INLINE static lanes<N> of_power_1(const lanes<N>& share) {
            const lanes<N> twice = share + share - lanes<N>(1.0F);
            return polynomial<N>(twice * twice, 0.070276911F, -0.26038293F, 0.47710252F, -0.70102729F, 1.4140941F);
        }
    };

    static constexpr std::uint32_t run_length = 128;

    // Some 100 km away no float tells one cell from the next, and farther no integer counts them, nor slots that are
    // next to nothing: there the texture is that of the origin.
    INSONIFY_FN vec3 countable(vec3 point, float spacing) const {
        const vec3 size = absolute(point);
        const float farthest = lesser(0x1p29F * lesser(cell, 1e-3F), 0x1p50F * spacing);
        return size.x < farthest && size.y < farthest && size.z < farthest ? point : vec3{0, 0, 0};
    }

    INSONIFY_FN layout layout_for(const material_line& line, const rest_line& at_rest, double slab,
                                  float spacing) const {
        const std::uint32_t own = mix_bits(seed * 0x9E3779B9U + line.object);
        const auto number = static_cast<std::uint32_t>(static_cast<std::int64_t>(slab));
        const vec3 view = view_direction(at_rest.course, mix_bits(own + number * 0x9E3779B9U));
        const axes_across axes{view};
        const vec3 lateral = cross(line.elevation, line.along);
        const float advance = dot(at_rest.course, view);
        layout cells;
        cells.slot = static_cast<double>(dot(at_rest.origin, view)) / spacing;
        cells.slots_per_metre = static_cast<double>(advance) / spacing;
        cells.across = vec2{dot(at_rest.origin, axes.first), dot(at_rest.origin, axes.second)} / cell;
        cells.across_per_slot =
            vec2{dot(at_rest.course, axes.first), dot(at_rest.course, axes.second)} * (spacing / (advance * cell));
        cells.key = own;
        for (int axis = 0; axis < 3; ++axis)
            cells.key = mix_bits(
                cells.key ^ static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(view[axis] * 16384))));
        cells.volume = cell * cell * spacing;
        cells.density = line.scatterer_density;
        cells.slope = vec2{dot(lateral, view), dot(line.elevation, view)} / -advance;
        return cells;
    }

    template <class Emit>
    INSONIFY_FN void scatter_straight(const material_line& line, float begin, float end, const rest_line& at_rest,
                                      float spacing, Emit&& emit) const {
        const double place = static_cast<double>(view_slabs::place(at_rest.origin));
        const double slabs_per_metre = static_cast<double>(view_slabs::place(at_rest.course));
        double slab = std::floor(place);
        for (float from = begin; from<end; slab += slabs_per_metre> 0 ? 1 : -1) {
            const double border = slab + (slabs_per_metre > 0 ? 1 : 0);
            float to = end;
            if (std::fabs(slabs_per_metre) > 1e-3)
                to = clamped(static_cast<float>(static_cast<double>(begin) + (border - place) / slabs_per_metre), from,
                             end);
            const rest_line from_here{at_rest.origin + (from - begin) * at_rest.course, at_rest.course};
            if (to > from) scatter_slab(layout_for(line, from_here, slab, spacing), from, to, emit);
            from = to;
        }
    }

    template <class Emit>
    INSONIFY_FN void scatter_slab(const layout& cells, float begin, float end, Emit&& emit) const {
        const double from = cells.slot, to = from + static_cast<double>(end - begin) * cells.slots_per_metre;
        const auto first_slot = static_cast<std::int64_t>(std::floor(from));
        const auto past_slot = static_cast<std::int64_t>(std::floor(to)) + 1;
        float real[run_length], imaginary[run_length];
        for (std::int64_t slot = first_slot; slot < past_slot;) {
            const std::int64_t left = past_slot - slot;
            const auto count = static_cast<std::uint32_t>(left < run_length ? left : run_length);
            const double past = static_cast<double>(slot) + 0.5 - from;
            for (std::uint32_t i = 0; i < count; i += simd_width) {
                const auto some =
                    cells.template values<simd_width>(static_cast<std::uint32_t>(slot) + i,
                                                      floats_of<simd_width>(steps_of_bits<simd_width>(i, 1)) +
                                                          lanes<simd_width>(static_cast<float>(past)),
                                                      numbers);
                store(some.real, real + i);
                store(some.imaginary, imaginary + i);
            }
            // A slot that a border cuts counts with its part inside.
            const auto cut = [&](std::uint32_t i, double part) {
                real[i] *= static_cast<float>(part);
                imaginary[i] *= static_cast<float>(part);
            };
            if (slot == first_slot) cut(0, static_cast<double>(first_slot) + 1 - from);
            if (slot + count == past_slot) cut(count - 1, 1 - (static_cast<double>(past_slot) - to));
            emit(scatterer_run{.first = begin + static_cast<float>(past / cells.slots_per_metre),
                               .step = static_cast<float>(1 / cells.slots_per_metre),
                               .count = count,
                               .real = real,
                               .imaginary = imaginary,
                               .slope = cells.slope});
            slot += count;
        }
    }
};

/// The texture of most tissue.
template <class Material = undeformed>
using gaussian_field = cell_field<gaussian_numbers, Material>;

/// Sparse texture, whose statistics show how many scatterers there are: `medium::scatterer_density`, or for media that
/// state none `{.numbers = {.density = 5e9F}}`.
template <class Material = undeformed>
using poisson_scatterers = cell_field<poisson_numbers, Material>;

} // namespace insonify::inline INSONIFY_ABI
#endif
