#ifndef INSONIFY_TISSUE_STRUCTURE_NOISE_HPP
#define INSONIFY_TISSUE_STRUCTURE_NOISE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd_bits.hpp>

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

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
