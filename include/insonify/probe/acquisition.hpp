#ifndef INSONIFY_PROBE_ACQUISITION_HPP
#define INSONIFY_PROBE_ACQUISITION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Depth and sampling of the scan lines.
struct acquisition {
    float depth = 0.08F;       ///< metres, at most 10
    std::uint32_t samples = 0; ///< depth samples of each line; 0: chosen by the model
    std::uint32_t planes = 1;  ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    std::uint32_t frame = 0;   ///< number of the frame: speckle of flowing media (`medium::flowing`) depends on it
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
