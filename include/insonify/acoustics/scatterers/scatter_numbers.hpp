#ifndef INSONIFY_ACOUSTICS_SCATTERERS_SCATTER_NUMBERS_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_SCATTER_NUMBERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/simd.hpp>

/// The contents of the cells of a `cell_field`: complex random numbers of mean power 1, computed from an index.
namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// One complex number per lane.
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

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
