#ifndef INSONIFY_EXAMPLES_LIVE_DOPPLER_HPP
#define INSONIFY_EXAMPLES_LIVE_DOPPLER_HPP

#include "probe.hpp"
#include "vessel.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace live {

/// What the scanner shows.
enum class mode : std::uint32_t { b, m, colour, power, pulsed };

/// The Doppler unit of the scanner: colour in a box, and the spectrum of a gate against time.
class doppler_unit {
  public:
    float scale = 0.3F;                                    ///< largest velocity that does not alias, m/s: sets the prf
    float gain_db = 0;                                     ///< of the colour: weaker echoes are shown
    float slowest = 0.02F;                                 ///< slower flow is not coloured, m/s
    float priority = 0.6F;                                 ///< brighter tissue stays gray
    vec2 box_middle{-9_mm, 17_mm}, box_size{16_mm, 14_mm}; ///< across, in depth
    vec2 gate{-9_mm, 17_mm};                               ///< middle of the gate: across, in depth
    float gate_length = 1.5_mm;
    float angle = 0;    ///< between line and flow, radians: the spectrum's velocities are divided by its cosine
    float baseline = 0; ///< of the spectrum, -0.5 to 0.5 of its range

    static constexpr std::uint32_t columns = 384, bins = 128; ///< of the spectrum; a column each tick of the session
    static constexpr std::uint32_t max_new_columns = 4;       ///< of a frame; the first of them stands for earlier ones

    float prf(const array_probe& probe) const { return 4 * probe.frequency * scale / 1540; }
    /// The line of the probe that runs through a point of the picture.
    static std::uint32_t line_at(const array_probe& probe, vec2 point) {
        return whole_line(probe, probe.locate(point).x);
    }

    /// A part of the picture along its lines: from the left to the right one, and in depth along them.
    struct line_box {
        float left = 0, right = 0, from = 0, to = 0;
    };
    /// The box within the picture. It is as wide as it says where its middle is.
    line_box box_in(const array_probe& probe, float depth) const {
        const vec2 middle = probe.locate(box_middle);
        const float millimetre = 1_mm / line_spacing(probe, std::clamp(middle.y, 0.0F, depth)); // in lines
        const float half = 0.5F * box_size.x / 1_mm * millimetre, last = static_cast<float>(probe.lines) - 0.5F;
        line_box box;
        box.left = std::clamp(middle.x - half, -0.5F, std::max(last - millimetre, -0.5F));
        box.right = std::clamp(middle.x + half, std::min(box.left + millimetre, last), last);
        box.from = std::clamp(middle.y - 0.5F * box_size.y, 0.0F, depth - 1_mm);
        box.to = std::clamp(middle.y + 0.5F * box_size.y, box.from + 1_mm, depth);
        return box;
    }
    /// The gate within the picture: its line, and its depth along it.
    vec2 gate_in(const array_probe& probe, float depth) const {
        const vec2 at = probe.locate(gate);
        return {std::clamp(at.x, 0.0F, static_cast<float>(probe.lines - 1)), std::clamp(at.y, 2_mm, depth - 1_mm)};
    }

    /// Velocities in the box, at the time of the last picture.
    template <exec::policy Policy>
    void acquire_colour(const Policy& policy, const scene& body, scanner<array_probe>& machine,
                        const blood_flow& flow) {
        probe_ = machine.probe;
        const line_box box = box_in(probe_, machine.settings.depth);
        const std::uint32_t first = whole_line(probe_, box.left), last = whole_line(probe_, box.right);
        seen_ = machine.colour(policy, body, flow,
                               {.prf = prf(probe_),
                                .box = {.from = box.from, .to = box.to, .first_line = first, .lines = last - first + 1},
                                .wall = {.order = 1},
                                .time = static_cast<float>(machine.time)});
    }
    template <exec::policy Policy>
    colour_image overlay(const Policy& policy, const image& gray, mode shown) const {
        return colour_overlay(policy, gray, seen_, probe_,
                              {.map = shown == mode::power ? doppler_map::power : doppler_map::velocity,
                               .min_power_db = -124 - gain_db,
                               .min_velocity = slowest,
                               .max_grey = priority});
    }
    bool has_colour() const { return seen_.count > 0; }
    const flow_lines& velocities() const { return seen_; }

    /// The next columns of the spectrum, which end at the time of the last picture.
    /// @param ticks  since the last ones, 1 or more
    template <exec::policy Policy>
    void acquire_spectrum(const Policy& policy, const scene& body, scanner<array_probe>& machine,
                          const blood_flow& flow, std::uint32_t ticks) {
        constexpr float tick = 1.0F / 120;
        const std::uint32_t wanted = std::min(ticks, max_new_columns), added = std::min(ticks, columns);
        const array_probe& probe = machine.probe;
        const vec2 middle = gate_in(probe, machine.settings.depth);
        const float rate = prf(probe), hop = tick * rate;
        const float overlap = std::clamp(1 - hop / bins, 0.0F, 0.96F);
        const doppler_spectrum next = machine.spectrum(
            policy, body, flow,
            {.line = whole_line(probe, middle.x),
             .gate = middle.y,
             .gate_length = gate_length,
             .prf = rate,
             .duration = (bins + static_cast<float>(wanted - 1) * std::round(bins * (1 - overlap)) + 1) / rate,
             .spectrum = {.window = bins, .overlap = overlap, .baseline = baseline, .angle = angle, .wall_order = 2},
             .time = static_cast<float>(machine.time)});
        if (strip_.size.x == 0) strip_ = image{{columns, bins}};
        if (next.windows == 0) return;
        const std::uint32_t newest = std::min(next.windows, wanted) - 1;
        for (std::uint32_t row = 0; row < bins; ++row) {
            float* const line = strip_.pixels.data() + std::size_t{row} * columns;
            std::copy(line + added, line + columns, line);
            for (std::uint32_t i = 0; i < added; ++i) { // from the newest back
                const std::uint32_t window = newest - std::min(i, newest);
                const float level = 10 * std::log10(next(window, bins - 1 - row) + 1e-20F);
                line[columns - 1 - i] = std::clamp((level + gain_db + 152) / 40, 0.0F, 1.0F);
            }
        }
        lowest_ = next.lowest_velocity;
        highest_ = next.lowest_velocity + next.step * static_cast<float>(bins);
    }
    const image& spectrum() const { return strip_; }
    vec2 spectrum_range() const { return {lowest_, highest_}; } ///< of the velocities of the spectrum, m/s

    /// Forgets the spectrum and the colours.
    void clear() {
        strip_ = image{{0, 0}};
        seen_ = {};
    }

  private:
    static std::uint32_t whole_line(const array_probe& probe, float line) {
        return static_cast<std::uint32_t>(std::clamp(std::round(line), 0.0F, static_cast<float>(probe.lines - 1)));
    }

    flow_lines seen_{};
    array_probe probe_{};
    image strip_{{0, 0}};
    float lowest_ = 0, highest_ = 0;
};

} // namespace live

#endif
