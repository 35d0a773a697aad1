#ifndef INSONIFY_ACOUSTICS_SCATTERERS_CELL_FIELD_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_CELL_FIELD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/scatterers/cell_layout.hpp>
#include <insonify/acoustics/scatterers/scattering.hpp>
#include <insonify/core/error.hpp>
#include <insonify/tissue/sheath_gains.hpp>
#include <cfloat>
#include <cmath>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI::detail {

/// Part of a line as it was at rest, which is curved where tissue is deformed: points at equal steps, of which the last may be up
/// to half a step shorter or longer.
class rest_curve {
  public:
    /// @param line   with a displacement
    /// @param begin  metres along the line
    /// @param end    metres along the line; the curve ends before it where it would have too many points
    INSONIFY_FN rest_curve(const material_line& line, float begin, float end)
        : begin_{begin}, step_{line.displacement->straight_length / length(line.along)} {
        const float steps = (end - begin) / step_;
        last_ = static_cast<std::uint32_t>(clamp(steps + 0.5F, 1, max_steps));
        end_ = steps < static_cast<float>(max_steps) + 0.5F ? end : begin + static_cast<float>(max_steps) * step_;
        for (std::uint32_t i = 0; i <= last_; ++i) point_[i] = line.displacement->rest(line.at(distance(i)));
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

    /// The end of a straight piece from a point on: no point of the curve between is further from it than `tolerance`, metres.
    /// @param most  the last point that it may reach
    INSONIFY_FN std::uint32_t straight_until(std::uint32_t from, std::uint32_t largest, float tolerance) const {
        std::uint32_t to = from + 1;
        while (to < largest && is_straight(from, to + 1, tolerance)) ++to;
        return to;
    }

  private:
    static constexpr std::uint32_t max_steps = 32;

    INSONIFY_FN bool is_straight(std::uint32_t from, std::uint32_t to, float tolerance) const {
        const vec3 step = along(from, to);
        for (std::uint32_t i = from + 1; i < to; ++i) {
            const vec3 aside = point_[i] - point_[from] - (distance(i) - distance(from)) * step;
            if (dot(aside, aside) > tolerance * tolerance) return false;
        }
        return true;
    }

    float begin_, step_, end_ = 0; // metres along the line
    std::uint32_t last_ = 0;
    vec3 point_[max_steps + 1];
};

/// What the structure of its medium does to the speckle along one straight segment of a line.
class structured_line {
  public:
    /// @param line     in a medium that has a structure
    /// @param segment  of the line, in the undeformed material
    /// @param begin    of the segment, metres along the line
    /// @param end      of the segment, metres along the line
    /// @param key      of the object
    INSONIFY_FN structured_line(const material_line& line, const rest_line& segment, float begin, float end,
                                std::uint32_t key)
        : gains_{*line.structure, segment.origin,
                 segment.along,   normalize(segment.along - line.tilt * segment.elevation),
                 line.fnumber,    key},
          begin_{begin}, window_{gains_, end - begin}, behind_entry_{sheath_at(line, segment, end - begin, key,
                                                                               line.surfaces.x - begin,
                                                                               line.own_surfaces.x)},
          before_exit_{sheath_at(line, segment, end - begin, key, line.surfaces.y - begin, -line.own_surfaces.y)} {}

    /// Multiplies `count` complex amplitudes, at equal steps from a distance on, metres along the line; distances never
    /// decrease. The arrays have room for whole registers.
    INSONIFY_FN void apply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        window_.multiply(first - begin_, step, count, real, imaginary);
        behind_entry_.apply(first - begin_, step, count, real, imaginary);
        before_exit_.apply(first - begin_, step, count, real, imaginary);
    }

  private:
    INSONIFY_FN static sheath_gains sheath_at(const material_line& line, const rest_line& segment, float length,
                                              std::uint32_t key, float surface, float cosine) {
        const bool both_own = line.own_surfaces.x != 0 && line.own_surfaces.y != 0;
        return {line.structure->of.sheath,
                segment.origin,
                segment.along,
                line.fnumber,
                key,
                length,
                surface,
                cosine,
                both_own ? 0.5F * (line.surfaces.y - line.surfaces.x) : FLT_MAX};
    }

