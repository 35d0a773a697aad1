#ifndef INSONIFY_ACOUSTICS_SCATTERING_HPP
#define INSONIFY_ACOUSTICS_SCATTERING_HPP

#include <insonify/acoustics/layer.hpp>
#include <insonify/core/random.hpp>
#include <concepts>

/// The texture of tissue: where along a line its scatterers are, and how strong. They are anchored in the coordinates of
/// the object, so that speckle follows the tissue.
namespace insonify::inline INSONIFY_ABI {

/// A line in an object's own coordinates. Axes of length 1.
struct material_line {
    vec3 origin{0, 0, 0};
    vec3 along{0, 0, 1};
    vec3 elevation{0, 1, 0};
    std::uint32_t object = ~0U;

    INSONIFY_FN vec3 at(float distance) const { return origin + distance * along; }
};

INSONIFY_FN inline material_line in_object(const line_frame& line, const pose& place, std::uint32_t object) {
    return {place.local_point(line.origin), place.local_direction(line.along), place.local_direction(line.elevation),
            object};
}

/// Scatterers at equal steps: number i stands at first + i * step metres along the line.
struct scatterer_run {
    float first = 0;
    float step = 0;
    std::uint32_t count = 0;
    const vec2* amplitude = nullptr; ///< complex
};

/// Something to emit to, for the check below.
struct any_emit {
    INSONIFY_FN void operator()(const scatterer_run&) const {}
};

/// What a scattering field must do: emit(run) for the scatterers of one object between two distances along a line.
///
/// `spacing` metres of line hold a mean power of 1, whatever the field; `covariance` says how alike the amplitudes on
/// two parallel lines are that lie so many metres apart, 1 to 0.
template <class Field>
concept scattering_field = requires(const Field& field, const material_line& line, float x) {
    field.scatter(line, x, x, x, any_emit{});
    { field.covariance(x) } -> std::convertible_to<float>;
};

/// No texture at all.
struct no_scatterers {
    template <class Emit>
    INSONIFY_FN void scatter(const material_line&, float, float, float, Emit&&) const {}
    INSONIFY_FN float covariance(float) const { return 0; }
};

/// Points of an object stay where they are: the map of tissue that moves rigidly, or not at all.
struct undeformed {
    INSONIFY_FN vec3 operator()(std::uint32_t, vec3 point) const { return point; }
};

/// Very many scatterers to a resolution cell: their sum is a complex Gaussian, the envelope Rayleigh distributed.
struct gaussian_numbers {
    /// A complex number of mean power 1 for each index. @param volume  m^3 that it stands for
    INSONIFY_FN vec2 operator()(std::uint32_t index, float) const {
        const std::uint32_t real = mix_bits(index);
        return {bell(real), bell(mix_bits(real + 0x632BE5ABU))};
    }

  private:
    // The sum of two uniform numbers, mean 0, variance 1/2: the Gauss curve comes of the sums that follow.
    INSONIFY_FN static float bell(std::uint32_t bits) {
        constexpr float scale = 1.7320508F / 65536; // sqrt(1/2) over the deviation sqrt(2/12) of two 16-bit numbers
        return scale * static_cast<float>(static_cast<std::int32_t>((bits & 0xFFFFU) + (bits >> 16U)) - 65535);
    }
};

/// Countable scatterers of normally distributed strength and random phase, as many to a volume as Poisson's distribution
/// says.
struct poisson_numbers {
    float density = 20e9F; ///< scatterers in a cubic metre: 20 in a cubic millimetre

    INSONIFY_FN vec2 operator()(std::uint32_t index, float volume) const {
        const float mean = density * volume;
        const float chance = static_cast<float>(mix_bits(index) >> 8U) * 0x1p-24F;
        float probability = std::exp(-mean), reached = probability; // of no scatterer, of so many at most
        vec2 sum{0, 0};
        for (std::uint32_t count = 1; chance >= reached && count < 64; ++count) {
            const float angle = 2 * pi * static_cast<float>(mix_bits(index + count * 0x632BE5ABU) >> 8U) * 0x1p-24F;
            sum += hash_normal(index, count).x * vec2{std::cos(angle), std::sin(angle)};
            probability *= mean / static_cast<float>(count);
            reached += probability;
        }
        return sum / std::sqrt(mean);
    }
};

/// Scatterers in cells that are fixed in the material.
///
/// Along the beam one value per slot; the slots are fixed in the material, so each echo moves with it. Across the beam
/// cells, linear between two. Each slot's cells are displaced by chance, so that no spacing of lines keeps step with
/// them. Lines of different directions are independent.
/// @tparam Numbers   what a cell holds: `gaussian_numbers` or `poisson_numbers`
/// @tparam Material  vec3(std::uint32_t object, vec3 point): where the tissue now at `point` (object's coordinates) is
///                   when at rest; smooth over half a millimetre
template <class Numbers, class Material>
struct cell_field {
    std::uint32_t seed = 1;
    float cell = 0.2e-3F; ///< metres, across the beam
    Numbers numbers{};
    Material material{};

    /// Mean of what two lines have in common, whose values are linear between cells and scaled to power 1.
    INSONIFY_FN float covariance(float distance) const {
        // Integrals over the places of a line within its cell, at distances of eighths of a cell; linear between them.
        constexpr float eighths[] = {1,        0.9804F,  0.9248F,  0.84031F, 0.73599F, 0.62104F,
                                     0.50348F, 0.38981F, 0.2854F,  0.19486F, 0.12178F, 0.06792F,
                                     0.03254F, 0.01253F, 0.00333F, 0.00037F, 0};
        const float place = 8 * std::fabs(distance) / cell;
        if (!(place < 16)) return 0;
        const auto below = static_cast<int>(place);
        const float share = place - static_cast<float>(below);
        return (1 - share) * eighths[below] + share * eighths[below + 1];
    }

