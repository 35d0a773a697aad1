#ifndef INSONIFY_DOPPLER_DOPPLER_ENSEMBLE_HPP
#define INSONIFY_DOPPLER_DOPPLER_ENSEMBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/slow_time.hpp>
#include <insonify/doppler/trace_ensemble.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/electronic_noise.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// How `doppler_ensemble` acquires the echoes of a pulse train.
struct ensemble_settings {
    float depth = 0.08F;       ///< metres
    std::uint32_t samples = 0; ///< depth samples of each line; 0: two per standard deviation of the shortest pulse
    float prf = 4e3F;          ///< pulse repetition frequency, hertz
    std::uint32_t pulses = 8;  ///< number of pulses along each line
    std::uint32_t first = 0;   ///< the first of them, where a long train is acquired in parts
    float from = 0;            ///< depth from which moving scatterers are needed, metres
    float burst = 4;           ///< length of the excitation in cycles: see `pulse`
    std::uint32_t planes = 1;  ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float time = 0;            ///< of pulse 0, seconds: the same time gives the same echoes
    float noise_db = -135;     ///< see `electronic_noise_settings`
    std::uint64_t seed = 1;    ///< of the noise

    /// @throws usage_error  for a setting out of range
    void check() const {
        check_depth(depth, "doppler");
        if (!is_finite(prf) || !(prf >= 1 && prf <= 1e6F))
            throw usage_error{"doppler: the prf is " + detail::number_text(prf) +
                              " Hz; it must be 1 Hz to 1 MHz, such as 4_kHz"};
        if (pulses < 1 || pulses > 1U << 20U || first > 1U << 24U)
            throw usage_error{"doppler: the number of pulses must be 1 to 2^20; 8 to 16 are usual for colour"};
        detail::check_planes(planes, "doppler");
        if (!is_finite(time)) throw usage_error{"doppler: `time` must be a finite number of seconds"};
    }
};

/// `doppler_ensemble`, train after train: holds tables and memory, so that it allocates only while buffers grow.
template <transducer Probe, acoustic_model Model = physical<>>
class ensemble_scanner {
  public:
    /// See `doppler_ensemble`. @return valid until the next call
    template <exec::policy Policy, velocity_field Field>
    const iq_ensemble& acquire(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                               const Model& model, const Field& field, const ensemble_settings& settings) {
        settings.check();
        if constexpr (requires { field.check(); }) field.check();
        pulse sent = nominal_pulse(probe);
        const std::uint32_t samples =
            settings.samples != 0 ? settings.samples : samples_for(settings.depth, sent.sigma_z(probe.frequency));
        sent.burst = settings.burst;
        const std::uint32_t frame =
            mix_bits(__builtin_bit_cast(std::uint32_t, settings.time)) | 1U; // not 0: blood flows
        constexpr float slowest = 0.9F; // medium over c0: the echoes of slower media are displayed deeper
        tracer_.trace(detail::any_policy{policy}, body, probe, at, model, field,
                      {.depth = settings.depth, .samples = samples, .planes = settings.planes, .frame = frame},
                      {.start = settings.time,
                       .interval = 1 / settings.prf,
                       .count = settings.pulses,
                       .first = settings.first,
                       .burst = settings.burst,
                       .from = slowest * settings.from},
                      traced_);
        const auto formed = [&](iq_lines echoes) {
            return convolver_.convolve(policy, std::move(echoes), sent, probe);
        };
        iq_lines& resting = traced_.resting;
        resting = formed(std::move(resting));
        echoes_.prf = settings.prf;
        echoes_.pulses.resize(settings.pulses);
        for (std::uint32_t k = 0; k < settings.pulses; ++k) {
            std::swap(echoes_.pulses[k], traced_.moving[k]);
            iq_lines& echoes = echoes_.pulses[k];
            echoes = formed(std::move(echoes));
            exec::for_each_block(policy, echoes.values.size(), 4096, 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) echoes.values[i] += resting.values[i];
            });
            echoes = add_electronic_noise(
                policy, std::move(echoes),
                {.level_db = settings.noise_db, .seed = settings.seed, .frame = frame + settings.first + k});
        }
        return echoes_;
    }

  private:
    ensemble_tracer<Probe, Model> tracer_{};
    convolver convolver_{};
    ensemble_echoes traced_{};
    iq_ensemble echoes_{};
};

/// The echoes of a pulse train along the lines of a probe, after pulse and beam: the input of all Doppler methods.
///
/// Between pulses, scatterers and surfaces move as `field` says; the geometry is that of the scene for all pulses. All
/// lines are acquired at once. Blood that flows out of the slice is followed by other blood.
///
/// @throws usage_error, geometry_error  as `trace`, and for settings out of range
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
iq_ensemble doppler_ensemble(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                             const Model& model, const Field& field, const ensemble_settings& settings = {}) {
    return ensemble_scanner<Probe, Model>{}.acquire(policy, body, probe, at, model, field, settings);
}
/// The same with `physical`.
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, velocity_field Field>
iq_ensemble doppler_ensemble(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                             const Field& field, const ensemble_settings& settings = {}) {
    return doppler_ensemble(policy, body, probe, at, physical<>{}, field, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
