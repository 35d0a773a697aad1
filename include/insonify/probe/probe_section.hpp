#ifndef INSONIFY_PROBE_PROBE_SECTION_HPP
#define INSONIFY_PROBE_PROBE_SECTION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/memo.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Some neighbouring lines of a probe, with its face, field of view and beam.
template <transducer Probe>
struct probe_section : Probe {
    std::uint32_t lines = 1; ///< hides the member of the probe
    std::uint32_t first = 0; ///< line of the probe that is line 0 here

    /// @param begin, end  lines of the probe, without `end`
    probe_section(const Probe& probe, std::uint32_t begin, std::uint32_t end)
        : Probe{probe}, lines{end - begin}, first{begin} {}

    /// The line as a ray in the probe frame.
    INSONIFY_FN ray beam(float line) const { return Probe::beam(line + static_cast<float>(first)); }
    /// Of a probe that is `steered`: see there.
    INSONIFY_FN vec3 scatterer_axis(float line) const requires requires(const Probe& probe) {
        probe.scatterer_axis(0.0F);
    }
    { return Probe::scatterer_axis(line + static_cast<float>(first)); }
    /// From {x, z} to {line, depth along it}.
    INSONIFY_FN vec2 locate(vec2 point) const { return Probe::locate(point) - vec2{static_cast<float>(first), 0}; }

    friend bool operator==(const probe_section&, const probe_section&) requires detail::comparable<Probe>
    = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
