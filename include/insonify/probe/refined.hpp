#ifndef INSONIFY_PROBE_REFINED_HPP
#define INSONIFY_PROBE_REFINED_HPP

#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A probe with every line divided into `rays`: the same face, field and beam, sampled more finely.
template <transducer Probe>
struct refined : Probe {
    std::uint32_t lines = 1; ///< hides that of the probe: rays times as many
    std::uint32_t rays = 1;  ///< for each line of the probe

    /// @param rays_per_line  1 or more
    refined(const Probe& probe, std::uint32_t rays_per_line)
        : Probe{probe}, lines{probe.lines * rays_per_line}, rays{rays_per_line} {}

    /// Ray `line` in the frame of the probe.
    INSONIFY_FN ray beam(float line) const { return Probe::beam((line + 0.5F) / static_cast<float>(rays) - 0.5F); }
    /// From {x, z} to {ray, metres along it}.
    INSONIFY_FN vec2 locate(vec2 point) const {
        const vec2 place = Probe::locate(point);
        return {(place.x + 0.5F) * static_cast<float>(rays) - 0.5F, place.y};
    }

    friend bool operator==(const refined&, const refined&) = default;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
