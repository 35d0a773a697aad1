#ifndef INSONIFY_ACOUSTICS_CELL_FIELD_HPP
#define INSONIFY_ACOUSTICS_CELL_FIELD_HPP

#include <insonify/acoustics/structured_line.hpp>
#include <insonify/core/error.hpp>

namespace insonify::inline INSONIFY_ABI {

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
    /// Size of a cell across the line, metres: no less than the spacing of the lines, and no more than twice the standard
    /// deviation of the beam; else speckle decorrelates too fast or too slowly between lines.
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
        // The weights of `cell_layout` correlated with themselves.
        const float end = 1 - 0.5F * cells;
        const float factor =
            1 + cells * (1.5F +
                         cells * (-2.25F + cells * (-2.5F + cells * (0.75F + cells * (0.65625F + cells * 0.109375F)))));
        return end * end * end * factor * detail::same_view_probability(angle);
    }
    /// The same of `value`.
    INSONIFY_FN float value_covariance(float distance, float angle) const {
        return linear_covariance(distance / cell) * detail::same_view_probability(angle);
    }
    /// Emits the scatterers from `begin` to `end`, metres along the line: see `scattering_field`.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line& line, float begin, float end, float spacing, Emit&& emit) const {
        // More slots than any line has samples: the sound speed is close to 0, and floats barely resolve the interval.
        if (!(end - begin < 0x1p25F * spacing)) return;
        if (line.displacement == nullptr)
            return scatter_straight(line, begin, end, rest_at(line, begin, spacing), spacing, emit);
        // The line is curved in tissue at rest: straight from point to point.
        vec3 first = line.displacement->rest(line.at(begin));
        for (float from = begin; from < end;) {
            const float to = piece_end(line, from, end, first, spacing);
            detail::rest_line rest = rest_at(line, 0.5F * (from + to), spacing);
            const vec3 last = line.displacement->rest(line.at(to));
            rest.origin = detail::resolvable(first, cell, spacing);
            rest.along = (last - first) * (1 / (to - from));
            if (rest.along != vec3{0, 0, 0}) scatter_straight(line, from, to, rest, spacing, emit);
            first = last;
            from = to;
        }
    }

    /// Values of the field at points of one line, interpolated between slots too: for surfaces, which have no volume.
    class surface_values {
      public:
        /// Of a line, which must outlive it; the spacing of scatterers is in metres.
        INSONIFY_FN surface_values(const cell_field& field, const material_line& line, float spacing)
            : field_{field}, line_{line}, spacing_{spacing} {}

        /// At a distance along the line, metres.
        INSONIFY_FN vec2 operator()(float distance) {
            const detail::rest_line rest = field_.rest_at(line_, distance, spacing_);
            const double slab = std::floor(static_cast<double>(detail::view_slabs::position(rest.origin)));
            if (!known_ || slab != slab_) { // points of one slab have one layout
                cells_ = detail::make_cell_layout(field_.seed, field_.cell, line_, rest, slab, spacing_);
                known_ = true;
                slab_ = slab;
                origin_ = distance;
            }
            const double from_origin = static_cast<double>(distance - origin_) * cells_.slots_per_metre;
            const double slot = cells_.slot + from_origin, below = std::floor(slot);
            const auto weight = static_cast<float>(slot - below);
            // Of the slots below and above, and of two more that are not used.
            const complex_lanes<4> both =
                cells_.template values<4, true>(static_cast<std::uint32_t>(static_cast<std::int64_t>(below)),
                                                lanes<4>(static_cast<float>(from_origin)), field_.numbers);
            float real[4], imaginary[4];
            store(both.real, real);
            store(both.imaginary, imaginary);
            const vec2 sum = (1 - weight) * vec2{real[0], imaginary[0]} + weight * vec2{real[1], imaginary[1]};
            return sum / std::sqrt((1 - weight) * (1 - weight) + weight * weight);
        }

      private:
        const cell_field& field_;
        const material_line& line_;
        float spacing_;
        bool known_ = false;
        double slab_ = 0;
        float origin_ = 0; // of the layout, metres along the line
        detail::cell_layout cells_{};
    };
    /// The value of the field at one point: see `surface_values`.
    INSONIFY_FN vec2 value(const material_line& line, float distance, float spacing) const {
        return surface_values{*this, line, spacing}(distance);
    }

    friend bool operator==(const cell_field&, const cell_field&) = default;

  private:
    static constexpr std::uint32_t run_length = 256;

    // The line in tissue at rest, straight as it is at a distance along it.
    INSONIFY_FN detail::rest_line rest_at(const material_line& line, float distance, float spacing) const {
        const vec3 now = line.at(distance), lateral = cross(line.elevation, line.along);
        if (line.displacement == nullptr)
            return {detail::resolvable(now, cell, spacing), line.along, line.elevation, lateral, line.steering};
        const mat3 gradient = line.displacement->gradient(now);
        return {detail::resolvable(line.displacement->rest(now), cell, spacing), gradient * line.along,
                gradient * line.elevation, gradient * lateral, gradient * line.steering};
    }

    // End of the piece of a line that begins at `from`, which is `first` at rest. In tissue at rest the piece bends by less than
    // the spacing of the scatterers.
    INSONIFY_FN static float piece_end(const material_line& line, float from, float end, vec3 first, float spacing) {
        const float straight = line.displacement->straight_length / length(line.along);
        for (int parts = 4; parts > 1; parts /= 2) {
            const float to = from + static_cast<float>(parts) * straight;
            if (!(to < end)) continue;
            const vec3 part = (line.displacement->rest(line.at(to)) - first) / static_cast<float>(parts);
            bool bends = false;
            for (int i = 1; i < parts && !bends; ++i) {
                const auto number = static_cast<float>(i);
                const vec3 aside = line.displacement->rest(line.at(from + number * straight)) - first - number * part;
                bends = dot(aside, aside) > spacing * spacing;
            }
            if (!bends) return to;
        }
        return from + 1.5F * straight < end ? from + straight : end;
    }

    // Covariance of linear interpolation that keeps the power, by distance in cells.
    INSONIFY_FN static float linear_covariance(float cells) {
        // At distances of eighths of a cell, by numerical integration; linear in between.
        constexpr float eighths[] = {1,        0.9804F,  0.9248F,  0.84031F, 0.73599F, 0.62104F,
                                     0.50348F, 0.38981F, 0.2854F,  0.19486F, 0.12178F, 0.06792F,
                                     0.03254F, 0.01253F, 0.00333F, 0.00037F, 0};
        const float position = 8 * std::fabs(cells);
        if (!(position < 16)) return 0;
        const auto below = static_cast<int>(position);
        const float weight = position - static_cast<float>(below);
        return (1 - weight) * eighths[below] + weight * eighths[below + 1];
    }

    template <class Emit>
    INSONIFY_FN void scatter_straight(const material_line& line, float begin, float end,
                                      const detail::rest_line& segment, float spacing, Emit&& emit) const {
        if (line.structure == nullptr) return scatter_slabs(line, begin, end, segment, spacing, nullptr, emit);
        detail::structured_line structure{line, segment, begin, end, mix_bits(seed + line.object)};
        scatter_slabs(line, begin, end, segment, spacing, &structure, emit);
    }

    // Divides a straight segment where it leaves a slab: each slab has its own layout.
    template <class Emit>
    INSONIFY_FN void scatter_slabs(const material_line& line, float begin, float end, const detail::rest_line& segment,
                                   float spacing, detail::structured_line* structure, Emit&& emit) const {
        const double position = static_cast<double>(detail::view_slabs::position(segment.origin));
        const double slabs_per_metre = static_cast<double>(detail::view_slabs::position(segment.along));
        const bool ascending = slabs_per_metre > 0;
        double slab = std::floor(position);
        for (float from = begin; from < end; slab += ascending ? 1 : -1) {
            const double border = slab + (ascending ? 1 : 0);
            float to = end;
            if (std::fabs(slabs_per_metre) > 1e-3)
                to = clamp(static_cast<float>(static_cast<double>(begin) + (border - position) / slabs_per_metre), from,
                           end);
            detail::rest_line rest = segment;
            rest.origin += (from - begin) * segment.along;
            if (to > from)
                scatter_slab(detail::make_cell_layout(seed, cell, line, rest, slab, spacing), structure, from, to,
                             emit);
            from = to;
        }
    }

    template <class Emit>
    INSONIFY_FN void scatter_slab(const detail::cell_layout& cells, detail::structured_line* structure, float begin,
                                  float end, Emit&& emit) const {
        const double from = cells.slot, to = from + static_cast<double>(end - begin) * cells.slots_per_metre;
        const auto first_slot = static_cast<std::int64_t>(std::floor(from));
        const auto end_slot = static_cast<std::int64_t>(std::floor(to)) + 1;
        float real[run_length], imaginary[run_length];
        for (std::int64_t slot = first_slot; slot < end_slot;) {
            const std::int64_t remaining = end_slot - slot;
            const auto count = static_cast<std::uint32_t>(remaining < run_length ? remaining : run_length);
            const double offset = static_cast<double>(slot) + 0.5 - from;
            for (std::uint32_t i = 0; i < count; i += max_simd_width) {
                const auto value =
                    cells.values<max_simd_width>(static_cast<std::uint32_t>(slot) + i,
                                                 floats_of<max_simd_width>(steps_of_bits<max_simd_width>(i, 1)) +
                                                     lanes<max_simd_width>(static_cast<float>(offset)),
                                                 numbers);
                store(value.real, real + i);
                store(value.imaginary, imaginary + i);
            }
            if (structure != nullptr)
                structure->apply(begin + static_cast<float>(offset / cells.slots_per_metre),
                                 static_cast<float>(1 / cells.slots_per_metre), count, real, imaginary);
            // A slot cut by a border is weighted by the fraction inside.
            const auto weight = [&](std::uint32_t i, double fraction) {
                real[i] *= static_cast<float>(fraction);
                imaginary[i] *= static_cast<float>(fraction);
            };
            if (slot == first_slot) weight(0, static_cast<double>(first_slot) + 1 - from);
            if (slot + count == end_slot) weight(count - 1, 1 - (static_cast<double>(end_slot) - to));
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
#endif
