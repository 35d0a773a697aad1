#ifndef INSONIFY_TISSUE_STRUCTURE_GAINS_HPP
#define INSONIFY_TISSUE_STRUCTURE_GAINS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/random.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/tissue/sheet_crossings.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Value noise: random numbers at the points of the unit lattice, and cubic interpolation between them. Mean 0, variance 1,
/// approximately normally distributed.
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

/// Distance of points between which the gains of a structure are as good as linear, metres: less than the thickness of sheets.
INSONIFY_FN inline float gain_spacing(const structure& of) {
    float smallest = 0.16e-3F;
    for (const structure::sheet_layer* layer : {&of.sheets, &of.septa})
        if (layer->fill > 0) smallest = min(smallest, layer->thickness);
    return 0.85F * max(smallest, 0.03e-3F);
}

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
        : tissue_{tissue}, origin_{origin}, along_{along}, propagation_{propagation}, fnumber_{fnumber}, key_{key} {}

    /// Distance of the origin of the segment in the material, metres along the line.
    INSONIFY_FN float origin() const { return dot(origin_, along_) / dot(along_, along_); }

    /// See `gain_spacing`.
    INSONIFY_FN float point_spacing() const { return gain_spacing(tissue_.of); }
    /// Computes the gains at points. Those at distances are metres from the origin of the segment.
    INSONIFY_FN void compute(const gain_points& points) const {
        const structure& of = tissue_.of;
        const auto evaluate = [&](line_nodes& nodes, float apart, const auto& field) {
            nodes.evaluate(points.first, points.last(), max(apart, 4 * points.spacing), origin(), field);
        };
        line_nodes mottling, grain, waves;
        const auto vary = [&](line_nodes& nodes, const structure::variation& v, std::uint32_t number) {
            if (v.deviation_db == 0) return;
            evaluate(nodes, 0.5F * shortest(v.size), [&](const floats& distance) {
                return power_of_two<max_simd_width>(noise(v.size, number, distance) *
                                                    floats(bits_per_decibel * v.deviation_db));
            });
        };
        vary(mottling, of.mottling, 1);
        vary(grain, of.grain, 2);
        evaluate(waves, of.wave > 0 ? 0.5F * of.wave_length : 1.0F, [&](const floats& distance) {
            return of.wave > 0 ? noise(of.wave_length * vec3{1, 0.6F, 0.6F}, 3, distance) * floats(of.wave)
                               : floats(0.0F);
        });
        for (std::uint32_t i = 0; i < points.count; i += max_simd_width) {
            const float here = points.distance(i);
            floats between = of.grain.deviation_db == 0 ? floats(1.0F) : grain.at(here, points.spacing);
            if (of.bundles.spacing > 0)
                between = between * bundles(points.distances(i), waves.at(here, points.spacing));
            store(between, points.gain + i);
        }
        add_sheets(of.sheets, tissue_.layers[0], waves, points);
        add_sheets(of.septa, tissue_.layers[1], waves, points);
        if (of.mottling.deviation_db == 0) return;
        for (std::uint32_t i = 0; i < points.count; i += max_simd_width)
            store(load<max_simd_width>(points.gain + i) * mottling.at(points.distance(i), points.spacing),
                  points.gain + i);
    }

  private:
    using floats = lanes<max_simd_width>;
    using bits = bit_lanes<max_simd_width>;

    INSONIFY_FN void add_sheets(const structure::sheet_layer& of, const placed_structure::sheets& all,
                                const line_nodes& waves, const gain_points& points) const {
        if (all.count == 0) return;
        const float lobe = lobe_of(of.waviness, fnumber_);
        for (std::uint32_t k = 0; k < all.count; ++k)
            sheet_crossings{of, all, k, origin_, along_, propagation_, key_, lobe}.add(waves, points);
    }
    INSONIFY_FN static float shortest(vec3 size) { return min(size.x, min(size.y, size.z)); }

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
    INSONIFY_FN floats noise(vec3 size, std::uint32_t number, const floats& distance) const {
        const mat3& axes = tissue_.axes;
        return value_noise<max_simd_width>(mix_bits(key_ + number), along_axis(axes[0], size.x).at(distance),
                                           along_axis(axes[1], size.y).at(distance),
                                           along_axis(axes[2], size.z).at(distance));
    }

    // 1 between the bundles, their level inside.
    INSONIFY_FN INSONIFY_INLINE floats bundles(const floats& distance, const floats& aside) const {
        const structure::bundle_layer& of = tissue_.of.bundles;
        const floats z = along_axis(tissue_.axes[2], of.spacing).at(distance) + aside * floats(1 / of.spacing);
        const bits layer = floor_bits<max_simd_width>(z),
                   row_bits = mix_lanes<max_simd_width>(layer * 0x9E3779B9U + key_);
        const floats y = along_axis(tissue_.axes[1], of.spacing).at(distance) + aside * floats(0.7F / of.spacing) +
                         fraction_of_bits(row_bits, 0, 16); // each row by itself, or bundles would be in columns
        const bits row = floor_bits<max_simd_width>(y);
        const bits random = mix_lanes<max_simd_width>(row * 0x85EBCA6BU + layer * 0xC2B2AE35U + (key_ ^ 0x2545F491U));
        const float largest = 0.5F * of.diameter / of.spacing;
        const floats radius =
            floats(largest) * multiply_add(fraction_of_bits(random, 0, 8), floats(0.4F), floats(0.6F));
        const auto from_centre = [&](const floats& place, const bits& cell, std::uint32_t shift) {
            return place - floats_of<max_simd_width>(cell) -
                   multiply_add(floats(1.0F) - (radius + radius), fraction_of_bits(random, shift, 8), radius);
        };
        const floats dy = from_centre(y, row, 8), dz = from_centre(z, layer, 16);
        const floats outside = (sqrt(dy * dy + dz * dz) - radius) * floats(1 / bundle_edge);
        const floats inside = min(max(floats(0.5F) - outside, floats(0.0F)), floats(1.0F));
        return multiply_add(inside, floats(std::exp2(bits_per_decibel * of.level_db) - 1), floats(1.0F));
    }
    static constexpr float bundle_edge = 0.15F; // of the spacing

    const placed_structure& tissue_;
    vec3 origin_, along_, propagation_;
    float fnumber_;
    std::uint32_t key_;
};

