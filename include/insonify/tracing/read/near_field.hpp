#ifndef INSONIFY_TRACING_READ_NEAR_FIELD_HPP
#define INSONIFY_TRACING_READ_NEAR_FIELD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/find/find_layers.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Echoes of the probe itself, at the top of a picture: reverberation between the face of the lens and its back, and
/// the ringing of the transducer.
struct near_field_settings {
    /// Which lines have these echoes.
    enum class lines {
        none,
        in_gas, ///< lines that start in gas: the reverberation alone, and nothing below it
        all     ///< the same, and on all lines ringing and the echo of the skin, which repeats once or twice
    };
    lines shown = lines::in_gas;    ///< which lines have them
    float lens_thickness = 0.6e-3F; ///< metres; the lines are 1540/1020 times as far apart. Convention: 0.5 to 1 mm
    float back_reflection = 0.5F;   ///< amplitude that the back of the lens reflects, 0 to below 1. Convention
    float ring_down_db = -30;       ///< level of the ringing at the face, `no_level_db`: none. Convention
    float ring_down = 1.5e-3F;      ///< displayed depth at which the ringing has lost 60 dB, metres. Convention

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        check_length(lens_thickness, "lens_thickness", max_aperture, "near_field");
        check_length(ring_down, "ring_down", max_scan_depth, "near_field");
        if (!(back_reflection >= 0 && back_reflection < 1))
            throw usage_error{"near_field: `back_reflection` must be at least 0 and below 1"};
        if (!is_finite(ring_down_db)) throw usage_error{"near_field: `ring_down_db` must be finite"};
    }

    friend bool operator==(const near_field_settings&, const near_field_settings&) = default;
};

namespace detail {

/// Where it is decided what the face touches, metres: thinner films do not count.
inline constexpr float below_face = 10e-6F;

} // namespace detail

/// Adds the echoes of the face of the probe to traced echoes, and removes the other echoes of lines that start in gas.
/// Call it between `trace` and `convolve`.
///
///     echo k = r (r b)^k 10^(-k loss/20)   at the displayed depth k d c0 / c,   k = 0, 1, 2, ...
///
/// with r the amplitude that the face reflects into the lens (from the impedances of `tissue::lens` and of the medium
/// 10 um below the face; 1 in gas), b = `back_reflection`, d and c the thickness and sound speed of the lens, c0 = 1540
/// m/s, and `loss` the attenuation in the lens, there and back, dB. Echoes below -120 dB are left out. The ringing is
/// `ring_down_db` - 60 dB z / `ring_down` at depth z, after `convolve` with the nominal pulse.
/// @param echoes  of the lines of the probe, at baseband
/// @param found   what lies along these lines
/// @throws usage_error  for lines that are not those of the probe, or a setting out of range
template <exec::policy Policy, transducer Probe>
iq_lines add_near_field(const Policy& policy, iq_lines echoes, const line_layers& found, const Probe& probe,
                        const near_field_settings& settings = {}) {
    using lines = near_field_settings::lines;
    settings.check();
    detail::check_layers(found, probe.lines, "add_near_field");
    detail::check_echoes(echoes, probe.lines, "add_near_field");
    if (settings.shown == lines::none || (settings.shown == lines::in_gas && !detail::has_gas(found.media)))
        return echoes;

    constexpr float faintest = 1e-6F;
    constexpr medium lens = tissue::lens;
    const float spacing = echoes.depth / static_cast<float>(echoes.samples);
    const float step = settings.lens_thickness * display_speed / lens.sound_speed;
    const float round_trip =
        settings.back_reflection * amplitude_of_decibels(-settings.lens_thickness * echo_loss(lens, probe.frequency));
    // Of a constant signal, `convolve` makes the sum of the pulse's samples times as much.
    const float sigma = nominal_pulse(probe).sigma_z(probe.frequency);
    const float ringing = amplitude_of_decibels(settings.ring_down_db) * spacing / (std::sqrt(2 * pi) * sigma);
    exec::for_each_in_blocks(policy, echoes.count, 8, 1000, [&](std::size_t i) {
        const view<vec2> line{echoes.values.data() + i * echoes.samples, echoes.samples};
        const view<const layer> layers = found(static_cast<std::uint32_t>(i));
        std::size_t touched = 0;
        while (touched + 1 < layers.size() && layers[touched].end <= detail::below_face) ++touched;
        const medium& below = found.media[layers[touched].medium];
        if (detail::is_gas(below))
            for (vec2& sample : line) sample = {0, 0};
        else if (settings.shown == lines::in_gas)
            return;
        const float face = detail::reflection(lens, below);
        const echo_line echo{line, spacing, probe.frequency};
        float amplitude = face;
        for (int k = 0; std::fabs(amplitude) > faintest && static_cast<float>(k) * step < echoes.depth; ++k) {
            echo.add(static_cast<float>(k) * step, {amplitude, 0});
            amplitude *= face * round_trip;
        }
        if (settings.shown != lines::all) return;
        for (std::uint32_t k = 0; k < echoes.samples; ++k) {
            const float depth = (static_cast<float>(k) + 0.5F) * spacing;
            if (depth > 2 * settings.ring_down) break;
            line[k] += vec2{ringing * amplitude_of_decibels(-60 * depth / settings.ring_down), 0};
        }
    });
    return echoes;
}
/// The same in a scene, whose layers are found.
/// @param at  probe to world
/// @throws usage_error, geometry_error  as above, and as `find_layers`
template <exec::policy Policy, transducer Probe>
iq_lines add_near_field(const Policy& policy, iq_lines echoes, const scene& body, const Probe& probe, const pose& at,
                        const near_field_settings& settings = {}) {
    settings.check();
    if (settings.shown == near_field_settings::lines::none) return echoes;
    return add_near_field(policy, std::move(echoes),
                          find_layers(policy, body, probe, at, {.depth = 2 * detail::below_face}), probe, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
