#ifndef INSONIFY_SIGNAL_PULSE_HPP
#define INSONIFY_SIGNAL_PULSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/text.hpp>
#include <insonify/probe/transducer.hpp>
#include <string>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Gaussian kernels are truncated at this number of standard deviations: e^-8 or -69 dB.
inline constexpr float kernel_sigmas = 4;

} // namespace detail

/// Envelope of an echo along displayed depth: a rectangular burst, smoothed by a Gaussian; its peak is 1.
struct pulse_envelope {
    float sigma = 1; ///< standard deviation of the Gaussian
    float burst = 0; ///< length of the burst, in the unit of `sigma`; 0: a Gaussian

    /// The envelope is truncated at this distance from its centre.
    INSONIFY_FN float half_length() const { return 0.5F * burst + detail::kernel_sigmas * sigma; }

    /// exp(-x^2 / 2 sigma^2) or, with a burst of length L, its integral from x - L/2 to x + L/2, normalized.
    INSONIFY_FN float operator()(float x) const {
        if (!(burst > 1e-2F * sigma)) return std::exp(-0.5F * (x / sigma) * (x / sigma));
        const float scale = 0.70710678F / sigma, half = 0.5F * burst;
        return (std::erf((x + half) * scale) - std::erf((x - half) * scale)) / (2 * std::erf(half * scale));
    }
};

/// Transmit pulse: a burst of the carrier, filtered by a transducer whose impulse response has a Gaussian envelope.
///
///     pulse{.cycles = 2.5F}               impulse excitation, for imaging
///     pulse{.cycles = 2.5F, .burst = 8}   excitation of eight cycles, as for Doppler
struct pulse {
    float frequency = 0; ///< carrier frequency, hertz; 0: that of the probe
    float cycles = 2.5F; ///< length of the impulse response between its -20 dB points, in cycles
    float burst = 0;     ///< length of the excitation, in cycles; 0: impulse excitation

    /// Fractional bandwidth B of the transducer at -6 dB: 1.61 / cycles.
    ///
    /// An envelope with the standard deviation s in time falls to -20 dB at +-2.146 s, and s = 0.3748 / (B f0).
    INSONIFY_FN constexpr float bandwidth() const { return 1.61F / cycles; }

    /// Fractional bandwidth of the Gaussian pulse whose peak is as curved, and therefore loses as much to attenuation:
    /// B for impulse excitation, nearly 0 for a long burst, which loses what its carrier does.
    ///
    ///     B_peak^2 = B^2 (L / s) exp(-L^2 / 8 s^2) / (sqrt(2 pi) erf(L / (sqrt(8) s))),   s = 0.3748 / B cycles
    ///
    /// for a burst of L cycles: the second derivative of `envelope` at its peak over its peak. Attenuation multiplies
    /// the spectrum by exp(-beta (f - f0)), whose second-order term is that derivative.
    INSONIFY_FN float bandwidth_at_peak() const {
        const float per_sigma = burst * bandwidth() / 0.3748F;
        if (!(per_sigma > 1e-2F)) return bandwidth();
        return bandwidth() * std::sqrt(per_sigma * std::exp(-per_sigma * per_sigma / 8) /
                                       (2.5066283F * std::erf(per_sigma * 0.35355339F)));
    }

    /// Standard deviation of the pulse envelope along displayed depth, metres: 0.1874 c0 / (B f0).
    ///
    /// The standard deviation of the spectrum is B f0 / 2.3548, that of the envelope in time 1 / (2 pi) over it; depth
    /// is c0 t / 2.
    /// @param carrier  f0, hertz
    INSONIFY_FN constexpr float sigma_z(float carrier) const { return axial_sigma(bandwidth(), carrier); }

    /// Envelope along displayed depth, metres; a cycle is c0 / (2 f0) long.
    INSONIFY_FN constexpr pulse_envelope envelope(float carrier) const {
        return {.sigma = sigma_z(carrier), .burst = burst * display_speed / (2 * carrier)};
    }

    /// @param carrier  frequency of the probe at which the echoes were traced, hertz
    /// @throws usage_error  for a setting out of range, or a frequency other than the carrier
    void check(float carrier) const {
        if (!is_finite(cycles) || !(cycles > 0))
            throw usage_error{"pulse: `cycles` must be finite and above 0, such as 2.5"};
        if (!is_finite(burst) || !(burst >= 0))
            throw usage_error{"pulse: `burst` must be a finite number of cycles, or 0 for impulse excitation"};
        if (!is_finite(frequency) || !(frequency >= 0))
            throw usage_error{"pulse: `frequency` must be finite and above 0, or 0 for that of the probe"};
        if (frequency != 0 && !(std::fabs(frequency - carrier) <= 1e-5F * carrier))
            throw usage_error{
                detail::joined({"pulse: its frequency is ", std::to_string(frequency), " Hz, that of the probe ",
                                std::to_string(carrier), " Hz; make them equal, or leave that of the pulse at 0"})};
    }
};

/// The shortest pulse that the fractional `bandwidth` of a probe permits; `pulse{}` for a probe without that member.
/// @param burst  see `pulse::burst`
template <transducer Probe>
INSONIFY_FN constexpr pulse nominal_pulse(const Probe& probe, float burst = 0) {
    return {.cycles = 1.61F / fractional_bandwidth(probe), .burst = burst};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
