#ifndef INSONIFY_B_MODE_HPP
#define INSONIFY_B_MODE_HPP

#include <insonify/acoustics/physical.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/refined.hpp>
#include <insonify/signal/convolve.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/tracing/trace.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What a B-mode looks like.
struct b_mode_settings {
    float depth = 0.08F;         ///< metres
    std::uint32_t samples = 0;   ///< along each line; 0: two for each deviation of the pulse
    uvec2 size{0, 0};            ///< columns, rows; see `scan_convert_settings`
    float dynamic_range_db = 60; ///< from black to white
    float reference_db = -25;    ///< the level that is white; 0 dB is the echo of a perfect mirror
    float gain_db = 0;           ///< added to every level
    float tgc = 0;               ///< dB/m at 1 MHz to make up for; 0: the background's, between 50 and 100
    std::uint32_t planes = 5;    ///< 1, 3, 5 or 7 slices that stand for the thickness of the beam
    float background = 0;        ///< grey beside the field of view
};

/// Rays for each line of a picture, so that they lie within half the beam's width at its focus; 4 at most.
template <transducer Probe>
std::uint32_t rays_per_line(const Probe& probe, float depth) {
    const beam_model beam = beam_of(probe, depth);
    const float rays = std::ceil(2 * line_spacing(probe, beam.focus) / beam.lateral_width(beam.focus));
    return static_cast<std::uint32_t>(clamped(rays, 1, 4));
}

/// What `b_mode` keeps from frame to frame: tables, and the memory of every stage.
template <transducer Probe, acoustic_model Model = physical<>>
struct b_mode_workspace {
    trace_workspace<refined<Probe>, Model> tracing{}; ///< of `trace`
    convolve_workspace convolution{};                 ///< of `convolve`
    kept_scan_map<refined<Probe>> map{};              ///< of `scan_convert`
    iq_lines echoes{};                                ///< as received
    scan_lines lines{};                               ///< greys
    image picture{};                                  ///< the last one
};

/// The whole chain in one call: a B-mode picture.
///
///     trace (physical) -> convolve (the probe's pulse and beam) -> envelope -> tgc -> log_compress -> scan_convert
///
/// The levels are fixed: a clip does not flicker. For a clip:
///
///     b_mode_workspace<linear_array> own;
///     for (;;) show(b_mode(exec::par_unseq, body, probe, at, settings, physical{}, own));
///
/// @param model  what happens at interfaces and between them
/// @param own    kept from frame to frame: then nothing is allocated after the first, and tables are made once
/// @return the picture, which is good until `own` is used again
/// @throws usage_error     for an unbuilt scene, senseless settings, absurd sizes
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model>
const image& b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                    const b_mode_settings& settings, const Model& model, b_mode_workspace<Probe, Model>& own) {
    static_assert(
        std::same_as<typename Model::sample_type, vec2>,
        "b_mode needs a model that makes complex echoes, such as physical; trace and scan_convert draw others");
    probe.check();
    if (!is_finite(settings.tgc) || !(settings.tgc >= 0))
        throw usage_error{"b_mode: `tgc` must be a finite number of dB/m at 1 MHz, or 0 for the background's"};
    const refined<Probe> fine{probe, rays_per_line(probe, settings.depth)};
    const pulse sent = nominal_pulse(probe);
    const std::uint32_t samples =
        settings.samples != 0 ? settings.samples : samples_for(settings.depth, sent.sigma_z(probe.frequency));
    own.echoes =
        trace(policy, body, fine, at, model, {.depth = settings.depth, .samples = samples, .planes = settings.planes},
              own.tracing, std::move(own.echoes));
    own.echoes = convolve(policy, std::move(own.echoes), sent, fine, {}, own.convolution);
    own.lines = envelope(policy, own.echoes, std::move(own.lines));
    own.lines = tgc(policy, std::move(own.lines), probe.frequency,
                    {.attenuation = settings.tgc > 0 ? settings.tgc : clamped(body.background().attenuation, 50, 100)});
    own.lines = log_compress(policy, std::move(own.lines),
                             {.dynamic_range_db = settings.dynamic_range_db,
                              .reference_db = settings.reference_db,
                              .gain_db = settings.gain_db});
    const scan_map& map = own.map(policy, fine, {.depth = settings.depth, .samples = samples},
                                  {.size = settings.size, .background = settings.background});
    own.picture = scan_convert(policy, own.lines, map, std::move(own.picture));
    return own.picture;
}
/// The same for a single picture.
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, acoustic_model Model = physical<>>
image b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
             const b_mode_settings& settings = {}, const Model& model = {}) {
    b_mode_workspace<Probe, Model> own;
    b_mode(policy, body, probe, at, settings, model, own);
    return std::move(own.picture);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
