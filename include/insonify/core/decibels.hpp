#ifndef INSONIFY_CORE_DECIBELS_HPP
#define INSONIFY_CORE_DECIBELS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cfloat>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// Below every level, in decibels: as the level of noise there is none, as a threshold it rejects nothing.
inline constexpr float no_level_db = -FLT_MAX;

/// Amplitude ratio of a level in decibels: 10^(level / 20).
INSONIFY_FN inline float amplitude_of_decibels(float level) { return std::exp2(0.16609640F * level); } // log2(10) / 20

/// Amplitude ratio of an integer level in decibels; also at compile time.
constexpr float amplitude_of_decibels(int level) {
    constexpr double step = 1.1220184543019634356; // 10^(1/20)
    double amplitude = 1;
    for (; level > 0; --level) amplitude *= step;
    for (; level < 0; ++level) amplitude /= step;
    return static_cast<float>(amplitude);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
