#ifndef INSONIFY_DOPPLER_AUTOCORRELATION_HPP
#define INSONIFY_DOPPLER_AUTOCORRELATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/doppler/slow_time.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Slow-time autocorrelation of one sample.
struct autocorrelation {
    float power = 0;    ///< at lag zero: mean of |s_k|^2
    vec2 lag_one{0, 0}; ///< at lag one: mean of conj(s_k) s_(k+1)

    friend bool operator==(const autocorrelation&, const autocorrelation&) = default;
};
/// Along the scan lines of a probe.
using autocorrelation_lines = line_grid<autocorrelation>;

/// What colour Doppler knows of one sample.
struct flow_sample {
    float velocity = 0; ///< along the line, m/s; towards the probe is positive
    float power = 0;    ///< of the echoes after the wall filter; 1 is that of a perfect mirror
    float variance = 0; ///< of the velocity, (m/s)^2

    friend bool operator==(const flow_sample&, const flow_sample&) = default;
};
/// Velocities along the scan lines of a probe.
struct flow_lines : line_grid<flow_sample> {
    float max_velocity = 0; ///< the largest that does not alias: see `max_doppler_velocity`

    friend bool operator==(const flow_lines&, const flow_lines&) = default;
};

/// The largest velocity that does not alias, m/s: c0 prf / (4 f0). Between two pulses, the echo turns by half a turn.
/// @param prf        pulse repetition frequency, hertz
/// @param frequency  f0, of the carrier, hertz
INSONIFY_FN constexpr float max_doppler_velocity(float prf, float frequency) {
    return display_speed * prf / (4 * frequency);
}

/// The slow-time autocorrelation, averaged along each line.
///
/// Results are `decimation` samples apart, each the mean over `length` samples around it, those that exist.
/// @param length, decimation  samples; the number of samples must be a multiple of `decimation`
/// @throws usage_error  for fewer than 2 pulses, pulses that differ in shape, or a setting out of range
template <exec::policy Policy>
autocorrelation_lines autocorrelate(const Policy& policy, const iq_ensemble& echoes, std::uint32_t length = 1,
                                    std::uint32_t decimation = 1, autocorrelation_lines recycled = {}) {
    detail::check_ensemble(echoes, "autocorrelate");
    if (echoes.pulses.size() < 2) throw usage_error{"autocorrelate: an ensemble needs at least 2 pulses"};
    const iq_lines& first = echoes.pulses[0];
    if (length == 0 || decimation == 0 || first.samples % decimation != 0)
        throw usage_error{"autocorrelate: `length` must be at least 1 sample, and `decimation` a divisor of the number "
                          "of samples"};
    recycled.reshape(first.count, first.samples / decimation, first.depth);
    const std::size_t pulses = echoes.pulses.size(), samples = first.samples;
    const auto time = static_cast<float>(samples * pulses);
    exec::for_each_block(policy, first.count, 1, time, [&](std::size_t line, std::size_t) {
        for (std::uint32_t k = 0; k < recycled.samples; ++k) {
            const std::size_t middle = std::size_t{k} * decimation + decimation / 2;
            const std::size_t begin = middle > length / 2 ? middle - length / 2 : 0,
                              end = std::min(begin + length, samples);
            float power = 0;
            vec2 lag_one{0, 0};
            for (std::size_t j = 0; j < pulses; ++j) {
                const vec2* const here = echoes.pulses[j].values.data() + line * samples;
                for (std::size_t i = begin; i < end; ++i) power += dot(here[i], here[i]);
                if (j + 1 == pulses) break;
                const vec2* const next = echoes.pulses[j + 1].values.data() + line * samples;
                for (std::size_t i = begin; i < end; ++i)
                    lag_one += vec2{dot(here[i], next[i]), here[i].x * next[i].y - here[i].y * next[i].x};
            }
            const auto count = static_cast<float>(end - begin);
            recycled.values[line * recycled.samples + k] = {power / (count * static_cast<float>(pulses)),
                                                            lag_one / (count * static_cast<float>(pulses - 1))};
        }
    });
    return recycled;
}

/// Velocity, power and variance of an autocorrelation.
///
///     velocity = v_max arg(R1) / pi,   variance = 2 (v_max / pi)^2 (1 - |R1| / R0),   v_max = c0 prf / (4 f0)
///
/// Source: Kasai et al., Real-time two-dimensional blood flow imaging using an autocorrelation technique, 1985.
/// @param max_velocity  v_max, m/s: see `max_doppler_velocity`
inline flow_sample flow_of(const autocorrelation& of, float max_velocity) {
    const float scale = max_velocity / pi, common = length(of.lag_one);
    if (!(of.power > 0)) return {};
    return {.velocity = common > 0 ? scale * std::atan2(of.lag_one.y, of.lag_one.x) : 0.0F,
            .power = of.power,
            .variance = 2 * scale * scale * max(1 - common / of.power, 0)};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
