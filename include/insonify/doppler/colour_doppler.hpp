#ifndef INSONIFY_DOPPLER_COLOUR_DOPPLER_HPP
#define INSONIFY_DOPPLER_COLOUR_DOPPLER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/autocorrelation.hpp>
#include <insonify/doppler/doppler_ensemble.hpp>
#include <insonify/probe/transducer.hpp>
#include <algorithm>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// The part of the field of view in which velocities are measured. By default all of it.
struct colour_box {
    float from = 0;               ///< depth, metres
    float to = 0;                 ///< depth, metres; 0: the end of the lines
    std::uint32_t first_line = 0; ///< of the probe
    std::uint32_t lines = 0;      ///< their number; 0: to the last one

    friend bool operator==(const colour_box&, const colour_box&) = default;
};

/// Settings of colour and power Doppler, as on a scanner.
struct doppler_settings {
    float depth = 0.08F;          ///< metres
    float prf = 4e3F;             ///< pulse repetition frequency, hertz: sets the largest velocity, c0 prf / (4 f0)
    std::uint32_t ensemble = 8;   ///< pulses along each line
    colour_box box{};             ///< where velocities are measured
    wall_filter wall{};           ///< removes tissue
    float average_length = 1e-3F; ///< of the autocorrelation along the lines, metres
    float average_lines = 2;      ///< and across them, in lines of the probe
    float burst = 4;              ///< length of the excitation, in cycles
    std::uint32_t planes = 1;     ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float time = 0;               ///< of the first pulse, seconds: the same time gives the same picture
    float noise_db = -135;        ///< electronic noise: see `electronic_noise_settings`
    std::uint64_t seed = 1;       ///< of the noise

    /// @throws usage_error  for a setting out of range
    template <transducer Probe>
    void check(const Probe& probe) const {
        probe.check();
        check_depth(depth, "colour_doppler");
        wall.check(ensemble);
        if (ensemble < 2) throw usage_error{"colour_doppler: `ensemble` must be at least 2 pulses; 8 to 16 are usual"};
        if (!is_finite(average_length) || !(average_length >= 0) || !(average_lines >= 0 && average_lines <= 1000))
            throw usage_error{"colour_doppler: `average_length` must be 0 or more metres, such as 1_mm, and "
                              "`average_lines` 0 or more lines, such as 2"};
        if (box.first_line >= probe.lines || box.lines > probe.lines - box.first_line)
            throw usage_error{detail::joined({"colour_doppler: the box must lie in the ", std::to_string(probe.lines),
                                              " lines of the probe; lower `first_line` or `lines`"})};
        if (!(box.from >= 0 && box.from < (box.to > 0 ? box.to : depth)) || !(box.to >= 0 && box.to <= depth))
            throw usage_error{"colour_doppler: the box must begin above its end, and end within the depth"};
    }
};

namespace detail {

/// The probe with the focus that it has at the whole depth, and enough lines: at the focus they are no further apart than
/// half the beam width, and than two thirds of a cell of scatterers. Coarser lines sample what passes them so rarely that
/// its spectrum repeats, -7 dB at 1.3 cells and -25 dB at two thirds.
template <transducer Probe, class Model>
refined<Probe> doppler_probe(const Probe& probe, float depth, const Model& model) {
    float rays = rays_per_line(probe, depth);
    if constexpr (requires { model.scattering.cell; })
        rays = max(rays, min(1.5F * line_spacing(probe, beam_of(probe, depth).focus) / model.scattering.cell, 8));
    refined<Probe> fine{probe, rays};
    if constexpr (requires { fine.focus; })
        if (fine.focus == 0) fine.focus = depth / 2;
    return fine;
}

/// Lines on either side that reach a line through the beam.
template <transducer Probe>
std::uint32_t beam_margin(const Probe& probe, float depth) {
    const lateral_kernel kernel = make_lateral_kernel(probe, {.depth = depth, .samples = 64});
    return static_cast<std::uint32_t>(kernel.half_width());
}

} // namespace detail

