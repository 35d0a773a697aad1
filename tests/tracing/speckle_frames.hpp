#ifndef INSONIFY_TESTS_TRACING_SPECKLE_FRAMES_HPP
#define INSONIFY_TESTS_TRACING_SPECKLE_FRAMES_HPP

#include <insonify/acoustics/physical.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <vector>

/// Envelopes of traced speckle, and how they compare.
namespace speckle_test {

using namespace insonify;

inline constexpr medium silent{.density = 1000, .sound_speed = 1540, .backscatter = 1};

template <class Probe, class Model = physical<>>
std::vector<double> envelope_of(const scene& body, const Probe& probe, const pose& at, const acquisition& scan,
                                const Model& model = {}) {
    const iq_lines iq = convolve(exec::par_unseq, trace(exec::par_unseq, body, probe, at, model, scan), pulse{}, probe);
    std::vector<double> envelope(iq.values.size());
    for (std::size_t i = 0; i < envelope.size(); ++i) envelope[i] = static_cast<double>(length(iq.values[i]));
    return envelope;
}

inline double rms(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v * v;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

inline double decibels(double amplitude) { return 20 * std::log10(amplitude); }

} // namespace speckle_test

#endif
