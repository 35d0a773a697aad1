#ifndef INSONIFY_B_MODE_HPP
#define INSONIFY_B_MODE_HPP

#include <insonify/acoustics/physical.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/plausible.hpp>
#include <insonify/probe/refined.hpp>
#include <insonify/signal/compound.hpp>
#include <insonify/signal/convolve.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/tracing/trace.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Settings of a B-mode image, as on a scanner.
struct b_mode_settings {
    float depth = 0.08F;         ///< metres
    std::uint32_t samples = 0;   ///< depth samples of each line; 0: two per standard deviation of the pulse envelope
    uvec2 size{0, 0};            ///< columns, rows; see `scan_convert_settings`
    float dynamic_range_db = 60; ///< range of levels from black to white
    float reference_db = -25;    ///< level of white; 0 dB is the echo of a perfect mirror
    float gain_db = 0;           ///< added to every level
    float tgc = 0; ///< attenuation to compensate for, dB/m at 1 MHz; 0: that of the background, clamped to 50 to 100
    std::uint32_t planes = 5;     ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float background = 0;         ///< brightness of the pixels outside the field of view
    compound_settings compound{}; ///< looks at several angles, averaged; none by default
};

/// Number of traced rays per line, so that their distance at the focus is at most half the beam width; at most 4.
template <transducer Probe>
std::uint32_t rays_per_line(const Probe& probe, float depth) {
    const beam_model beam = beam_of(probe, depth);
    const float rays = std::ceil(2 * line_spacing(probe, beam.focus) / beam.lateral_width(beam.focus));
    return static_cast<std::uint32_t>(clamp(rays, 1, 4));
}

namespace detail {

/// The model and the time gain that looks were acquired with. Models that cannot be compared count as the same.
template <class Model>
using looks_of = std::conditional_t<comparable<Model>, memo<char, Model, float>, memo<char, float>>;

} // namespace detail

/// Tables and memory of `b_mode`, kept from frame to frame.
template <transducer Probe, acoustic_model Model = physical<>, class Tracer = straight_lines>
struct b_mode_workspace {
    trace_workspace<steered<refined<Probe>>, Model, Tracer> tracing{};       ///< of `trace`
    std::vector<detail::frame_plan<steered<refined<Probe>>, Model>> plans{}; ///< of `trace`, for each look
    convolve_workspace convolution{};                                        ///< of `convolve`
    compounding<refined<Probe>> looks{};                                     ///< the last looks
    detail::looks_of<Model> acquired{};                                      ///< model and time gain of the looks
    kept_scan_map<refined<Probe>> map{};                                     ///< of `scan_convert`
    iq_lines echoes{};                                                       ///< received echoes
    scan_lines lines{};                                                      ///< brightness
    image picture{};                                                         ///< the last image
};

/// Simulates a B-mode image: the whole chain in one call.
///
///     trace (physical) -> convolve (the probe's pulse and beam) -> envelope -> tgc -> compounding -> log_compress
///         -> scan_convert
///
/// The levels are fixed, so clips do not flicker. For a clip:
///
///     b_mode_workspace<linear_array> own;
///     for (;;) show(b_mode(exec::par_unseq, body, probe, at, settings, physical{}, own));
///
/// @param model  acoustics of interfaces and media
/// @param own    tables and memory; pass it again with the next frame to avoid allocations
/// @param how    how sound travels: `straight_lines`, `paths`, or your own (`tracer`)
/// @return the image, valid until `own` is used again
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, tracer<Model> Tracer>
const image& b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                    const b_mode_settings& settings, const Model& model, b_mode_workspace<Probe, Model, Tracer>& own,
                    const Tracer& how = {}) {
    static_assert(
        std::same_as<typename Model::sample_type, vec2>,
        "b_mode needs a model that makes complex echoes, such as physical; trace and scan_convert draw others");
    probe.check();
    check_depth(settings.depth, "b_mode");
    if (!is_finite(settings.tgc) || !(settings.tgc >= 0))
        throw usage_error{"b_mode: `tgc` must be a finite number of dB/m at 1 MHz, or 0 for the background's"};
    const refined<Probe> fine{probe, rays_per_line(probe, settings.depth)};
    const pulse sent = nominal_pulse(probe);
    const std::uint32_t samples =
        settings.samples != 0 ? settings.samples : samples_for(settings.depth, sent.sigma_z(probe.frequency));
    const tgc_settings gain{.attenuation =
                                settings.tgc > 0 ? settings.tgc : clamp(body.background().attenuation, 50, 100)};
    const auto acquire = [&](std::uint32_t number, const steered<refined<Probe>>& look, const acquisition& scan,
                             scan_lines recycled) {
        std::swap(own.tracing.plan, own.plans[number]);
        own.echoes = trace(policy, body, look, at, model, scan, own.tracing, std::move(own.echoes), how);
        std::swap(own.tracing.plan, own.plans[number]);
        own.echoes = convolve(policy, std::move(own.echoes), sent, look, {}, own.convolution);
        return tgc(policy, envelope(policy, own.echoes, std::move(recycled)), probe.frequency, gain);
    };
    settings.compound.check();
    own.plans.resize(settings.compound.angles);
    const auto forget = [&](char&) { own.looks.reset(); };
    if constexpr (detail::comparable<Model>)
        own.acquired(forget, model, gain.attenuation);
    else
        own.acquired(forget, gain.attenuation);
    own.lines = own.looks(policy, fine, {.depth = settings.depth, .samples = samples, .planes = settings.planes},
                          settings.compound, acquire, std::move(own.lines));
    own.lines = log_compress(policy, std::move(own.lines),
                             {.dynamic_range_db = settings.dynamic_range_db,
                              .reference_db = settings.reference_db,
                              .gain_db = settings.gain_db});
    const scan_map& map = own.map(policy, fine, {.depth = settings.depth, .samples = samples},
                                  {.size = settings.size, .background = settings.background});
    own.picture = scan_convert(policy, own.lines, map, std::move(own.picture));
    return own.picture;
}
/// The same for a single image.
///
///     b_mode(exec::par_unseq, body, probe, at, {.depth = 40_mm}, physical{}, paths{});
///
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, acoustic_model Model = physical<>,
          tracer<Model> Tracer = straight_lines>
image b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
             const b_mode_settings& settings = {}, const Model& model = {}, const Tracer& how = {}) {
    b_mode_workspace<Probe, Model, Tracer> own;
    b_mode(policy, body, probe, at, settings, model, own, how);
    return std::move(own.picture);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
