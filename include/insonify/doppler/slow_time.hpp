#ifndef INSONIFY_DOPPLER_SLOW_TIME_HPP
#define INSONIFY_DOPPLER_SLOW_TIME_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/probe/line_grid.hpp>
#include <algorithm>
#include <numeric>
#include <vector>

/// Slow time: the echoes of successive pulses along the same lines, from which velocities are estimated.
namespace insonify::inline INSONIFY_ABI {

/// Echoes of successive pulses, all of one shape.
struct iq_ensemble {
    float prf = 0;                  ///< pulse repetition frequency, hertz
    std::vector<iq_lines> pulses{}; ///< one after the other
};

/// High-pass filter along slow time, which removes the echoes of tissue: the wall filter.
struct wall_filter {
    /// `polynomial`: subtracts the best polynomial of degree `order` in time, for each sample; keeps all pulses.
    /// `fir`: the difference to a low-pass filter of `order` + 1 taps (Hamming window, no gain at 0 Hz). The first
    /// `order` pulses are lost.
    enum class kind { none, polynomial, fir };
    kind type = kind::polynomial; ///< none: the echoes of tissue stay, for tissue Doppler
    std::uint32_t order = 1;      ///< of the polynomial; of the FIR filter, even
    float cutoff = 0.1F;          ///< of the FIR filter, as a fraction of the pulse repetition frequency

    /// @param pulses  that will be filtered
    /// @throws usage_error  for a setting out of range
    void check(std::size_t pulses) const {
        if (type == kind::none) return;
        if (std::uint64_t{order} + 2 > pulses)
            throw usage_error{"wall_filter: order ",
                              order,
                              " needs at least ",
                              std::uint64_t{order} + 2,
                              " pulses, not ",
                              pulses,
                              "; lower it or raise the ensemble"};
        if (type == kind::polynomial && order > 8)
            throw usage_error{"wall_filter: the order of a polynomial is at most 8; 1 or 2 is usual"};
        if (type == kind::fir && (order < 2 || order % 2 != 0 || !(cutoff > 0 && cutoff < 0.5F)))
            throw usage_error{"wall_filter: a FIR filter needs an even order, such as 4, and a cutoff above 0 and "
                              "below 0.5 of the prf, such as 0.1"};
    }

