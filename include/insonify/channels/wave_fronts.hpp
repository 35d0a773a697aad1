#ifndef INSONIFY_CHANNELS_WAVE_FRONTS_HPP
#define INSONIFY_CHANNELS_WAVE_FRONTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/channels/element_field.hpp>
#include <insonify/channels/fourier.hpp>
#include <insonify/channels/pair_sums.hpp>
#include <insonify/channels/transmit.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The wave front of each transmit at reflectors: what arrives within three periods of the first wave, which the elements
/// around its origin send, at the time of the middle of its energy. The later waves of the others cancel, but for those
/// from the ends of the aperture, which are left out.
class wave_fronts {
  public:
    /// @param frequency  of the carrier, hertz
    /// @param node_step  see `spectral_value`, hertz
    wave_fronts(view<const transmit> sent, std::size_t elements, float frequency, float node_step)
        : elements_{elements}, columns_{(elements + width - 1) / width * width}, frequency_{frequency}, node_step_{
                                                                                                            node_step} {
        for (const transmit& one : sent) {
            front& own = fronts_.emplace_back();
            own.delay.assign(columns_, wave_table::never);
            own.x.assign(columns_, 0.0F);
            own.y.assign(columns_, 0.0F);
            for (std::uint32_t n = 0; n < elements; ++n) {
                if (one.weight(n) == 0) continue;
                const vec2 delayed = one.weight(n) * turned(-double{frequency} * double{one.delays[n]});
                own.delay[n] = one.delays[n];
                own.x[n] = delayed.x;
                own.y[n] = delayed.y;
            }
        }
    }

    /// @param of_elements  what arrives from each element
    /// @param place        of the reflector in both tables
    void find(const wave_table& of_elements, wave_table& sent, std::size_t place) const {
        std::vector<float> waves(floats_per_wave * columns_, 0.0F), times(columns_, wave_table::never); // by part first
        for (std::size_t n = 0; n < elements_; ++n) {
            times[n] = of_elements.time(n)[place];
            const float* const one = of_elements.waves(n) + floats_per_wave * place;
            for (std::size_t part = 0; part < floats_per_wave; ++part) waves[(part % 2 * nodes + part / 2) * columns_ + n] = one[part];
        }
        for (std::size_t t = 0; t < fronts_.size(); ++t) send(fronts_[t], times, waves, sent, t, place);
    }

  private:
    static constexpr int width = max_simd_width;
    static constexpr int nodes = spectral_value::nodes;
    using floats = lanes<width>;

    struct front {
        std::vector<float> delay{}, x{}, y{}; // of each element: s; its weight with the phase of its delay
    };

    void send(const front& own, const std::vector<float>& times, const std::vector<float>& waves, wave_table& sent,
              std::size_t column, std::size_t place) const {
        const auto arrival = [&](std::size_t n) {
            return load<width>(times.data() + n) + load<width>(own.delay.data() + n);
        };
        floats earliest(wave_table::never);
        for (std::size_t n = 0; n < columns_; n += width) earliest = min(earliest, arrival(n));
        const float first = reduce_min(earliest);
        if (!(first < wave_table::never)) return sent.clear(column, place);
        floats x[nodes], y[nodes], moment_x(0.0F), moment_y(0.0F);
        for (int k = 0; k < nodes; ++k) x[k] = y[k] = floats(0.0F);
        for (std::size_t n = 0; n < columns_; n += width) {
            const floats later = arrival(n) - floats(first), part = later * floats(frequency_ / 3);
            const auto near = part < floats(1.0F);
            if (bits_of(near) == 0) continue;
            const floats window = floats(1.0F) - part * part, weight = select(near, window * window, floats(0.0F));
            const floats real = weight * load<width>(own.x.data() + n),
                         imaginary = weight * load<width>(own.y.data() + n);
            floats middle_x(0.0F), middle_y(0.0F);
            for (int k = 0; k < nodes; ++k) {
                const float* const from = waves.data() + static_cast<std::size_t>(k) * columns_ + n;
                const floats a = load<width>(from), b = load<width>(from + nodes * columns_);
                const floats here_x = real * a - imaginary * b, here_y = real * b + imaginary * a;
                x[k] = x[k] + here_x;
                y[k] = y[k] + here_y;
                if (k != nodes / 2 - 1 && k != nodes / 2) continue;
                middle_x = middle_x + here_x;
                middle_y = middle_y + here_y;
            }
            const floats half_later = select(near, floats(0.5F) * later, floats(0.0F));
            moment_x = moment_x + half_later * middle_x;
            moment_y = moment_y + half_later * middle_y;
        }
        // -d phase / d omega of the sum is Re(moment / value); what is left of the moment turns it over frequency.
        const auto wave = spectral_value::each([&](int k) { return vec2{sum(x[k]), sum(y[k])}; });
        const vec2 moment{sum(moment_x), sum(moment_y)}, middle = wave.at_carrier();
        const float power = dot(middle, middle);
        if (!(power > 0)) return sent.clear(column, place);
        const float later = dot(moment, middle) / power;
        const vec2 left = 2 * pi * node_step_ * (moment - later * middle);
        sent.set(column, place, first + later, 0.5F,
                 wave + spectral_value::steps() * spectral_value::everywhere({left.y, -left.x}));
    }

    std::size_t elements_, columns_;
    float frequency_, node_step_;
    std::vector<front> fronts_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
