#ifndef INSONIFY_ACOUSTICS_ATTENUATION_HPP
#define INSONIFY_ACOUSTICS_ATTENUATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Attenuation of an echo per metre of depth, there and back, in dB/m at a frequency in hertz.
///
///     loss = 2 alpha0 f^b
///
/// alpha0 = `attenuation` in dB/m at 1 MHz, f in MHz, b = `attenuation_power`. Valid for a single frequency. The result
/// is finite for every valid medium: it is at most FLT_MAX.
/// Source: the power law of attenuation in tissue, Szabo, Diagnostic Ultrasound Imaging: Inside Out, 2004, chapter 4.
INSONIFY_FN inline float echo_loss(const medium& m, float frequency) {
    const float megahertz = frequency * 1e-6F;
    const float growth = m.attenuation_power == 1 ? megahertz : std::pow(megahertz, m.attenuation_power);
    return min(m.attenuation * min(2 * growth, FLT_MAX), FLT_MAX);
}

/// An attenuation law: law(medium, frequency) is the attenuation of an echo in dB per metre, there and back; the
/// frequency is in hertz.
template <class Law>
concept attenuation_law = requires(const Law& law, const medium& m, float frequency) {
    { law(m, frequency) } -> std::convertible_to<float>;
};

/// The default attenuation law: `echo_loss`.
struct power_law {
    /// dB/m, there and back; the frequency in hertz.
    INSONIFY_FN float operator()(const medium& m, float frequency) const { return echo_loss(m, frequency); }

    friend bool operator==(const power_law&, const power_law&) = default;
};

/// The echo of a pulse of finite bandwidth. Attenuation grows with frequency, so the centre of the spectrum shifts down
/// and the peak loses less than a single frequency would.
struct broadband_echo {
    float loss_db = 0;   ///< of the peak, dB
    float frequency = 0; ///< of the centre of the spectrum, hertz
};

/// A Gaussian pulse after a path, there and back, on which a single frequency would lose `narrowband_db`.
///
///     beta = narrowband_db ln(10) / (20 f0)                       Np/Hz
///     sigma = B f0 / 2.3548                                       Hz, of the amplitude spectrum
///     loss = beta f0 - beta^2 sigma^2 / 2                         Np, of the peak
///     centre = f0 - beta sigma^2                                  Hz
///
/// Valid for attenuation linear in f, as long as the centre is well above 0. beta is limited to the value at which the
/// centre is f0 / 2.
/// @param frequency  f0, of the carrier, hertz
/// @param bandwidth  B, fractional, at -6 dB
/// Source: product of the Gaussian spectrum and exp(-beta f), by completing the square; see also Szabo,
/// Diagnostic Ultrasound Imaging: Inside Out, 2004, chapter 4.
INSONIFY_FN inline broadband_echo attenuated(float narrowband_db, float frequency, float bandwidth) {
    constexpr float neper_per_db = 0.115129255F; // ln(10) / 20
    const float sigma = bandwidth * frequency / 2.3548F;
    const float max_beta = 0.5F * frequency / (sigma * sigma);
    const float beta = min(neper_per_db * narrowband_db / frequency, max_beta);
    return {.loss_db = narrowband_db - 0.5F * beta * beta * sigma * sigma / neper_per_db,
            .frequency = frequency - beta * sigma * sigma};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
