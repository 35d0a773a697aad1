#ifndef INSONIFY_SIGNAL_PULSE_HPP
#define INSONIFY_SIGNAL_PULSE_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/taps.hpp>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// The envelope of an echo along the displayed depth: a burst of constant amplitude, smoothed by a Gaussian; peak 1.
struct pulse_envelope {
    float sigma = 1; ///< of the Gaussian
    float burst = 0; ///< length of the burst, in the unit of `sigma`; 0: the Gaussian itself

    /// Beyond this distance from the middle there is nothing.
    INSONIFY_FN float reach() const { return 0.5F * burst + kernel_sigmas * sigma; }

    /// exp(-x^2 / 2 sigma^2) or, with a burst of length L, the same summed from x - L/2 to x + L/2.
    INSONIFY_FN float operator()(float x) const {
        if (!(burst > 1e-2F * sigma)) return std::exp(-0.5F * (x / sigma) * (x / sigma));
        const float scale = 0.70710678F / sigma, half = 0.5F * burst;
        return (std::erf((x + half) * scale) - std::erf((x - half) * scale)) / (2 * std::erf(half * scale));
    }
};

/// What the probe sends and how it rings: a burst of the carrier through a transducer whose own response has a Gaussian
/// envelope, and so a Gaussian spectrum.
///
///     pulse{.cycles = 2.5F}               as short as the transducer rings, for imaging
///     pulse{.cycles = 2.5F, .burst = 8}   driven for eight cycles, as for Doppler
struct pulse {
    float frequency = 0; ///< of the carrier, hertz; 0: the probe's
    float cycles = 2.5F; ///< of the transducer's ring, between the points where it has fallen to a tenth (-20 dB)
    float burst = 0;     ///< cycles for which it is driven at one amplitude; 0: a single stroke

    /// Width of the transducer's amplitude spectrum at half its height (-6 dB), B, as a share of its centre frequency.
    ///
    /// B = 1.61 / cycles: an envelope of standard deviation s in time is a tenth at +-2.146 s, and s = 0.3748 / (B f0).
    INSONIFY_FN constexpr float bandwidth() const { return 1.61F / cycles; }

    /// Standard deviation of the ring's envelope along the displayed depth, metres: 0.1874 c0 / (B f0).
    ///
    /// The spectrum's is B f0 / 2.3548 and the envelope's in time 1 / (2 pi) over that; depth is c0 t / 2.
    /// @param carrier  f0, hertz
    INSONIFY_FN constexpr float sigma_z(float carrier) const { return axial_sigma(bandwidth(), carrier); }

    /// In metres of displayed depth, in which a cycle is c0 / (2 f0) long.
    INSONIFY_FN constexpr pulse_envelope envelope(float carrier) const {
        return {.sigma = sigma_z(carrier), .burst = burst * display_speed / (2 * carrier)};
    }

    /// @param carrier  frequency of the probe, which the echoes were traced at, hertz
    /// @throws usage_error  where a setting makes no sense, or the pulse is not at the carrier
    INSONIFY_LAZY void check(float carrier) const {
        if (!is_finite(cycles) || !(cycles > 0))
            throw usage_error{"pulse: `cycles` must be a finite number above 0; 2.5 is usual"};
        if (!is_finite(burst) || !(burst >= 0))
            throw usage_error{"pulse: `burst` must be a finite number of cycles, or 0 for a single stroke"};
        if (!is_finite(frequency) || !(frequency >= 0))
            throw usage_error{"pulse: `frequency` must be a finite number of hertz, or 0 for the probe's"};
        if (frequency != 0 && !(std::fabs(frequency - carrier) <= 1e-5F * carrier))
            throw usage_error{"pulse: its frequency of " + std::to_string(frequency) + " Hz is not the probe's, " +
                              std::to_string(carrier) + " Hz; give both the same, or leave the pulse's at 0"};
    }
};

/// The pulse that a probe is built for: as short as its `bandwidth` (a share of its frequency) allows, and `pulse{}`
/// for a probe that states none.
template <transducer Probe>
INSONIFY_FN constexpr pulse nominal_pulse(const Probe& probe) {
    if constexpr (requires { probe.bandwidth; })
        return {.cycles = 1.61F / probe.bandwidth};
    else
        return {};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
