#ifndef INSONIFY_PROBE_ACQUISITION_HPP
#define INSONIFY_PROBE_ACQUISITION_HPP

#include <insonify/core/math.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Whether lines can be this deep, in metres: from 1 nm to 1000 km. Beyond, sums and squares of lengths would overflow.
INSONIFY_FN inline bool is_depth(float depth) { return is_finite(depth) && depth >= 1e-9F && depth <= 1e6F; }

/// How deep to look and how finely to sample a line.
struct acquisition {
    float depth = 0.08F;       ///< metres, from 1 nm to 1000 km
    std::uint32_t samples = 0; ///< along each line; 0: chosen by the model
    std::uint32_t planes = 1;  ///< 1, 3, 5 or 7 parallel slices that stand for the thickness of the beam
};

} // namespace insonify::inline INSONIFY_ABI
#endif
