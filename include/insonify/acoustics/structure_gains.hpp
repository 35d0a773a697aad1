#ifndef INSONIFY_ACOUSTICS_STRUCTURE_GAINS_HPP
#define INSONIFY_ACOUSTICS_STRUCTURE_GAINS_HPP

#include <insonify/acoustics/placed_structure.hpp>
#include <insonify/acoustics/structure_noise.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/simd_math.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Factors on the amplitude of speckle along a straight segment of a line in an object: see `structure`. Not normalised:
/// `placed_structure::rms` is their rms value.
class structure_gains {
  public:
    /// @param origin, along  of the segment: metres, and metres of material per metre of the line
    /// @param propagation    of sound, length 1
    /// @param fnumber        of the receiving aperture
    /// @param key            of the object
    INSONIFY_FN structure_gains(const placed_structure& tissue, vec3 origin, vec3 along, vec3 propagation,
                                float fnumber, std::uint32_t key)
        : tissue_{tissue}, origin_{origin}, along_{along}, propagation_{propagation}, key_{key},
          lobe_{lobe_of(tissue.of.sheets.waviness, fnumber), lobe_of(tissue.of.septa.waviness, fnumber)} {}

    /// Multiplies `count` complex amplitudes, at equal steps from a distance on; metres from the origin of the segment.
    INSONIFY_FN void apply(float first, float step, std::uint32_t count, float* real, float* imaginary) const {
        const std::uint32_t stride = static_cast<std::uint32_t>(clamp(point_spacing / step, 1, 8));
        const float spacing = step * static_cast<float>(stride);
        for (std::uint32_t done = 0; done < count;) {
            float gain[points];
            const std::uint32_t end = min_of(count - done, (max_points - 1) * stride);
            compute(first + static_cast<float>(done) * step, spacing, (end - 1) / stride + 2, gain);
            for (std::uint32_t i = 0; i < end; ++i) {
                const std::uint32_t k = i / stride;
                const float part = static_cast<float>(i - k * stride) / static_cast<float>(stride);
                const float here = gain[k] + part * (gain[k + 1] - gain[k]);
                real[done + i] *= here;
                imaginary[done + i] *= here;
            }
            done += end;
        }
    }

  private:
    static constexpr float point_spacing = 0.14e-3F;                     // of the gains; linear in between
    static constexpr std::uint32_t max_points = 64;                      // at a time
    static constexpr std::uint32_t points = max_points + 2 * simd_width; // room for them
    using floats = lanes<simd_width>;
    using bits = bit_lanes<simd_width>;

    INSONIFY_FN static std::uint32_t min_of(std::uint32_t a, std::uint32_t b) { return b < a ? b : a; }

    // Coordinates along an axis of the object, linear in the distance.
    struct coordinate {
        float first = 0, step = 0;
        INSONIFY_FN INSONIFY_INLINE floats at(const floats& distance) const {
            return multiply_add(distance, floats(step), floats(first));
        }
    };
    INSONIFY_FN coordinate along_axis(vec3 axis, float unit) const {
        return {dot(axis, origin_) / unit, dot(axis, along_) / unit};
    }

    // The gains at the first `needed` points.
    INSONIFY_FN void compute(float first, float spacing, std::uint32_t needed, float* gain) const {
        float slow[3][points]; // mottling, grain and wave, from values at every fourth point
        find_slow(first, spacing, needed, slow);
        for (std::uint32_t i = 0; i < needed; i += simd_width) {
            const floats distance = distances(first, spacing, i), aside = load<simd_width>(slow[2] + i);
            floats between = load<simd_width>(slow[1] + i);
            if (tissue_.of.bundles.spacing > 0) between = between * bundles(distance, aside);
            store(between, gain + i);
        }
        const structure::sheet_layer* const of[] = {&tissue_.of.sheets, &tissue_.of.septa};
        for (int layer = 0; layer < 2; ++layer)
            for (std::uint32_t k = 0; k < tissue_.layers[layer].count; ++k) {
                const sheet_line sheets{*of[layer], tissue_.layers[layer], k, *this, lobe_[layer]};
                for (std::uint32_t i = 0; i < needed; i += simd_width)
                    sheets.add(distances(first, spacing, i), load<simd_width>(slow[2] + i), gain + i);
            }
        for (std::uint32_t i = 0; i < needed; i += simd_width)
            store(load<simd_width>(gain + i) * load<simd_width>(slow[0] + i), gain + i);
    }
    INSONIFY_FN INSONIFY_INLINE static floats distances(float first, float spacing, std::uint32_t i) {
        return floats(first) + floats_of<simd_width>(steps_of_bits<simd_width>(i, 1)) * floats(spacing);
    }

