#ifndef INSONIFY_CHANNELS_BEAMFORM_HPP
#define INSONIFY_CHANNELS_BEAMFORM_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/channels/channel_data.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/probe_lines.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Weights of elements across an aperture.
enum class aperture_window {
    rectangular, ///< all alike
    hann,        ///< raised cosine, 0 at the ends
    hamming,     ///< raised cosine, 0.08 at the ends
    tukey,       ///< rectangular, its outer quarters a raised cosine
};

/// How channel data become lines.
struct beamform_settings {
    float fnumber = 2; ///< depth over the width of the aperture that receives, and that fires element by element
    aperture_window window = aperture_window::rectangular; ///< of that aperture
    float sound_speed = 0;                                 ///< m/s; 0: that of the channel data

    friend bool operator==(const beamform_settings&, const beamform_settings&) = default;
};

namespace detail {

/// @param place  -1 to 1 across the aperture
inline float window_weight(aperture_window window, float place) {
    const float size = std::fabs(place);
    if (size > 1) return 0;
    switch (window) {
    case aperture_window::rectangular:
        return 1;
    case aperture_window::hann:
        return 0.5F + 0.5F * std::cos(pi * size);
    case aperture_window::hamming:
        return 0.54F + 0.46F * std::cos(pi * size);
    case aperture_window::tukey:
        return size < 0.5F ? 1.0F : 0.5F + 0.5F * std::cos(2 * pi * (size - 0.5F));
    }
    return 1;
}

/// When the wave front of a transmit arrives at a point, and whether it lights it.
class wave_front {
  public:
    /// @param speed  of sound, m/s
    wave_front(const transmit& sent, view<const ray> places, float speed)
        : sent_{sent}, places_{places}, speed_{speed} {
        float width = 0;
        for (std::uint32_t i = 0; i < places.size(); ++i) {
            if (sent.weight(i) == 0) continue;
            if (firing_ == 0) first_ = i;
            ++firing_;
            width = max(width, 2 * length(places[i].origin - sent.origin));
        }
        half_width_ = 0.5F * width;
        const ray& one = places[first_];
        direction_ = {std::sin(sent.angle), 0, std::cos(sent.angle)};
        start_ = travelled(one.origin) / speed - sent.delays[first_];
    }

    /// Seconds after the first element fires.
    float time(vec3 p) const {
        if (sent_.front != transmit::wave::any) return travelled(p) / speed_ - start_;
        float first = FLT_MAX;
        for (std::uint32_t i = first_; i < places_.size(); ++i)
            if (sent_.weight(i) != 0) first = min(first, sent_.delays[i] + length(p - places_[i].origin) / speed_);
        return first;
    }
    /// Weight of this transmit at a point: by the window where one element fires, as if it were part of an aperture;
    /// within the cones of a focused beam; else 1.
    /// @param aperture  half of its width for the point, metres
    float weight(vec3 p, vec3 foot, vec3 along, float aperture, aperture_window window) const {
        if (firing_ == 1) {
            const vec3 to = places_[first_].origin - foot;
            return window_weight(window, length(to - dot(to, along) * along) / aperture);
        }
        if (sent_.front != transmit::wave::focused) return 1;
        const vec3 axis = sent_.source - sent_.origin, to = p - sent_.origin;
        const float depth = length(axis), at = dot(to, axis) / depth;
        const float beside = length(to - at / depth * axis);
        // Around the focus the beam is as wide as diffraction makes it: half a millimetre is that of F/2 at 6 MHz.
        return beside <= max(half_width_ * std::fabs(1 - at / depth), 0.5e-3F) ? 1.0F : 0.0F;
    }
    /// Of an element that fires, without its sign.
    float fired(std::uint32_t element) const { return std::fabs(sent_.weight(element)); }

  private:
    // How far the front has come at a point, metres; from its source, or its focus.
    float travelled(vec3 p) const {
        if (sent_.front == transmit::wave::plane) return dot(p, direction_);
        const vec3 from = p - sent_.source;
        const bool converges = sent_.front == transmit::wave::focused && !(dot(from, sent_.source - sent_.origin) > 0);
        return converges ? -length(from) : length(from);
    }

