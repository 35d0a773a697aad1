#ifndef INSONIFY_ACOUSTICS_ATTENUATION_HPP
#define INSONIFY_ACOUSTICS_ATTENUATION_HPP

#include <insonify/acoustics/medium.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// What an echo loses on each metre of depth, there and back: 2 alpha0 f^b, in dB/m.
///
/// alpha0 in dB/m at 1 MHz, f in MHz, b the medium's `attenuation_power`. Exact for one frequency. Finite for every
/// medium that is valid: nothing is left of a sound that loses FLT_MAX.
INSONIFY_FN inline float echo_loss(const medium& m, float frequency) {
    const float megahertz = frequency * 1e-6F;
    const float growth = m.attenuation_power == 1 ? megahertz : std::pow(megahertz, m.attenuation_power);
    return lesser(m.attenuation * lesser(2 * growth, FLT_MAX), FLT_MAX);
}

/// What an attenuation law must say: law(medium, frequency), the dB that an echo loses a metre of the medium, there and
/// back.
template <class Law>
concept attenuation_law = requires(const Law& law, const medium& m, float frequency) {
    { law(m, frequency) } -> std::convertible_to<float>;
};

/// The usual one: `echo_loss`.
struct power_law {
    /// dB a metre, there and back; the frequency in hertz.
    INSONIFY_FN float operator()(const medium& m, float frequency) const { return echo_loss(m, frequency); }

    friend bool operator==(const power_law&, const power_law&) = default;
};

/// A pulse of finite bandwidth on its way through media whose attenuation grows with frequency: the high frequencies
/// suffer most, so its centre moves down and its peak loses less than one frequency would.
struct broadband_echo {
    float loss_db = 0;   ///< of the peak
    float frequency = 0; ///< of the centre of the spectrum, hertz
};

/// A Gaussian pulse after a depth at which one frequency would have lost `narrowband_db`, there and back.
///
///     beta = echo loss in Np per Hz, over the whole way;  sigma = B f0 / 2.3548, of the amplitude spectrum
///     loss = beta f0 - beta^2 sigma^2 / 2,   centre = f0 - beta sigma^2
///
/// Holds for attenuation linear in f and while the centre stays well above 0; the gain is limited to where the centre
/// would have fallen by half.
/// @param bandwidth  fractional, -6 dB: B
/// Source: the product of a Gaussian and an exponential, completed to a square.
INSONIFY_FN inline broadband_echo attenuated(float narrowband_db, float frequency, float bandwidth) {
    constexpr float neper_per_db = 0.115129255F; // ln(10) / 20
    const float sigma = bandwidth * frequency / 2.3548F;
    const float most = 0.5F * frequency / (sigma * sigma); // beta that halves the centre
    const float beta = lesser(neper_per_db * narrowband_db / frequency, most);
    return {.loss_db = narrowband_db - 0.5F * beta * beta * sigma * sigma / neper_per_db,
            .frequency = frequency - beta * sigma * sigma};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
