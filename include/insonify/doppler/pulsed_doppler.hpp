#ifndef INSONIFY_DOPPLER_PULSED_DOPPLER_HPP
#define INSONIFY_DOPPLER_PULSED_DOPPLER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/colour_doppler.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/fourier.hpp>
#include <algorithm>
#include <bit>

namespace insonify::inline INSONIFY_ABI {

/// How a series of echoes becomes a spectrum against time.
struct spectrum_settings {
    std::uint32_t window = 128; ///< pulses of each spectrum, a power of two; Hann window
    float overlap = 0.75F;      ///< of successive windows, 0 to below 1
    float baseline = 0;         ///< -0.5 to 0.5: how far the range of velocities is shifted up, of its whole
    float angle = 0;            ///< between line and flow, radians, below 85_deg: velocities are divided by its cosine
    std::uint32_t wall_order = 1; ///< each window is filtered by a polynomial of this degree: see `wall_filter`

    /// @throws usage_error  for a setting out of range
    void check() const {
        if (window < 8 || window > 65536 || !std::has_single_bit(window))
            throw usage_error{"spectrum_settings: `window` must be a power of two from 8 to 65536 pulses"};
        if (!(overlap >= 0 && overlap < 1))
            throw usage_error{"spectrum_settings: `overlap` must be 0 to below 1, such as 0.75"};
        if (!(std::fabs(baseline) <= 0.5F))
            throw usage_error{"spectrum_settings: `baseline` must be -0.5 to 0.5 of the range of velocities"};
        if (!(std::fabs(angle) <= 1.4835299F)) // 85 degrees
            throw usage_error{"spectrum_settings: `angle` must be at most 85_deg; beyond, its cosine is too uncertain"};
        if (wall_order > 8 || wall_order + 2 > window)
            throw usage_error{
                "spectrum_settings: `wall_order` is at most 8, and 2 less than `window`; 1 or 2 is usual"};
    }
    /// @throws usage_error  for fewer pulses than a window has
    void check_pulses(std::size_t pulses) const {
        if (pulses < window)
            throw usage_error{"spectrum_of: ", pulses, " pulses are fewer than the window of ", window,
                              "; lower it or raise the duration"};
    }

    friend bool operator==(const spectrum_settings&, const spectrum_settings&) = default;
};

/// Power by velocity, window after window.
struct doppler_spectrum {
    std::uint32_t windows = 0;  ///< number of windows
    std::uint32_t bins = 0;     ///< velocities of each
    float first_time = 0;       ///< of the middle of the first window, seconds
    float interval = 0;         ///< from window to window, seconds
    float lowest_velocity = 0;  ///< of bin 0, m/s; towards the probe is positive
    float step = 0;             ///< from bin to bin, m/s
    std::vector<float> power{}; ///< window after window; the sum over the bins is the mean power of the window

    /// Power of a bin; indices are not checked.
    float operator()(std::uint32_t window, std::uint32_t bin) const { return power[std::size_t{window} * bins + bin]; }
    /// Velocity of a bin, m/s.
    float velocity(std::uint32_t bin) const { return lowest_velocity + step * static_cast<float>(bin); }

    /// The mean velocity of a window, m/s.
    float mean_velocity(std::uint32_t window) const {
        double sum = 0, all = 1e-300;
        for (std::uint32_t i = 0; i < bins; ++i) {
            sum += static_cast<double>((*this)(window, i) * velocity(i));
            all += static_cast<double>((*this)(window, i));
        }
        return static_cast<float>(sum / all);
    }