    const transmit& sent_;
    view<const ray> places_;
    float speed_, start_ = 0, half_width_ = 0;
    std::uint32_t first_ = 0, firing_ = 0;
    vec3 direction_{0, 0, 1};
};

/// The work of `beamform`, for probes as data.
template <class Policy>
iq_lines sum_channels(const Policy& policy, const iq_channel_data& data, const probe_lines& probe,
                      const acquisition& grid, const beamform_settings& settings) {
    const float speed = settings.sound_speed > 0 ? settings.sound_speed : data.sound_speed;
    const std::uint32_t chosen =
        grid.samples != 0
            ? grid.samples
            : samples_for(grid.depth, axial_sigma(data.bandwidth > 0 ? data.bandwidth : 0.6F, data.frequency));
    const std::uint32_t samples = checked_samples(probe.size(), chosen, "beamform");
    iq_lines lines{probe.size(), samples, grid.depth};
    const view<const ray> places{data.places};
    std::vector<wave_front> fronts;
    fronts.reserve(data.transmits);
    for (const transmit& one : data.sent) fronts.emplace_back(one, places, speed);
    const float filled = data.pitch > 0 && data.element_width > 0 ? data.element_width / data.pitch : 1.0F;
    const float time =
        6.0F * static_cast<float>(samples) * static_cast<float>(data.transmits) * static_cast<float>(data.elements);
    struct receiver {
        std::uint32_t element;
        float time, weight;
        vec2 factor; // its weight, and the phase of the carrier
    };
    exec::for_each_block(policy, lines.count, 1, time, [&](std::size_t line, std::size_t) {
        const probe_line& beam = probe[line];
        const std::uint32_t last = data.samples - 3;
        std::vector<receiver> receivers;
        for (std::uint32_t k = 0; k < samples; ++k) {
            const float depth = (static_cast<float>(k) + 0.5F) * grid.depth / static_cast<float>(samples);
            const vec3 p = beam.origin + depth * beam.direction;
            const float aperture = max(0.5F * depth / settings.fnumber, 0.51F * data.pitch);
            receivers.clear();
            for (std::uint32_t n = 0; n < data.elements; ++n) {
                const vec3 to = places[n].origin - beam.origin;
                const float weight =
                    window_weight(settings.window, length(to - dot(to, beam.direction) * beam.direction) / aperture);
                if (weight == 0) continue;
                const float arrives = length(p - places[n].origin) / speed;
                receivers.push_back({n, arrives, weight, weight * turned(double{data.frequency} * double{arrives})});
            }
            vec2 whole{0, 0};
            float norm = 0;
            for (std::uint32_t t = 0; t < data.transmits; ++t) {
                const wave_front& front = fronts[t];
                const float weight = front.weight(p, beam.origin, beam.direction, aperture, settings.window);
                if (weight == 0) continue;
                const float sent = front.time(p);
                vec2 sum{0, 0};
                float fired = 0;
                for (const receiver& one : receivers) {
                    fired += one.weight * front.fired(one.element);
                    const float place = (sent + one.time - data.start) * data.sampling_frequency;
                    if (!(place >= 1 && place < static_cast<float>(last))) continue;
                    const auto below = static_cast<std::uint32_t>(place);
                    const float u = place - static_cast<float>(below), v = 1 - u;
                    const vec2* const at = &data(t, one.element, below - 1);
                    // Lagrange's polynomial of degree three.
                    const vec2 value = (-u * v * (1 + v) / 6) * at[0] + (0.5F * (1 + u) * v * (1 + v)) * at[1] +
                                       (0.5F * (1 + u) * u * (1 + v)) * at[2] + (-u * v * (1 + u) / 6) * at[3];
                    sum += complex_product(value, one.factor);
                }
                norm += weight * fired;
                whole += complex_product(sum, weight * turned(double{data.frequency} * double{sent}));
            }
            if (!(norm > 0)) continue;
            const vec2 baseband = turned(-2 * double{data.frequency} * double{depth} / double{speed});
            lines(static_cast<std::uint32_t>(line), k) = 1 / (norm * filled) * complex_product(whole, baseband);
        }
    });
    return lines;
}

} // namespace detail

/// Lines of a probe from channel data, by delay and sum: each sample is the sum over transmits and elements of what was
/// received when an echo from its point would have been.
///
///     const iq_lines lines = beamform(exec::par_unseq, received, linear_array{}, {.depth = 40_mm}, {.fnumber = 1.5F});
///
/// The elements within `fnumber` receive, each with the weight of the window; where single elements fire, the same
/// holds for them. The sum is divided by (width / pitch) times the sum over transmits and elements of the weights with
/// which each element fires and receives: in the focus of focused and synthetic transmits, 1 is then the echo of a
/// perfect mirror, as everywhere else. Everything that follows `convolve` takes these lines as they are.
/// @param received  RF, or the IQ of it that `demodulate` makes
/// @param probe     whose lines are to be made, in the frame of the array
/// @param grid      depth and samples; other members have no effect
/// @throws usage_error  for channel data whose parts do not fit, or settings out of range
/// @{
template <exec::policy Policy, transducer Probe>
iq_lines beamform(const Policy& policy, const iq_channel_data& received, const Probe& probe, const acquisition& grid,
                  const beamform_settings& settings = {}) {
    detail::check_channels(received, "beamform");
    check_depth(grid.depth, "beamform");
    if (received.samples < 8) throw usage_error{"beamform: the channel data have fewer than 8 samples; record more"};
    if (!is_finite(settings.fnumber) || !(settings.fnumber > 0.05F))
        throw usage_error{"beamform: `fnumber` must be above 0.05, such as 1.5"};
    const float speed = settings.sound_speed != 0 ? settings.sound_speed : received.sound_speed;
    if (!is_finite(speed) || !(speed >= 100 && speed <= 10000))
        throw usage_error{"beamform: the sound speed is ", speed,
                          " m/s; `sound_speed` of the settings, or of the channel data where that is 0, "
                          "must be 100 to 10000"};
    return detail::sum_channels(detail::any_policy<false>{policy}, received, detail::probe_lines{probe}, grid,
                                settings);
}
template <exec::policy Policy, transducer Probe>
iq_lines beamform(const Policy& policy, const channel_data& received, const Probe& probe, const acquisition& grid,
                  const beamform_settings& settings = {}) {
    return beamform(policy, demodulate(policy, received), probe, grid, settings);
}
/// @}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
