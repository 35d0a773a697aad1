#ifndef INSONIFY_SIGNAL_PULSE_HPP
#define INSONIFY_SIGNAL_PULSE_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/probe/transducer.hpp>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// What the probe sends: a burst under a Gaussian envelope, so that its spectrum is a Gaussian too.
struct pulse {
    float frequency = 0; ///< of the carrier, hertz; 0: the probe's
    float cycles = 2.5F; ///< of the carrier between the points where the envelope has fallen to a tenth (-20 dB)

    /// Width of the echo's amplitude spectrum at half its height (-6 dB), B, as a share of its centre frequency.
    ///
    /// B = 1.61 / cycles: an envelope of standard deviation s in time is a tenth at +-2.146 s, and s = 0.3748 / (B f0).
    INSONIFY_FN constexpr float bandwidth() const { return 1.61F / cycles; }

    /// Standard deviation of the echo's envelope along the displayed depth, metres: 0.1874 c0 / (B f0).
    ///
    /// The spectrum's is B f0 / 2.3548 and the envelope's in time 1 / (2 pi) over that; depth is c0 t / 2.
    /// @param carrier  f0, hertz
    INSONIFY_FN constexpr float sigma_z(float carrier) const { return axial_sigma(bandwidth(), carrier); }

    /// @param carrier  frequency of the probe, which the echoes were traced at, hertz
    /// @throws usage_error  where a setting makes no sense, or the pulse is not at the carrier
    void check(float carrier) const {
        if (!is_finite(cycles) || !(cycles > 0))
            throw usage_error{"pulse: `cycles` must be a finite number above 0; 2.5 is usual"};
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
