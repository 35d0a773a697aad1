#ifndef INSONIFY_CHANNELS_CHANNEL_DATA_HPP
#define INSONIFY_CHANNELS_CHANNEL_DATA_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/channels/element_array.hpp>
#include <insonify/channels/transmit.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/signal/fourier.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What each element receives of each transmit. Sample k is taken `start + k / sampling_frequency` seconds after the
/// first element fires; the envelope of an echo peaks where its travel time is.
/// @tparam Sample  float: RF; vec2: IQ
template <class Sample>
struct channel_grid {
    std::uint32_t transmits = 0;  ///< number of transmits
    std::uint32_t elements = 0;   ///< that receive
    std::uint32_t samples = 0;    ///< of each element
    float sampling_frequency = 0; ///< hertz
    float start = 0;              ///< time of the first sample after the first element fires, seconds
    float frequency = 0;          ///< of the carrier, hertz
    float bandwidth = 0;          ///< fractional, of the pulse there and back, at -6 dB
    float sound_speed = 1540;     ///< that delays assume, m/s
    float pitch = 0;              ///< mean distance of neighbouring elements, metres; 0: unknown
    float element_width = 0;      ///< metres; 0: unknown
    float height = 0;             ///< of the elements, metres
    float elevation_focus = 0;    ///< of the lens, metres
    std::vector<ray> places{};    ///< of the elements, in the frame of the probe: centre and normal
    std::vector<transmit> sent{}; ///< the transmits
    std::vector<Sample> values{}; ///< transmit after transmit, element after element

    /// One sample; indices are not checked.
    /// @{
    Sample& operator()(std::uint32_t transmit, std::uint32_t element, std::uint32_t sample) {
        return values[(std::size_t{transmit} * elements + element) * samples + sample];
    }
    const Sample& operator()(std::uint32_t transmit, std::uint32_t element, std::uint32_t sample) const {
        return values[(std::size_t{transmit} * elements + element) * samples + sample];
    }
    /// @}

    /// The same samples of the same transmits at the same times.
    friend bool operator==(const channel_grid& a, const channel_grid& b) {
        return a.transmits == b.transmits && a.elements == b.elements && a.samples == b.samples &&
               a.sampling_frequency == b.sampling_frequency && a.start == b.start && a.frequency == b.frequency &&
               a.sent == b.sent && a.values == b.values;
    }
};

using channel_data = channel_grid<float>;   ///< RF; 1 is the echo of a perfect mirror to a wave of amplitude 1
using iq_channel_data = channel_grid<vec2>; ///< complex baseband: x in phase, y in quadrature

namespace detail {

/// Everything but the samples.
template <class To, class From>
channel_grid<To> same_acquisition(const channel_grid<From>& from) {
    channel_grid<To> to;
    to.transmits = from.transmits;
    to.elements = from.elements;
    to.samples = from.samples;
    to.sampling_frequency = from.sampling_frequency;
    to.start = from.start;
    to.frequency = from.frequency;
    to.bandwidth = from.bandwidth;
    to.sound_speed = from.sound_speed;
    to.pitch = from.pitch;
    to.element_width = from.element_width;
    to.height = from.height;
    to.elevation_focus = from.elevation_focus;
    to.places = from.places;
    to.sent = from.sent;
    return to;
}

/// @throws usage_error  for channel data whose parts do not fit
template <class Sample>
void check_channels(const channel_grid<Sample>& data, const char* caller) {
    const bool whole = data.transmits > 0 && data.elements > 0 && data.samples > 0 &&
                       data.sent.size() == data.transmits && data.places.size() == data.elements &&
                       data.values.size() == std::size_t{data.transmits} * data.elements * data.samples;
    if (!whole)
        throw usage_error{caller, ": the channel data are empty, or `values`, `sent` and `places` do not have "
                                  "the sizes that `transmits`, `elements` and `samples` state"};
    if (!is_finite(data.sampling_frequency) || !(data.sampling_frequency > 0) || !is_finite(data.frequency) ||
        !(data.frequency > 0) || !is_finite(data.start))
        throw usage_error{caller,
                          ": `sampling_frequency`, `frequency` and `start` of the channel data must be finite, the "
                          "first two above 0"};
    if (!is_finite(data.pitch) || !is_finite(data.element_width) || !(data.pitch >= 0 && data.element_width >= 0))
        throw usage_error{caller, ": `pitch` and `element_width` of the channel data must be metres, or 0 where "
                                  "they are unknown"};
    for (std::size_t i = 0; i < data.places.size(); ++i)
        if (!is_finite(data.places[i].origin) || !is_finite(data.places[i].direction))
            throw usage_error{caller, ": place ", i,
                              " of the channel data is not finite; give the centre and the normal of each element"};
    for (std::size_t i = 0; i < data.sent.size(); ++i) check_transmit(data.sent[i], i, data.elements);
}

} // namespace detail

/// Complex baseband of RF: the analytic signal, turned back by the carrier, so that its magnitude is the envelope.
///
///     iq(t) = (rf(t) + i H rf(t)) exp(-i 2 pi f0 t)        H: Hilbert transform, t since the first element fires
///
/// The samples stay as many as they are; thin them out as the bandwidth permits.
/// @throws usage_error  for channel data whose parts do not fit
template <exec::policy Policy>
iq_channel_data demodulate(const Policy& policy, const channel_data& received) {
    detail::check_channels(received, "demodulate");
    iq_channel_data out = detail::same_acquisition<vec2>(received);
    out.values.resize(received.values.size());
    const std::size_t samples = received.samples;
    std::vector<vec2> carrier(samples);
    for (std::size_t k = 0; k < samples; ++k)
        carrier[k] =
            detail::turned(-double{received.frequency} *
                           (double{received.start} + static_cast<double>(k) / double{received.sampling_frequency}));
    detail::for_each_analytic(policy, received.values, samples, [&](std::size_t channel, std::size_t k, vec2 value) {
        out.values[channel * samples + k] = detail::complex_product(carrier[k], value);
    });
    return out;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
