#ifndef INSONIFY_PROBE_ACQUISITION_HPP
#define INSONIFY_PROBE_ACQUISITION_HPP

#include <insonify/core/config.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// How deep to look and how finely to sample a line.
struct acquisition {
    float depth = 0.08F;       ///< metres
    std::uint32_t samples = 0; ///< along each line; 0: chosen by the model
    std::uint32_t planes = 1;  ///< 1, 3, 5 or 7 parallel slices that stand for the thickness of the beam
};

} // namespace insonify::inline INSONIFY_ABI
#endif
