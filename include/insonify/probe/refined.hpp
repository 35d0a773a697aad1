#ifndef INSONIFY_PROBE_REFINED_HPP
#define INSONIFY_PROBE_REFINED_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/memo.hpp>
#include <insonify/probe/transducer.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// A probe with another number of lines, usually more: the same face, field of view and beam with finer lateral sampling.
template <transducer Probe>
struct refined : Probe {
    std::uint32_t lines = 1; ///< hides the member of the probe: about `rays` times as many
    float rays = 1;          ///< lines for each line of the probe, need not be whole

    /// @param rays_per_line  above 0; the number of lines is rounded
    refined(const Probe& probe, float rays_per_line)
        : Probe{probe}, lines{static_cast<std::uint32_t>(std::lround(static_cast<float>(probe.lines) * rays_per_line))},
          rays{static_cast<float>(lines) / static_cast<float>(probe.lines)} {}

    /// The line as a ray in the probe frame.
    INSONIFY_FN ray beam(float line) const { return Probe::beam(coarse(line)); }
    /// Of a probe that is `steered`: see there.
    INSONIFY_FN vec3 scatterer_axis(float line) const requires requires(const Probe& probe) {
        probe.scatterer_axis(0.0F);
    }
    { return Probe::scatterer_axis(coarse(line)); }
    /// From {x, z} to {line, depth along it}.
    INSONIFY_FN vec2 locate(vec2 point) const {
        const vec2 place = Probe::locate(point);
        return {(place.x + 0.5F) * rays - 0.5F, place.y};
    }

    friend bool operator==(const refined&, const refined&) requires detail::comparable<Probe>
    = default;

  private:
    INSONIFY_FN float coarse(float line) const { return (line + 0.5F) / static_cast<float>(rays) - 0.5F; }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