    friend bool operator==(const doppler_spectrum&, const doppler_spectrum&) = default;
};

/// Short-time spectrum of the echoes of one gate.
///
/// @param echoes        one for each pulse
/// @param prf           pulse repetition frequency, hertz
/// @param max_velocity  that does not alias, m/s: see `max_doppler_velocity`
/// @param start         time of the first pulse, seconds
/// @throws usage_error  for a number or a setting out of range, or fewer pulses than a window
template <exec::policy Policy>
doppler_spectrum spectrum_of(const Policy& policy, const std::vector<vec2>& echoes, float prf, float max_velocity,
                             float start, const spectrum_settings& settings) {
    settings.check();
    if (!is_finite(prf) || !(prf > 0) || !is_finite(max_velocity) || !(max_velocity > 0) || !is_finite(start))
        throw usage_error{"spectrum_of: the prf and the largest velocity must be finite and above 0, `start` finite"};
    settings.check_pulses(echoes.size());
    const std::uint32_t size = settings.window;
    const auto hop = static_cast<std::uint32_t>(max(1, std::round(static_cast<float>(size) * (1 - settings.overlap))));
    const float whole = 2 * max_velocity / std::cos(settings.angle);
    const auto lowest = static_cast<std::int32_t>(
        std::lround((settings.baseline - 0.5F) * static_cast<float>(size))); // bin of the transform
    doppler_spectrum result{.windows = static_cast<std::uint32_t>((echoes.size() - size) / hop + 1),
                            .bins = size,
                            .first_time = start + 0.5F * static_cast<float>(size) / prf,
                            .interval = static_cast<float>(hop) / prf,
                            .lowest_velocity = whole * static_cast<float>(lowest) / static_cast<float>(size),
                            .step = whole / static_cast<float>(size)};
    result.power.resize(std::size_t{result.windows} * size);
    std::vector<float> hann(size);
    float weight = 0;
    for (std::uint32_t k = 0; k < size; ++k) {
        hann[k] = 0.5F - 0.5F * std::cos(2 * pi * (static_cast<float>(k) + 0.5F) / static_cast<float>(size));
        weight += hann[k] * hann[k];
    }
    const auto walls = detail::orthonormal_polynomials(size, settings.wall_order);
    const detail::fourier fourier{size};
    constexpr auto together = detail::complex_batch::width;
    const auto transform = [&](std::size_t first, std::size_t end) {
        std::vector<detail::complex_block> values(size), room(size); // a window in each lane
        std::vector<vec2> part(size);
        for (std::size_t window = first; window < end; ++window) {
            std::copy_n(echoes.data() + window * hop, size, part.data());
            for (const std::vector<double>& wall : walls) { // less the projection on it
                dvec2 along{0, 0};
                for (std::uint32_t k = 0; k < size; ++k) along += wall[k] * dvec2{part[k]};
                for (std::uint32_t k = 0; k < size; ++k) part[k] -= vec2{wall[k] * along};
            }
            for (std::uint32_t k = 0; k < size; ++k) {
                values[k].x[window - first] = hann[k] * part[k].x;
                values[k].y[window - first] = hann[k] * part[k].y;
            }
        }
        fourier.forward(values, room);
        const lanes<together> scale(1 / (weight * static_cast<float>(size)));
        for (std::uint32_t i = 0; i < size; ++i) {
            const detail::complex_batch bin = values[(static_cast<std::uint32_t>(lowest) + i) & (size - 1)].loaded();
            float power[together];
            store(scale * (bin.x * bin.x + bin.y * bin.y), power);
            for (std::size_t window = first; window < end; ++window)
                result.power[window * size + i] = power[window - first];
        }
    };
    exec::for_each_block(policy, result.windows, together, 15 * static_cast<float>(size), transform);
    return result;
}

/// Settings of pulsed Doppler, as on a scanner.
struct pulsed_doppler_settings {
    std::uint32_t line = 0;       ///< of the probe
    float gate = 0.02F;           ///< depth of the middle of the gate along the line, metres
    float gate_length = 1e-3F;    ///< metres
    float prf = 5e3F;             ///< pulse repetition frequency, hertz
    float duration = 1;           ///< of the acquisition, seconds
    spectrum_settings spectrum{}; ///< windows, baseline and angle
    float burst = 6;              ///< length of the excitation, in cycles
    float depth = 0;              ///< of the image, which chooses the focus, metres; 0: twice the depth of the gate
    std::uint32_t planes = 1;     ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float time = 0;               ///< of the first pulse, seconds: the same time gives the same spectrum
    float noise_db = -135;        ///< electronic noise: see `electronic_noise_settings`
    std::uint64_t seed = 1;       ///< of the noise

    /// Number of pulses.
    std::uint32_t pulses() const { return static_cast<std::uint32_t>(duration * prf); }

