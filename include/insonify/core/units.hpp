#ifndef INSONIFY_CORE_UNITS_HPP
#define INSONIFY_CORE_UNITS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cfloat>
#include <cmath>

/// All public numbers are in SI units: metres, seconds, hertz, radians, kg/m^3, m/s, rayl (kg/(m^2 s)), dB/m. Literals
/// convert to them: `40_mm`, `7.5_MHz`, `60_deg`, `0.54_dB_per_cm`.
namespace insonify::inline INSONIFY_ABI::inline literals {

// clang-format off
#define INSONIFY_LITERAL(suffix, scale)                                                                                 \
    constexpr float operator""_##suffix(long double value) { return static_cast<float>(value * (scale)); }              \
    constexpr float operator""_##suffix(unsigned long long value) { return static_cast<float>(static_cast<long double>(value) * (scale)); }

INSONIFY_LITERAL(m, 1.0L)
INSONIFY_LITERAL(cm, 1e-2L)
INSONIFY_LITERAL(mm, 1e-3L)
INSONIFY_LITERAL(um, 1e-6L)
INSONIFY_LITERAL(s, 1.0L)
INSONIFY_LITERAL(ms, 1e-3L)
INSONIFY_LITERAL(us, 1e-6L)
INSONIFY_LITERAL(Hz, 1.0L)
INSONIFY_LITERAL(kHz, 1e3L)
INSONIFY_LITERAL(MHz, 1e6L)
INSONIFY_LITERAL(rad, 1.0L)
INSONIFY_LITERAL(deg, 3.14159265358979323846L / 180.0L)
INSONIFY_LITERAL(m_per_s, 1.0L)
INSONIFY_LITERAL(kg_per_m3, 1.0L)
INSONIFY_LITERAL(mmHg, 133.322387415L)
INSONIFY_LITERAL(Rayl, 1.0L)
INSONIFY_LITERAL(MRayl, 1e6L)
INSONIFY_LITERAL(dB_per_m, 1.0L)
INSONIFY_LITERAL(dB_per_cm, 100.0L)

#undef INSONIFY_LITERAL
// clang-format on

} // namespace insonify::inline INSONIFY_ABI::inline literals

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
INSONIFY_FN constexpr float amplitude_of_decibels(float level) {
    if (__builtin_is_constant_evaluated()) return detail::constant_exp2(0.166096404744368117394 * double{level});
    return std::exp2(0.16609640F * level); // log2(10) / 20
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