    friend bool operator==(const wall_filter&, const wall_filter&) = default;
};

namespace detail {

/// The values of polynomials of degree 0 to `order` at equal steps, orthonormal by Gram-Schmidt.
template <class Deferred = void>
std::vector<std::vector<double>> orthonormal_polynomials(std::size_t count, std::uint32_t order) {
    std::vector<std::vector<double>> basis(std::size_t{order} + 1, std::vector<double>(count));
    for (std::uint32_t degree = 0; degree <= order; ++degree) {
        std::vector<double>& own = basis[degree];
        for (std::size_t k = 0; k < count; ++k)
            own[k] = std::pow(2 * static_cast<double>(k) / static_cast<double>(count - 1) - 1, degree);
        for (int twice = 0; twice < 2; ++twice)
            for (std::uint32_t lower = 0; lower < degree; ++lower) {
                const double common = std::inner_product(own.begin(), own.end(), basis[lower].begin(), 0.0);
                for (std::size_t k = 0; k < count; ++k) own[k] -= common * basis[lower][k];
            }
        const double power = std::inner_product(own.begin(), own.end(), own.begin(), 0.0);
        for (double& value : own) value /= std::sqrt(power);
    }
    return basis;
}

/// @throws usage_error  for an ensemble whose pulses differ in shape, or without a prf
template <class Deferred = void>
void check_ensemble(const iq_ensemble& echoes, const char* caller) {
    if (!is_finite(echoes.prf) || !(echoes.prf > 0))
        throw usage_error{caller, ": the prf must be a frequency above 0, such as 4_kHz"};
    for (const iq_lines& each : echoes.pulses)
        if (each.count != echoes.pulses[0].count || each.samples != echoes.pulses[0].samples ||
            each.depth != echoes.pulses[0].depth || each.values.size() != std::size_t{each.count} * each.samples)
            throw usage_error{caller, ": all pulses must have the same lines, samples and depth"};
}

} // namespace detail

/// The filter as a matrix, row by row: result j is the sum over k of element j * pulses + k times pulse k.
/// @throws usage_error  as `wall_filter::check`
template <class Deferred = void>
std::vector<float> wall_filter_matrix(const wall_filter& filter, std::size_t pulses) {
    filter.check(pulses);
    if (filter.type == wall_filter::kind::fir) {
        const std::size_t taps = std::size_t{filter.order} + 1, results = pulses - filter.order;
        std::vector<double> tap(taps);
        double sum = 0;
        for (std::size_t i = 0; i < taps; ++i) {
            const double turn = 2 * 3.14159265358979323846, x = static_cast<double>(i) - 0.5 * filter.order;
            const double sinc = x == 0 ? 2.0 * static_cast<double>(filter.cutoff)
                                       : std::sin(turn * static_cast<double>(filter.cutoff) * x) / (0.5 * turn * x);
            tap[i] = sinc * (0.54 - 0.46 * std::cos(turn * static_cast<double>(i) / filter.order));
            sum += tap[i];
        }
        std::vector<float> matrix(results * pulses);
        for (std::size_t j = 0; j < results; ++j)
            for (std::size_t i = 0; i < taps; ++i)
                matrix[j * pulses + j + i] = static_cast<float>((i == filter.order / 2 ? 1.0 : 0.0) - tap[i] / sum);
        return matrix;
    }
    std::vector<double> matrix(pulses * pulses); // the identity less the projections on orthonormal polynomials
    for (std::size_t k = 0; k < pulses; ++k) matrix[k * pulses + k] = 1;
    if (filter.type == wall_filter::kind::polynomial)
        for (const std::vector<double>& one : detail::orthonormal_polynomials(pulses, filter.order))
            for (std::size_t j = 0; j < pulses; ++j)
                for (std::size_t k = 0; k < pulses; ++k) matrix[j * pulses + k] -= one[j] * one[k];
    return {matrix.begin(), matrix.end()};
}

namespace detail {

/// See `filter_walls`. @param matrix  see `wall_filter_matrix`
template <exec::policy Policy>
iq_ensemble filter_walls(const Policy& policy, const iq_ensemble& echoes, const std::vector<float>& matrix,
                         iq_ensemble recycled) {
    check_ensemble(echoes, "filter_walls");
    const std::size_t pulses = echoes.pulses.size();
    recycled.prf = echoes.prf;
    recycled.pulses.resize(pulses == 0 ? 0 : matrix.size() / pulses);
    if (recycled.pulses.empty()) return recycled;
    const iq_lines& first = echoes.pulses[0];
    for (iq_lines& each : recycled.pulses) each.reshape(first.count, first.samples, first.depth);
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    constexpr std::size_t step = 1024; // floats
    const auto time = 0.2F * static_cast<float>(matrix.size());
    exec::for_each_block(policy, 2 * first.values.size(), step, time, [&](std::size_t begin, std::size_t end) {
        const auto floats = [](const iq_lines& lines) { return reinterpret_cast<const float*>(lines.values.data()); };
        for (std::size_t j = 0; j < recycled.pulses.size(); ++j) {
            auto* const to = reinterpret_cast<float*>(recycled.pulses[j].values.data());
            in_registers<width>(begin, end, [&](std::size_t i, auto n) {
                lanes<n> sum(0.0F);
                for (std::size_t k = 0; k < pulses; ++k)
                    sum = sum + lanes<n>(matrix[j * pulses + k]) * load<n>(floats(echoes.pulses[k]) + i);
                store(sum, to + i);
            });
        }
    });
    return recycled;
}

} // namespace detail

/// Filters every sample along slow time.
/// @param recycled  an ensemble whose memory is reused
/// @throws usage_error  for settings out of range, and pulses that differ in shape
template <exec::policy Policy>
iq_ensemble filter_walls(const Policy& policy, const iq_ensemble& echoes, const wall_filter& filter,
                         iq_ensemble recycled = {}) {
    return detail::filter_walls(policy, echoes, wall_filter_matrix(filter, echoes.pulses.size()), std::move(recycled));
}

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
