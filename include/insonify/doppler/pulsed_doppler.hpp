#ifndef INSONIFY_DOPPLER_PULSED_DOPPLER_HPP
#define INSONIFY_DOPPLER_PULSED_DOPPLER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/colour_doppler.hpp>
#include <insonify/doppler/doppler_spectrum.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Settings of pulsed Doppler, as on a scanner.
struct pulsed_doppler_settings {
    std::uint32_t line = 0;       ///< of the probe
    float gate = 0.02F;           ///< depth of the middle of the gate along the line, metres
    float gate_length = 1e-3F;    ///< metres
    float prf = 5e3F;             ///< pulse repetition frequency, hertz
    float duration = 1;           ///< of the acquisition, seconds
    spectrum_settings spectrum{}; ///< windows, baseline and angle
    float burst = 6;              ///< length of the excitation, in cycles
    float depth = 0;              ///< of the image, which chooses the focus, metres; 0: twice the depth of the gate
    std::uint32_t planes = 1;     ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float time = 0;               ///< of the first pulse, seconds: the same time gives the same spectrum
    float noise_db = -135;        ///< electronic noise: see `electronic_noise_settings`
    std::uint64_t seed = 1;       ///< of the noise

    /// @throws usage_error  for a setting out of range
    template <transducer Probe>
    void check(const Probe& probe) const {
        probe.check();
        spectrum.check();
        if (line >= probe.lines)
            throw usage_error{detail::joined({"pulsed_doppler: line ", std::to_string(line),
                                              " is not one of the probe, which has ", std::to_string(probe.lines)})};
        check_length(gate, "gate", max_scan_depth, "pulsed_doppler");
        check_length(gate_length, "gate_length", max_scan_depth, "pulsed_doppler");
        if (depth != 0) check_depth(depth, "pulsed_doppler");
        if (depth != 0 && gate - 0.5F * gate_length >= depth)
            throw usage_error{detail::joined({"pulsed_doppler: the gate is ", detail::number_text(gate * 1e3F),
                                              " mm deep, below the end of the image at ",
                                              detail::number_text(depth * 1e3F), " mm; raise it, or `depth`"})};
        if (!is_finite(duration) || !(duration * prf >= 1 && duration * prf <= 0x1p20F))
            throw usage_error{"pulsed_doppler: `duration` times `prf` must be 1 to 2^20 pulses; 1_s at 5_kHz is usual"};
    }
};

/// `gate_echoes` and `pulsed_doppler`, series after series: holds tables and memory, so that it allocates only while buffers grow.
template <transducer Probe, acoustic_model Model = physical<>>
class gate_scanner {
  public:
    /// See `insonify::gate_echoes`.
    template <exec::policy Policy, velocity_field Field>
    std::vector<vec2> gate_echoes(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                  const Model& model, const Field& field, const pulsed_doppler_settings& settings) {
        settings.check(probe);
        const float depth = settings.depth > 0 ? settings.depth : 2 * settings.gate;
        const refined<Probe> fine = detail::doppler_probe(probe, depth, model);
        const auto margin = detail::beam_margin(fine, depth);
        const auto line = static_cast<std::uint32_t>((static_cast<float>(settings.line) + 0.5F) * fine.rays);
        const std::uint32_t begin = line > margin ? line - margin : 0, end = std::min(line + margin + 1, fine.lines);
        const probe_section<refined<Probe>> lines{fine, begin, end};

        pulse sent = nominal_pulse(probe);
        const float sigma = sent.sigma_z(probe.frequency),
                    spacing = depth / static_cast<float>(samples_for(depth, sigma));
        sent.burst = settings.burst;
        const float from = max(settings.gate - 0.5F * settings.gate_length, 0), to = from + settings.gate_length;
        const float beyond = sent.envelope(probe.frequency).half_length();
        const auto samples = static_cast<std::uint32_t>(std::ceil((to + beyond) / spacing));
        const auto first = static_cast<std::uint32_t>(from / spacing),
                   last = std::min(samples, static_cast<std::uint32_t>(to / spacing) + 1);
        const auto pulses = static_cast<std::uint32_t>(settings.duration * settings.prf);
        const std::uint32_t parts = (pulses + 255) / 256; // each of a few megabytes
        const std::uint32_t part = (pulses + parts - 1) / parts;
        std::vector<vec2> series;
        series.reserve(pulses);
        for (std::uint32_t k = 0; k < pulses; k += part) {
            const iq_ensemble& echoes = train_.acquire(policy, body, lines, at, model, field,
                                                       {.depth = static_cast<float>(samples) * spacing,
                                                        .samples = samples,
                                                        .prf = settings.prf,
                                                        .pulses = std::min(part, pulses - k),
                                                        .first = k,
                                                        .from = max(from - beyond, 0),
                                                        .burst = settings.burst,
                                                        .planes = settings.planes,
                                                        .time = settings.time,
                                                        .noise_db = settings.noise_db,
                                                        .seed = settings.seed});
            for (const iq_lines& each : echoes.pulses) {
                vec2 sum{0, 0};
                for (std::uint32_t i = first; i < last; ++i) sum += each(line - begin, i);
                series.push_back(sum / static_cast<float>(last - first));
            }
        }
        return series;
    }

    /// See `pulsed_doppler`.
    template <exec::policy Policy, velocity_field Field>
    doppler_spectrum acquire(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                             const Model& model, const Field& field, const pulsed_doppler_settings& settings) {
        return spectrum_of(policy, gate_echoes(policy, body, probe, at, model, field, settings), settings.prf,
                           max_doppler_velocity(settings.prf, probe.frequency), settings.time, settings.spectrum);
    }

  private:
    ensemble_scanner<probe_section<refined<Probe>>, Model> train_{};
};

/// The echoes of a gate on one line, pulse after pulse: the sum over the gate, a mean of its samples.
/// @return the series, from which `spectrum_of` computes a spectrum
/// @throws usage_error, geometry_error  as `pulsed_doppler`
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
std::vector<vec2> gate_echoes(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                              const Model& model, const Field& field, const pulsed_doppler_settings& settings) {
    return gate_scanner<Probe, Model>{}.gate_echoes(policy, body, probe, at, model, field, settings);
}
/// The same with `physical`.
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, velocity_field Field>
std::vector<vec2> gate_echoes(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                              const Field& field, const pulsed_doppler_settings& settings) {
    return gate_echoes(policy, body, probe, at, physical<>{}, field, settings);
}

/// Pulsed Doppler: the spectrum of a gate on one line against time.
///
///     doppler_ensemble -> sum over the gate -> spectrum_of
///
/// Velocities are along the line, towards the probe positive, or along the flow where `spectrum.angle` says how it runs.
///
///     const doppler_spectrum seen = pulsed_doppler(exec::par_unseq, body, probe, at, stream,
///                                                  {.line = 64, .gate = 22_mm, .spectrum = {.angle = 60_deg}});
///
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
doppler_spectrum pulsed_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const Model& model, const Field& field, const pulsed_doppler_settings& settings = {}) {
    return gate_scanner<Probe, Model>{}.acquire(policy, body, probe, at, model, field, settings);
}
/// The same with `physical`.
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, velocity_field Field>
doppler_spectrum pulsed_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const Field& field, const pulsed_doppler_settings& settings = {}) {
    return pulsed_doppler(policy, body, probe, at, physical<>{}, field, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
