#ifndef INSONIFY_CORE_UNITS_HPP
#define INSONIFY_CORE_UNITS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>

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

#include <insonify/core/restore_macros.hpp>

#endif