    INSONIFY_FN void find_slow(float first, float spacing, std::uint32_t needed, float (&slow)[3][points]) const {
        constexpr std::uint32_t stride = 4;
        float coarse[3][points / stride + simd_width];
        const std::uint32_t last = (needed + simd_width) / stride;
        const structure& of = tissue_.of;
        for (std::uint32_t i = 0; i <= last; i += simd_width) {
            const floats distance = distances(first, stride * spacing, i);
            store(varied(of.mottling, 1, distance), coarse[0] + i);
            store(varied(of.grain, 2, distance), coarse[1] + i);
            const vec3 waves = of.wave_length * vec3{1, 0.6F, 0.6F};
            store(of.wave > 0 ? noise(waves, 3, distance) * floats(of.wave) : floats(0.0F), coarse[2] + i);
        }
        for (int of_kind = 0; of_kind < 3; ++of_kind)
            for (std::uint32_t i = 0; i < last; ++i)
                for (std::uint32_t k = 0; k < stride; ++k)
                    slow[of_kind][i * stride + k] =
                        coarse[of_kind][i] +
                        static_cast<float>(k) / stride * (coarse[of_kind][i + 1] - coarse[of_kind][i]);
    }
    INSONIFY_FN floats noise(vec3 size, std::uint32_t number, const floats& distance) const {
        const mat3& axes = tissue_.axes;
        return value_noise<simd_width>(mix_bits(key_ + number), along_axis(axes[0], size.x).at(distance),
                                       along_axis(axes[1], size.y).at(distance),
                                       along_axis(axes[2], size.z).at(distance));
    }
    INSONIFY_FN floats varied(const structure::variation& of, std::uint32_t number, const floats& distance) const {
        if (of.deviation_db == 0) return floats(1.0F);
        return power_of_two<simd_width>(noise(of.size, number, distance) * floats(bits_per_decibel * of.deviation_db));
    }

    // Fraction 0 to 1 of some of the bits.
    INSONIFY_FN INSONIFY_INLINE static floats fraction(const bits& random, std::uint32_t shift, std::uint32_t count) {
        return floats_of<simd_width>((random >> static_cast<int>(shift)) & ((1U << count) - 1)) *
               floats(1 / static_cast<float>((1U << count) - 1));
    }

    // The line in one lattice of sheets.
    struct sheet_line {
        const structure::sheet_layer& of;
        vec3 cell, aside;
        coordinate place[3];
        std::uint32_t key;
        float facing_y, facing_z; // components of the direction of propagation
        float per_lobe, diffuse;

        INSONIFY_FN sheet_line(const structure::sheet_layer& layer, const placed_structure::sheets& all,
                               std::uint32_t k, const structure_gains& line, float lobe)
            : of{layer}, cell{all.lattices[k].cell}, aside{all.lattices[k].aside}, key{all.lattices[k].key ^ line.key_},
              facing_y{dot(all.lattices[k].axes[1], line.propagation_)},
              facing_z{dot(all.lattices[k].axes[2], line.propagation_)}, per_lobe{1 / (lobe * lobe)}, diffuse{
                                                                                                          all.diffuse} {
            const mat3& cells = all.lattices[k].cells;
            for (int i = 0; i < 3; ++i) place[i] = {dot(cells[i], line.origin_), dot(cells[i], line.along_)};
        }