    template <class Emit>
    INSONIFY_FN void scatter(const material_line& line, float begin, float end, float spacing, Emit&& emit) const {
        // Between two points the map is taken as linear; without one, a straight line stays one.
        const float piece = std::is_same_v<Material, undeformed> ? end - begin : 0.5e-3F;
        for (float from = begin; from < end;) {
            const float to = from + 1.5F * piece < end ? from + piece : end;
            scatter_piece(line, from, to, spacing, emit);
            from = to;
        }
    }

    /// The value at one point, linear between slots too: for what is no volume, such as a rough surface.
    INSONIFY_FN vec2 value(const material_line& line, float distance, float spacing) const {
        const vec3 point = material(line.object, line.at(distance));
        const column across = column_at(line, point);
        const double place = static_cast<double>(dot(point, line.along)) / spacing;
        const double below = std::floor(place);
        const auto share = static_cast<float>(place - below);
        const auto slot = static_cast<std::uint32_t>(static_cast<std::int64_t>(below));
        const float volume = cell * cell * spacing;
        const vec2 sum =
            (1 - share) * across.value(slot, numbers, volume) + share * across.value(slot + 1, numbers, volume);
        return sum / std::sqrt((1 - share) * (1 - share) + share * share);
    }

  private:
    static constexpr std::uint32_t run_length = 64;

    // Where a line stands across the beam, in cells, and what its numbers depend on beside.
    struct column {
        float x = 0;
        float y = 0;
        std::uint32_t key = 0;

        // Of one slot: the four cells around the line, each with a complex number of its own.
        INSONIFY_FN vec2 value(std::uint32_t slot, const Numbers& number, float volume) const {
            const std::uint32_t own = key + slot * 0x9E3779B9U;
            const std::uint32_t chance = mix_bits(own);
            const float left = x + static_cast<float>(chance & 0xFFFFU) * 0x1p-16F;
            const float lower = y + static_cast<float>(chance >> 16U) * 0x1p-16F;
            const float column_below = std::floor(left), row_below = std::floor(lower);
            const float right = left - column_below, upper = lower - row_below;
            const auto first = own + static_cast<std::uint32_t>(static_cast<std::int32_t>(column_below)) * 0x85EBCA6BU +
                               static_cast<std::uint32_t>(static_cast<std::int32_t>(row_below)) * 0xC2B2AE35U;
            const vec2 sum =
                (1 - upper) * ((1 - right) * number(first, volume) + right * number(first + 0x85EBCA6BU, volume)) +
                upper * ((1 - right) * number(first + 0xC2B2AE35U, volume) +
                         right * number(first + 0x85EBCA6BU + 0xC2B2AE35U, volume));
            const float power =
                ((1 - right) * (1 - right) + right * right) * ((1 - upper) * (1 - upper) + upper * upper);
            return sum / std::sqrt(power);
        }
    };

    INSONIFY_FN column column_at(const material_line& line, vec3 point) const {
        // The direction's bits, coarse enough to survive the rounding of a probe and a body that move together.
        std::uint32_t key = mix_bits(seed * 0x9E3779B9U + line.object);
        for (int axis = 0; axis < 3; ++axis)
            key = mix_bits(
                key ^ static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(line.along[axis] * 16384))));
        return {dot(point, cross(line.elevation, line.along)) / cell, dot(point, line.elevation) / cell, key};
    }

    template <class Emit>
    INSONIFY_FN void scatter_piece(const material_line& line, float begin, float end, float spacing,
                                   Emit&& emit) const {
        const vec3 first = material(line.object, line.at(begin)), last = material(line.object, line.at(end));
        const double from = static_cast<double>(dot(first, line.along)) / spacing; // in slots
        const double to = std::is_same_v<Material, undeformed> ? from + static_cast<double>(end - begin) / spacing
                                                               : static_cast<double>(dot(last, line.along)) / spacing;
        if (!(to > from)) return;
        const double metres_per_slot = static_cast<double>(end - begin) / (to - from);
        const column across = column_at(line, 0.5F * (first + last));
        const auto first_slot = static_cast<std::int64_t>(std::floor(from));
        const auto past_slot = static_cast<std::int64_t>(std::floor(to)) + 1;
        vec2 amplitude[run_length];
        for (std::int64_t slot = first_slot; slot < past_slot;) {
            const std::int64_t left = past_slot - slot;
            const auto count = static_cast<std::uint32_t>(left < run_length ? left : run_length);
            for (std::uint32_t i = 0; i < count; ++i)
                amplitude[i] = across.value(static_cast<std::uint32_t>(slot) + i, numbers, cell * cell * spacing);
            // A slot that an interface cuts counts with its part inside.
            if (slot == first_slot) amplitude[0] *= static_cast<float>(static_cast<double>(first_slot) + 1 - from);
            if (slot + count == past_slot)
                amplitude[count - 1] *= static_cast<float>(1 - (static_cast<double>(past_slot) - to));
            emit(scatterer_run{.first = begin +
                                        static_cast<float>((static_cast<double>(slot) + 0.5 - from) * metres_per_slot),
                               .step = static_cast<float>(metres_per_slot),
                               .count = count,
                               .amplitude = amplitude});
            slot += count;
        }
    }
};

/// The texture of most tissue.
template <class Material = undeformed>
using gaussian_field = cell_field<gaussian_numbers, Material>;

/// Sparse texture, whose statistics show how many scatterers there are: `{.numbers = {.density = 5e9F}}`.
template <class Material = undeformed>
using poisson_scatterers = cell_field<poisson_numbers, Material>;

} // namespace insonify::inline INSONIFY_ABI
#endif
