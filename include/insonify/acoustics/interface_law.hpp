#ifndef INSONIFY_ACOUSTICS_INTERFACE_LAW_HPP
#define INSONIFY_ACOUSTICS_INTERFACE_LAW_HPP

#include <insonify/acoustics/medium.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Sound that arrives at the border between two media.
struct incidence {
    medium before{};     ///< that the sound comes from
    medium after{};      ///< that it meets
    float cosine = 1;    ///< of the angle between the beam and the normal of the surface, 0 to 1
    float frequency = 0; ///< hertz
};

/// What becomes of it.
struct response {
    float reflected = 0;   ///< signed pressure amplitude of the echo, relative to what arrives
    float transmitted = 1; ///< share of an echo's amplitude that survives crossing there and back
};

/// How an interface reflects: `fresnel`, or one of your own. Called only where the medium changes.
template <class Law>
concept interface_law = requires(const Law& law, const incidence& at) {
    { law(at) } -> std::same_as<response>;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