/// `colour_doppler`, frame after frame: holds tables and memory, so that it allocates only while buffers grow.
template <transducer Probe, acoustic_model Model = physical<>>
class colour_scanner {
  public:
    /// See `colour_doppler`.
    template <exec::policy Policy, velocity_field Field>
    flow_lines acquire(const Policy& policy, const scene& body, const Probe& probe, const pose& at, const Model& model,
                       const Field& field, const doppler_settings& settings) {
        constexpr std::uint32_t decimation = 8;
        settings.check(probe);
        const refined<Probe> fine = detail::doppler_probe(probe, settings.depth, model);
        const std::uint32_t box_end =
            settings.box.lines == 0 ? probe.lines : settings.box.first_line + settings.box.lines;
        const float reach = 0.5F * settings.average_lines;
        const auto margin = static_cast<float>(detail::beam_margin(fine, settings.depth));
        const auto fine_line = [&](float line) { return (line + 0.5F) * fine.rays - 0.5F; };
        const auto whole = [&](float line) {
            return static_cast<std::uint32_t>(clamp(line, 0, static_cast<float>(fine.lines)));
        };
        const std::uint32_t begin = whole(fine_line(static_cast<float>(settings.box.first_line) - reach) - margin),
                            end = whole(std::ceil(fine_line(static_cast<float>(box_end - 1) + reach) + margin) + 1);
        const probe_section<refined<Probe>> lines{fine, begin, end};

        pulse sent = nominal_pulse(probe);
        const std::uint32_t samples = samples_for(settings.depth, sent.sigma_z(probe.frequency));
        sent.burst = settings.burst;
        const float spacing = settings.depth / static_cast<float>(samples);
        const float box_to = settings.box.to > 0 ? settings.box.to : settings.depth;
        const float beyond = sent.envelope(probe.frequency).half_length() + settings.average_length,
                    last = box_to + beyond;
        const std::uint32_t traced =
            std::min(samples, decimation * static_cast<std::uint32_t>(std::ceil(last / spacing / decimation)));
        const iq_ensemble& echoes = train_.acquire(policy, body, lines, at, model, field,
                                                   {.depth = static_cast<float>(traced) * spacing,
                                                    .samples = traced,
                                                    .prf = settings.prf,
                                                    .pulses = settings.ensemble,
                                                    .from = max(settings.box.from - beyond, 0),
                                                    .burst = settings.burst,
                                                    .planes = settings.planes,
                                                    .time = settings.time,
                                                    .noise_db = settings.noise_db,
                                                    .seed = settings.seed});
        filtered_ = filter_walls(policy, echoes, settings.wall, std::move(filtered_));
        const auto length = static_cast<std::uint32_t>(max(settings.average_length / spacing, 1));
        correlated_ = autocorrelate(policy, filtered_, length, decimation, std::move(correlated_));

        flow_lines result;
        result.reshape(probe.lines, samples / decimation, settings.depth);
        result.max_velocity = max_doppler_velocity(settings.prf, probe.frequency);
        const float step = spacing * decimation;
        for_each_index(policy, probe.lines, [&](std::size_t i) {
            const auto line = static_cast<std::uint32_t>(i);
            if (line < settings.box.first_line || line >= box_end) return;
            const float middle = fine_line(static_cast<float>(line)) - static_cast<float>(begin),
                        width = max(reach * fine.rays, 0.5F) + 0.5F;
            for (std::uint32_t k = 0; k < correlated_.samples; ++k) {
                const float depth = (static_cast<float>(k) + 0.5F) * step;
                if (depth < settings.box.from || depth > box_to) continue;
                autocorrelation sum;
                float weights = 0;
                for (std::uint32_t j = 0; j < lines.lines; ++j) {
                    const float weight = 1 - std::fabs(static_cast<float>(j) - middle) / width;
                    if (!(weight > 0)) continue;
                    sum.power += weight * correlated_(j, k).power;
                    sum.lag_one += weight * correlated_(j, k).lag_one;
                    weights += weight;
                }
                result(line, k) = flow_of({sum.power / weights, sum.lag_one / weights}, result.max_velocity);
            }
        });
        return result;
    }

  private:
    ensemble_scanner<probe_section<refined<Probe>>, Model> train_{};
    iq_ensemble filtered_{};             // after the wall filter
    autocorrelation_lines correlated_{}; // on the traced lines
};

/// Colour Doppler: velocity, power and variance of what moves, along the lines of the probe.
///
///     doppler_ensemble -> filter_walls -> autocorrelate -> average across the lines -> flow_of
///
/// The result has the lines of the probe and an eighth of the samples of a B-mode; 0 outside the box. Velocities are
/// those that a scanner displays: along the line, for the sound speed c0, and aliased above c0 prf / (4 f0).
///
///     const flow_lines seen = colour_doppler(exec::par_unseq, body, probe, at, stream, {.depth = 40_mm, .prf = 6_kHz});
///
/// @param field  velocities of blood and tissue, such as `poiseuille`
/// @param model  acoustics of interfaces and media
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
flow_lines colour_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                          const Model& model, const Field& field, const doppler_settings& settings = {}) {
    return colour_scanner<Probe, Model>{}.acquire(policy, body, probe, at, model, field, settings);
}
/// The same with `physical`.
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, velocity_field Field>
flow_lines colour_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                          const Field& field, const doppler_settings& settings = {}) {
    return colour_doppler(policy, body, probe, at, physical<>{}, field, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
