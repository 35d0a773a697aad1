#ifndef INSONIFY_ACOUSTICS_SCATTER_NUMBERS_HPP
#define INSONIFY_ACOUSTICS_SCATTER_NUMBERS_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/execution/simd_bits.hpp>

/// What the cells of a `cell_field` hold: complex numbers of mean power 1, found from an index alone.
namespace insonify::inline INSONIFY_ABI {

/// Complex numbers, one a lane.
template <int N>
struct complex_lanes {
    lanes<N> real{};      ///< one a lane
    lanes<N> imaginary{}; ///< one a lane
};

/// Very many scatterers to a resolution cell: their sum is a complex Gaussian, the envelope Rayleigh distributed.
struct gaussian_numbers {
    /// @param index  of the cells
    template <int N>
    INSONIFY_FN INSONIFY_INLINE complex_lanes<N> operator()(const bit_lanes<N>& index, float, float) const {
        // Each part the sum of two uniform numbers of 8 bits, mean 0, variance 1/2: the Gauss curve comes of the sums
        // that follow. Both sums at once, in the halves of a word.
        constexpr float scale = 0.0067658736F; // sqrt(1/2) over the deviation of the sum, sqrt(2 (256^2 - 1) / 12)
        constexpr std::uint32_t bytes = 0x00FF00FFU;
        const bit_lanes<N> bits = mix_lanes<N>(index);
        const bit_lanes<N> sums = (bits & bytes) + ((bits >> 8) & bytes);
        const auto part = [&](const bit_lanes<N>& sum) {
            return multiply_add(floats_of<N>(sum), lanes<N>(scale), lanes<N>(-255 * scale));
        };
        return {part(sums & 0xFFFFU), part(sums >> 16)};
    }

    friend bool operator==(const gaussian_numbers&, const gaussian_numbers&) = default;
};

/// Countable scatterers of normally distributed strength and random phase, as many to a volume as Poisson's distribution
/// says.
struct poisson_numbers {
    float density = 20e9F; ///< scatterers in a cubic metre, of media that state none: 20 in a cubic millimetre

    /// @throws usage_error  where there are none
    void check() const {
        if (!is_finite(density) || !(density > 0))
            throw usage_error{
                "poisson_numbers: `density` must be a finite number above 0; `no_scatterers` is no texture"};
    }

    /// @param volume  of a cell, m^3
    /// @param stated  the medium's scatterers in a cubic metre; 0: `density`
    template <int N>
    INSONIFY_FN complex_lanes<N> operator()(const bit_lanes<N>& index, float volume, float stated) const {
        const float mean = (stated > 0 ? stated : density) * volume;
        if (mean > 32) return gaussian_numbers{}.operator()<N>(index, volume, stated); // nobody could tell them apart
        std::uint32_t each[N];
        store_bits<N>(index, each);
        float real[N], imaginary[N];
        for (int i = 0; i < N; ++i) {
            const vec2 sum = of_cell(each[i], mean);
            real[i] = sum.x;
            imaginary[i] = sum.y;
        }
        return {load<N>(real), load<N>(imaginary)};
    }

    friend bool operator==(const poisson_numbers&, const poisson_numbers&) = default;

  private:
    INSONIFY_FN static vec2 of_cell(std::uint32_t index, float mean) {
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

} // namespace insonify::inline INSONIFY_ABI
#endif