    /// @throws usage_error  for a setting out of range
    template <transducer Probe>
    void check(const Probe& probe) const {
        probe.check();
        spectrum.check();
        if (line >= probe.lines)
            throw usage_error{"pulsed_doppler: line ", line, " is not one of the probe, which has ", probe.lines};
        check_length(gate, "gate", max_scan_depth, "pulsed_doppler");
        check_length(gate_length, "gate_length", max_scan_depth, "pulsed_doppler");
        if (depth != 0) check_depth(depth, "pulsed_doppler");
        if (depth != 0 && gate - 0.5F * gate_length >= depth)
            throw usage_error{"pulsed_doppler: the gate is ", gate * 1e3F, " mm deep, below the end of the image at ",
                              depth * 1e3F, " mm; raise it, or `depth`"};
        if (!is_finite(duration) || !(duration * prf >= 1 && duration * prf <= 0x1p20F))
            throw usage_error{"pulsed_doppler: `duration` times `prf` must be 1 to 2^20 pulses; 1_s at 5_kHz is usual"};
    }
};

/// `pulsed_doppler`, series after series: allocates only while buffers grow.
template <acoustic_model Model = physical<>>
class gate_scanner {
  public:
    /// The echoes of a gate on one line, pulse after pulse: the sum over the gate, a mean of its samples.
    /// @return the series, from which `spectrum_of` computes a spectrum
    /// @throws usage_error, geometry_error  as `pulsed_doppler`
    template <exec::policy Policy, transducer Probe, velocity_field Field>
    std::vector<vec2> gate_echoes(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                  const Model& model, const Field& field, const pulsed_doppler_settings& settings) {
        settings.check(probe);
        const float depth = settings.depth > 0 ? settings.depth : 2 * settings.gate;
        const pulse sent = nominal_pulse(probe, settings.burst);
        sent.check(probe.frequency);
        const auto fine = detail::doppler_probe(probe, depth, model);
        const float line = std::floor((static_cast<float>(settings.line) + 0.5F) * fine.rays);
        const auto lines = detail::lines_around(fine, depth, line, line, beam_);

        const float sigma = sent.sigma_z(probe.frequency),
                    spacing = depth / static_cast<float>(samples_for(depth, sigma));
        const float from = max(settings.gate - 0.5F * settings.gate_length, 0), to = from + settings.gate_length;
        const float beyond = sent.envelope(probe.frequency).half_length();
        const auto samples = static_cast<std::uint32_t>(std::ceil((to + beyond) / spacing));
        const auto first = static_cast<std::uint32_t>(from / spacing),
                   last = std::min(samples, static_cast<std::uint32_t>(to / spacing) + 1);
        const std::uint32_t pulses = settings.pulses();
        const std::uint32_t parts = (pulses + 255) / 256; // each of a few megabytes
        const std::uint32_t part = (pulses + parts - 1) / parts;
        ensemble_settings train = detail::train_of(settings, samples, spacing, from - beyond);
        std::vector<vec2> series;
        series.reserve(pulses);
        for (std::uint32_t k = 0; k < pulses; k += part) {
            train.first = k;
            train.pulses = std::min(part, pulses - k);
            const iq_ensemble& echoes = train_.acquire(policy, body, lines, at, model, field, train);
            for (const iq_lines& each : echoes.pulses) {
                vec2 sum{0, 0};
                for (std::uint32_t i = first; i < last; ++i)
                    sum += each(static_cast<std::uint32_t>(line - lines.first_line), i);
                series.push_back(sum / static_cast<float>(last - first));
            }
        }
        return series;
    }

    /// See `pulsed_doppler`.
    template <exec::policy Policy, transducer Probe, velocity_field Field>
    doppler_spectrum acquire(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                             const Model& model, const Field& field, const pulsed_doppler_settings& settings) {
        settings.check(probe);
        settings.spectrum.check_pulses(settings.pulses());
        return spectrum_of(policy, gate_echoes(policy, body, probe, at, model, field, settings), settings.prf,
                           max_doppler_velocity(settings.prf, probe.frequency), settings.time, settings.spectrum);
    }

  private:
    ensemble_scanner<Model> train_{};
    detail::lateral_kernel beam_{};
};

/// Pulsed Doppler: the spectrum of a gate on one line against time.
///
///     doppler_ensemble -> sum over the gate -> spectrum_of
///
/// Velocities are along the line, towards the probe positive, or along the flow where `spectrum.angle` is given.
///
///     const doppler_spectrum seen = pulsed_doppler(exec::par_unseq, body, probe, at, stream,
///                                                  {.line = 64, .gate = 22_mm, .spectrum = {.angle = 60_deg}});
///
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
doppler_spectrum pulsed_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const Model& model, const Field& field, const pulsed_doppler_settings& settings = {}) {
    return gate_scanner<Model>{}.acquire(policy, body, probe, at, model, field, settings);
}
/// The same with `physical`.
template <exec::policy Policy, transducer Probe, velocity_field Field>
doppler_spectrum pulsed_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const Field& field, const pulsed_doppler_settings& settings = {}) {
    return pulsed_doppler(policy, body, probe, at, physical<>{}, field, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