        // Adds the amplitude of the sheet, if there is one, in the cell of each point.
        INSONIFY_FN INSONIFY_INLINE void add(const floats& distance, const floats& wave, float* gain) const {
            const floats one(1.0F), half(0.5F), zero(0.0F);
            const auto cells = [&](int k) { return multiply_add(wave, floats(aside[k]), place[k].at(distance)); };
            // Layers of cells are shifted at random, rows within a layer and cells within a row too.
            const floats z = cells(2) + floats(static_cast<float>(key & 0xFFFFU) * 0x1p-16F);
            const bits layer = floor_bits<simd_width>(z);
            const bits of_layer = mix_lanes<simd_width>(layer * 0xC2B2AE35U + key);
            const floats y = cells(1) + fraction(of_layer, 0, 16);
            const bits row = floor_bits<simd_width>(y);
            const bits column = mix_lanes<simd_width>(row * 0x85EBCA6BU + of_layer);
            const floats x = cells(0) + fraction(column, 0, 16);
            const bits number = floor_bits<simd_width>(x);
            const bits a = mix_lanes<simd_width>(column + number * 0x9E3779B9U);
            const auto full = fraction(a, 0, 8) < floats(of.fill);
            if (bits_of(full) == 0) return;

            // Size, angle and place of the sheet, which stays in its cell.
            const bits b = mix_lanes<simd_width>(a + 0x51ED270BU);
            const floats half_length = floats(0.375F) * multiply_add(fraction(a, 8, 8), floats(0.55F), floats(0.45F));
            const floats half_width =
                floats(0.4F * cell.y) * multiply_add(fraction(a, 16, 8), floats(0.4F), floats(0.6F));
            const floats angle = (fraction(b, 14, 8) - half) * floats(2 * of.turn), squared = angle * angle;
            const floats sine =
                angle * polynomial<simd_width>(squared, -1.9841270e-4F, 8.3333333e-3F, -0.16666667F, 1.0F);
            const floats cosine =
                polynomial<simd_width>(squared, 2.4801587e-5F, -1.3888889e-3F, 4.1666667e-2F, -0.5F, 1.0F);
            const auto from_centre = [&](const floats& at, const bits& whole, const floats& extent,
                                         const floats& random) {
                const floats e = min(extent, half);
                return at - floats_of<simd_width>(whole) - multiply_add(one - (e + e), random, e);
            };
            const floats from_x = from_centre(x, number, half_length, fraction(a, 24, 8));
            const floats margin(1.5F *
                                of.thickness); // so that little of the profile is cut off at the sides of the cell
            const floats wide = half_width * cosine + margin * abs(sine),
                         high = half_width * abs(sine) + margin * cosine;
            const floats from_y = floats(cell.y) * from_centre(y, row, wide * floats(1 / cell.y), fraction(b, 0, 7));
            const floats from_z = floats(cell.z) * from_centre(z, layer, high * floats(1 / cell.z), fraction(b, 7, 7));

            // Its outline and profile, which ends at four standard deviations: most points are outside.
            const floats across = from_y * sine + from_z * cosine,
                         within = (from_y * cosine - from_z * sine) / half_width, lengthwise = from_x / half_length;
            const floats outline = max(one - lengthwise * lengthwise, zero) * max(one - within * within, zero);
            const auto inside = full && zero < outline && abs(across) < floats(4 * of.thickness);
            if (bits_of(inside) == 0) return;

            const floats steps = floats_of<simd_width>(((b >> 22) & 31U) + (b >> 27)); // a sum of two, each 0 to 31
            const floats level_number =
                multiply_add(steps, floats(max_level_number / 32), floats(-max_level_number * 31 / 32));
            const floats level = multiply_add(level_number, floats(bits_per_decibel * of.spread_db),
                                              floats(bits_per_decibel * of.level_db));
            const floats profile = across * across * floats(-0.72134752F / (of.thickness * of.thickness));
            const floats facing = sine * floats(facing_y) + cosine * floats(facing_z);
            const floats turned = (facing * facing - one) * floats(per_lobe);
            const floats echo = multiply_add(power_of_two<simd_width>(turned), floats(1 - diffuse), floats(diffuse));
            const floats amplitude = power_of_two<simd_width>(level + profile) * sqrt(outline) * echo;
            store(load<simd_width>(gain) + select(inside, amplitude, zero), gain);
        }
    };

    // 1 between the bundles, their level inside.
    INSONIFY_FN INSONIFY_INLINE floats bundles(const floats& distance, const floats& aside) const {
        const structure::bundle_layer& of = tissue_.of.bundles;
        const floats z = along_axis(tissue_.axes[2], of.spacing).at(distance) + aside * floats(1 / of.spacing);
        const bits layer = floor_bits<simd_width>(z), row_bits = mix_lanes<simd_width>(layer * 0x9E3779B9U + key_);
        const floats y = along_axis(tissue_.axes[1], of.spacing).at(distance) + aside * floats(0.7F / of.spacing) +
                         fraction(row_bits, 0, 16); // each row by itself, or bundles would be in columns
        const bits row = floor_bits<simd_width>(y);
        const bits random = mix_lanes<simd_width>(row * 0x85EBCA6BU + layer * 0xC2B2AE35U + (key_ ^ 0x2545F491U));
        const float largest = 0.5F * of.diameter / of.spacing;
        const floats radius = floats(largest) * multiply_add(fraction(random, 0, 8), floats(0.4F), floats(0.6F));
        const auto from_centre = [&](const floats& place, const bits& cell, std::uint32_t shift) {
            return place - floats_of<simd_width>(cell) -
                   multiply_add(floats(1.0F) - (radius + radius), fraction(random, shift, 8), radius);
        };
        const floats dy = from_centre(y, row, 8), dz = from_centre(z, layer, 16);
        const floats outside = (sqrt(dy * dy + dz * dz) - radius) * floats(1 / bundle_edge);
        const floats inside = min(max(floats(0.5F) - outside, floats(0.0F)), floats(1.0F));
        return multiply_add(inside, floats(std::exp2(bits_per_decibel * of.level_db) - 1), floats(1.0F));
    }
    static constexpr float bundle_edge = 0.15F; // of the spacing

    const placed_structure& tissue_;
    vec3 origin_, along_, propagation_;
    std::uint32_t key_;
    float lobe_[2];
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
