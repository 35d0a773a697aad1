#ifndef INSONIFY_CHANNELS_RECORDING_HPP
#define INSONIFY_CHANNELS_RECORDING_HPP

#include <insonify/insonify.hpp>
#include "arrays.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace channels {

/// One frame as files have it: RF, or IQ.
struct frame_data {
    channel_data received{};         ///< RF, or what is in phase
    std::vector<float> quadrature{}; ///< in the same order; empty: RF

    std::uint32_t parts() const { return quadrature.empty() ? 1 : 2; }
    float operator()(std::uint32_t part, std::uint32_t transmit, std::uint32_t element, std::uint32_t sample) const {
        const std::size_t i = (std::size_t{transmit} * received.elements + element) * received.samples + sample;
        return part == 0 ? received.values[i] : quadrature[i];
    }
};

/// IQ of which every second, third, ... sample is kept, so that half of the sampling frequency is three standard
/// deviations of the spectrum.
inline frame_data thinned(const iq_channel_data& all) {
    const float deviation = all.bandwidth * all.frequency / 2.3548F; // of a Gaussian, from its full width at -6 dB
    const auto step = std::max(1U, static_cast<std::uint32_t>(all.sampling_frequency / (6 * deviation)));
    frame_data some{.received = insonify::detail::same_acquisition<float>(all)};
    channel_data& to = some.received;
    to.samples = (all.samples + step - 1) / step;
    to.sampling_frequency = all.sampling_frequency / static_cast<float>(step);
    for (std::uint32_t t = 0; t < to.transmits; ++t)
        for (std::uint32_t e = 0; e < to.elements; ++e)
            for (std::uint32_t k = 0; k < to.samples; ++k) {
                to.values.push_back(all(t, e, k * step).x);
                some.quadrature.push_back(all(t, e, k * step).y);
            }
    return some;
}

/// What is written to a file.
struct recording {
    const named_array& array;
    const scene& body;
    pose at{}; ///< of the array
    std::string title{};
    std::vector<point_scatterer> points{}; ///< of the phantom, in the frame of the array
    std::uint32_t frames = 1;
    float depth = 0;                                      ///< metres
    std::function<frame_data(std::uint32_t)> trace_one{}; ///< traces a frame
};

/// Calls write(frame, transmit, data) for each transmit of each frame, traced one after the other.
/// @param first  the frame 0
template <class Write>
void for_each_transmit(const recording& of, frame_data first, const Write& write) {
    for (std::uint32_t frame = 0; frame < of.frames; ++frame) {
        if (frame > 0) first = of.trace_one(frame);
        for (std::uint32_t t = 0; t < first.received.transmits; ++t) write(frame, t, first);
    }
}

/// A file is made in memory, twice for a moment.
/// @param beside  bytes of a frame beside its samples
/// @throws usage_error  for one that is too large
inline void check_size(const recording& of, const frame_data& one, std::size_t beside = 0) {
    constexpr double largest = 4e9;
    const double samples = one.parts() * static_cast<double>(one.received.values.size());
    const double bytes = of.frames * (4 * samples + static_cast<double>(beside));
    if (bytes > largest)
        throw usage_error{"the file would have " + insonify::detail::number_text(static_cast<float>(1e-9 * bytes)) +
                          " GB, more than 4 GB; lower --frames, --depth, --sampling-frequency or the number of "
                          "--transmits"};
}

} // namespace channels
#endif
