#ifndef INSONIFY_CORE_RANDOM_HPP
#define INSONIFY_CORE_RANDOM_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cstdint>

/// Counter-based random numbers: hashes of a seed and an index, without state. Threads can compute them in any order.
namespace insonify::inline INSONIFY_ABI {

/// 64 random bits for one index of a stream.
/// Source: the finaliser of SplitMix64 (Steele, Lea & Flood 2014), applied twice.
INSONIFY_FN constexpr std::uint64_t hash_bits(std::uint64_t seed, std::uint64_t index) {
    const auto mix = [](std::uint64_t z) {
        z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
        return z ^ (z >> 31U);
    };
    return mix(mix(seed + 0x9E3779B97F4A7C15U) + (index + 1) * 0x9E3779B97F4A7C15U);
}

/// A 32-bit integer hash; cheaper than `hash_bits`, and suitable for SIMD.
/// Source: lowbias32, C. Wellons, 2018.
INSONIFY_FN constexpr std::uint32_t mix_bits(std::uint32_t h) {
    h = (h ^ (h >> 16U)) * 0x7FEB352DU;
    h = (h ^ (h >> 15U)) * 0x846CA68BU;
    return h ^ (h >> 16U);
}

/// A uniform random number in [0, 1), with 24 bits.
INSONIFY_FN constexpr float hash_uniform(std::uint64_t seed, std::uint64_t index) {
    return static_cast<float>(hash_bits(seed, index) >> 40U) * 0x1p-24F;
}

/// Two independent standard normal random numbers. Source: Box & Muller 1958.
INSONIFY_FN inline vec2 hash_normal(std::uint64_t seed, std::uint64_t index) {
    const std::uint64_t bits = hash_bits(seed, index);
    const float uniform = static_cast<float>((bits >> 40U) + 1) * 0x1p-24F; // above 0: its logarithm is finite
    const float radius = std::sqrt(-2 * std::log(uniform));
    const float angle = 2 * pi * static_cast<float>(bits & 0xFFFFFFU) * 0x1p-24F;
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
