#ifndef INSONIFY_CORE_DECIBELS_HPP
#define INSONIFY_CORE_DECIBELS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cfloat>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// Below every level, in decibels: as the level of noise there is none, as a threshold it rejects nothing.
inline constexpr float no_level_db = -FLT_MAX;

namespace detail {

/// 2^x for constant expressions, in which std::exp2 is not allowed.
INSONIFY_FN constexpr float constant_exp2(double x) {
    if (!(x > -160)) return x < 0 ? 0.0F : static_cast<float>(x); // below every float; NaN
    if (!(x < 128)) return __builtin_huge_valf();
    const int whole = static_cast<int>(x < 0 ? x - 0.5 : x + 0.5);
    const double rest = 0.693147180559945309417 * (x - whole); // at most ln(2) / 2
    double term = 1, power = 1;
    for (int n = 1; n < 16; ++n) power += term *= rest / n; // Taylor's series of e^rest
    for (int n = 0; n < whole; ++n) power *= 2;
    for (int n = 0; n > whole; --n) power /= 2;
    return power > double{FLT_MAX} ? __builtin_huge_valf() : static_cast<float>(power);
}

} // namespace detail

/// Amplitude ratio of a level in decibels: 10^(level / 20). Also at compile time.
/// @{
INSONIFY_FN constexpr float amplitude_of_decibels(float level) {
    if (__builtin_is_constant_evaluated()) return detail::constant_exp2(0.166096404744368117394 * double{level});
    return std::exp2(0.16609640F * level); // log2(10) / 20
}
constexpr float amplitude_of_decibels(int level) {
    constexpr double step = 1.1220184543019634356; // 10^(1/20)
    double amplitude = 1;
    for (; level > 0; --level) amplitude *= step;
    for (; level < 0; ++level) amplitude /= step;
    return static_cast<float>(amplitude);
}
/// @}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