    structure_gains gains_;
    float begin_; // metres along the line
    gain_window window_;
    sheath_gains behind_entry_, before_exit_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

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
    /// Size of a cell across the line, metres: 1.25 times the spacing of the lines or more, and no more than twice the
    /// standard deviation of the beam; else speckle decorrelates too fast between lines (by 6 % of its width where the two
    /// are equal), or too slowly.
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
        for (float from = begin; from < end;) {
            const detail::rest_curve curve{line, from, end};
            scatter_curved(line, curve, spacing, emit);
            from = curve.distance(curve.last());
        }
    }

    /// Values of the field at points of one line, interpolated between slots too: for surfaces, which have no volume. Within the
    /// few millimetres that a surface takes of it, the line counts as straight in tissue at rest.
    class surface_values {
      public:
        /// Of a line, which must outlive it; the spacing of scatterers is in metres.
        INSONIFY_FN surface_values(const cell_field& field, const material_line& line, float spacing)
            : field_{field}, line_{line}, spacing_{spacing} {}

        /// At a distance along the line, metres.
        INSONIFY_FN vec2 operator()(float distance) {
            if (!known_) {
                rest_ = field_.rest_at(line_, distance, spacing_);
                first_distance_ = distance;
            }
            detail::rest_line rest = rest_;
            rest.origin += (distance - first_distance_) * rest.along;
            const double slab = std::floor(static_cast<double>(detail::view_slabs::position(rest.origin)));
            if (!known_ || slab != slab_) { // points of one slab have one layout
                cells_ = detail::make_cell_layout(field_.seed, field_.cell, line_, rest, slab, spacing_);
                known_ = true;
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
        const material_line& line_;
        float spacing_;
        bool known_ = false;
        detail::rest_line rest_{};
        float first_distance_ = 0; // its origin, metres along the line
        double slab_ = 0;
        float origin_ = 0; // of the layout, metres along the line
        detail::cell_layout cells_{};
        // Values are computed for some slots at a time: points follow each other closely.
        static constexpr int room = max_simd_width > 4 ? max_simd_width : 4;
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
    /// The value of the field at one point: see `surface_values`.
    INSONIFY_FN vec2 value(const material_line& line, float distance, float spacing) const {
        return surface_values{*this, line, spacing}(distance);
    }

    friend bool operator==(const cell_field&, const cell_field&) = default;

  private:
    static constexpr std::uint32_t run_length = 96;

    // The line in tissue at rest, straight as it is at a distance along it.
    INSONIFY_FN detail::rest_line rest_at(const material_line& line, float distance, float spacing) const {
        const vec3 now = line.at(distance), lateral = cross(line.elevation, line.along);
        if (line.displacement == nullptr)
            return {detail::resolvable(now, cell, spacing), line.along, line.elevation, lateral, line.steering};
        const mat3 gradient = line.displacement->gradient(now);
        return {detail::resolvable(line.displacement->rest(now), cell, spacing), gradient * line.along,
                gradient * line.elevation, gradient * lateral, gradient * line.steering};
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

    // Straight from point to point of a curve: over short pieces for the scatterers, whose phases count, and over longer ones for
    // the structure, which is displaced by less than 0.07 mm between their ends.
    template <class Emit>
    INSONIFY_FN void scatter_curved(const material_line& line, const detail::rest_curve& curve, float spacing,
                                    Emit&& emit) const {
        const auto segment = [&](std::uint32_t from, std::uint32_t to) {
            detail::rest_line rest = rest_at(line, 0.5F * (curve.distance(from) + curve.distance(to)), spacing);
            rest.origin = detail::resolvable(curve.point(from), cell, spacing);
            rest.along = curve.along(from, to);
            return rest;
        };
        const auto scatter_pieces = [&](std::uint32_t first, std::uint32_t last, detail::structured_line* structure) {
            for (std::uint32_t from = first; from < last;) {
                const std::uint32_t to = curve.straight_until(from, last, spacing / 16);
                const detail::rest_line rest = segment(from, to);
                if (rest.along != vec3{0, 0, 0})
                    scatter_slabs(line, curve.distance(from), curve.distance(to), rest, spacing, structure, emit);
                from = to;
            }
        };
        if (line.structure == nullptr) return scatter_pieces(0, curve.last(), nullptr);
        for (std::uint32_t from = 0; from < curve.last();) {
            const std::uint32_t to =
                curve.straight_until(from, curve.last(), 0.5F * detail::gain_spacing(line.structure->of));
            const detail::rest_line rest = segment(from, to);
            if (rest.along != vec3{0, 0, 0}) {
                detail::structured_line structure{line, rest, curve.distance(from), curve.distance(to),
                                                  mix_bits(seed + line.object)};
                scatter_pieces(from, to, &structure);
            }
            from = to;
        }
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
        const auto end_of = [&](double slab, float from) {
            if (!(std::fabs(slabs_per_metre) > 1e-3)) return end;
            const double border = slab + (ascending ? 1 : 0);
            return clamp(static_cast<float>(static_cast<double>(begin) + (border - position) / slabs_per_metre), from,
                         end);
        };
        const auto layout_at = [&](float from, double slab) {
            detail::rest_line rest = segment;
            rest.origin += (from - begin) * segment.along;
            detail::cell_layout cells = detail::make_cell_layout(seed, cell, line, rest, slab, spacing);
            cells.set_phase_spread(line, from);
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
            // A slot that is cut is weighted by its part inside, so that its parts add up to it; where other scatterers follow, at
            // a surface or in another layout, by the root of that, which keeps the power.
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
