#ifndef INSONIFY_ACOUSTICS_LAYER_HPP
#define INSONIFY_ACOUSTICS_LAYER_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/view.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// A stretch of one object along a line. Consecutive layers touch; the last one ends where the line does.
///
/// Two neighbours of equal media have equal `medium`: no interface lies between them.
struct layer {
    float begin = 0;            ///< metres from the face of the probe
    float end = 0;              ///< metres from the face of the probe
    std::uint32_t medium = 0;   ///< index into the media of the line
    std::uint32_t object = ~0U; ///< id of the object, ~0 for the background
    float cosine = 1;           ///< of the angle of incidence on the surface at `begin`; 1 on the first layer
};

/// One line as an acoustic model sees it: what it runs through, at what frequency.
struct traced_line {
    view<const layer> layers{};
    view<const medium> media{};
    float frequency = 0; ///< hertz
};

} // namespace insonify::inline INSONIFY_ABI
#endif
