#ifndef INSONIFY_PROBE_PROBE_LINES_HPP
#define INSONIFY_PROBE_PROBE_LINES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/probe/transducer.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// One line of a probe, in the frame of the probe.
struct probe_line {
    vec3 origin{0, 0, 0};
    vec3 direction{0, 0, 1};      ///< of length 1
    vec3 scatterer_axis{0, 0, 1}; ///< that of `steered`; of other probes the direction

    friend bool operator==(const probe_line&, const probe_line&) = default;
};

/// What all lines of a probe have in common. Any probe converts to it.
struct probe_settings : stated_settings {
    bool full_circle = false; ///< see `is_full_circle`
    vec3 along{0, 0, 1};      ///< direction of the line in the centre of the field of view
    vec3 apart{0, 0, 0};      ///< from half a line to its left to half a line to its right: at the face, metres
    vec3 diverging{0, 0, 0};  ///< and how much further per metre of depth

    probe_settings() = default;
    /// @throws usage_error  for a setting out of range
    template <transducer Probe>
    probe_settings(const Probe& probe) : stated_settings{probe} {
        probe.check();
        check();
        full_circle = is_full_circle(probe);
        const float middle = 0.5F * static_cast<float>(probe.lines) - 0.5F;
        const ray left = probe.beam(middle - 0.5F), right = probe.beam(middle + 0.5F);
        along = probe.beam(middle).direction;
        apart = right.origin - left.origin;
        diverging = right.direction - left.direction;
    }

    /// See `line_spacing`.
    INSONIFY_FN float spacing(float depth) const {
        const vec3 between = apart + depth * diverging;
        const float chord = length(between - dot(between, along) * along);
        const float half_sine = 0.5F * length(diverging); // of half the angle between them
        return half_sine < 1e-3F ? chord : chord * std::asin(min(half_sine, 1)) / half_sine;
    }
    /// See `line_advance`.
    INSONIFY_FN float advance() const {
        const float forward = dot(apart, along);
        return lines < 2 || std::fabs(forward) < 1e-9F ? 0 : forward; // less is rounding
    }

    friend bool operator==(const probe_settings&, const probe_settings&) = default;
};

/// A probe as data: its lines and settings. What works on these is compiled once for all types of probe, and runs on a
/// device without their code. Any probe converts to it. Keeps its memory.
class probe_lines {
  public:
    probe_lines() = default;
    /// @throws usage_error  for a setting out of range
    template <transducer Probe>
    probe_lines(const Probe& probe) {
        assign(probe);
    }

    static constexpr std::uint32_t max_lines = 1U << 24U;

    /// @throws usage_error  for a setting out of range, or more than `max_lines` lines
    template <transducer Probe>
    void assign(const Probe& probe) {
        if (probe.lines > max_lines) throw usage_error{"probe: lines is ", probe.lines, "; at most 2^24 can be traced"};
        const probe_settings stated{probe};
        lines_.resize(probe.lines);
        for (std::uint32_t i = 0; i < probe.lines; ++i) {
            const ray beam = probe.beam(static_cast<float>(i));
            probe_line& own = lines_[i];
            own.origin = beam.origin;
            own.direction = own.scatterer_axis = beam.direction;
            if constexpr (requires { probe.scatterer_axis(0.0F); })
                own.scatterer_axis = probe.scatterer_axis(static_cast<float>(i));
        }
        settings_ = stated;
    }

    const probe_settings& settings() const { return settings_; }
    std::uint32_t size() const { return settings_.lines; }
    const probe_line& operator[](std::size_t line) const { return lines_[line]; }
    view<const probe_line> lines() const { return lines_; }

    friend bool operator==(const probe_lines&, const probe_lines&) = default;

  private:
    probe_settings settings_{};
    std::vector<probe_line> lines_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