/// Gains along a segment, computed as far ahead as there is room for.
class gain_window {
  public:
    /// @param last  end of the segment, metres from its origin
    INSONIFY_FN gain_window(const structure_gains& of, float last) : of_{of}, last_{last} {}

    /// Multiplies `count` complex amplitudes, at equal steps from a distance on; distances never decrease.
    INSONIFY_FN void multiply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        for (std::uint32_t i = 0; i < count; i += max_simd_width) {
            const floats gain = at(first + static_cast<float>(i) * step, step);
            if (count - i >= max_simd_width) {
                store(load<max_simd_width>(real + i) * gain, real + i);
                store(load<max_simd_width>(imaginary + i) * gain, imaginary + i);
            } else {
                float each[max_simd_width];
                store(gain, each);
                for (std::uint32_t k = i; k < count; ++k) {
                    real[k] *= each[k - i];
                    imaginary[k] *= each[k - i];
                }
            }
        }
    }

  private:
    using floats = lanes<max_simd_width>;
    static constexpr std::uint32_t max_points = 256; // at a time

    // At a register full of distances.
    INSONIFY_FN INSONIFY_INLINE floats at(float distance, float step) {
        const float length = (max_simd_width - 1) * step;
        if (count_ == 0 || (distance + length - begin_) * per_point_ > static_cast<float>(count_ - 2))
            fill(distance - 2 * step, max(last_, distance) + max_simd_width * step); // slabs overlap by a step
        return interpolate(gain_, count_, (distance - begin_) * per_point_, step * per_point_);
    }
    // From the last point before a distance on. Points lie at whole multiples of their distance in the material.
    INSONIFY_FN void fill(float from, float to) {
        const float spacing = of_.point_spacing(), origin = of_.origin();
        per_point_ = 1 / spacing;
        begin_ = min(std::floor((origin + from) * per_point_) * spacing - origin, from);
        count_ = static_cast<std::uint32_t>(min((to - begin_) * per_point_ + 3, static_cast<float>(max_points)));
        of_.compute({begin_, spacing, count_, gain_});
    }

    const structure_gains& of_;
    float last_, begin_ = 0, per_point_ = 1;
    std::uint32_t count_ = 0;
    float gain_[max_points + max_simd_width];
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
