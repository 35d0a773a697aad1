#ifndef INSONIFY_ACOUSTICS_INTERFACE_LAW_HPP
#define INSONIFY_ACOUSTICS_INTERFACE_LAW_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// A wave incident on the interface between two media.
struct incidence {
    medium before{};      ///< on the side of the incident wave
    medium after{};       ///< on the other side
    float cosine = 1;     ///< of the angle of incidence, 0 to 1
    float frequency = 0;  ///< hertz
    float roughness = -1; ///< rms height of the surface, metres; below 0: the larger one of the two media
};

/// Reflection at an interface, and the factor on echoes that cross it there and back.
struct response {
    float reflected = 0;   ///< signed pressure amplitude of the echo, relative to the incident wave
    float transmitted = 1; ///< fraction of an echo's amplitude that survives crossing there and back
};

/// An interface law: law(incidence) is the `response` of the interface. It is called only where the medium changes.
template <class Law>
concept interface_law = requires(const Law& law, const incidence& at) {
    { law(at) } -> std::same_as<response>;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
