#ifndef INSONIFY_CHANNELS_WAVE_FRONTS_HPP
#define INSONIFY_CHANNELS_WAVE_FRONTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/channels/element_field.hpp>
#include <insonify/channels/pair_sums.hpp>
#include <insonify/channels/transmit.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The wave front of each transmit at reflectors, at two frequencies: what arrives within three periods of the first
/// wave, which the elements around its origin send, at the time of the middle of its energy. The later waves of the
/// others cancel, but for those from the ends of the aperture, which are left out.
class wave_fronts {
  public:
    /// @param frequency  of the carrier, hertz
    /// @param node_step  see `spectral_value`, hertz
    wave_fronts(view<const transmit> sent, std::size_t elements, float frequency, float node_step)
        : elements_{elements}, columns_{(elements + width - 1) / width * width}, frequency_{frequency}, node_step_{
                                                                                                            node_step} {
        for (const transmit& one : sent) {
            front& own = fronts_.emplace_back();
            own.delay.assign(columns_, table::never);
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

    static constexpr int nodes = 2;
    using table = wave_table<nodes>;

    /// At some reflectors, by their places in both tables. @param of_elements  what arrives from each element
    void find(const table& of_elements, table& sent, std::size_t begin, std::size_t end) const {
        arrivals of_one{std::vector<float>(columns_, table::never),
                        std::vector<float>(columns_ * floats_per_wave<nodes>, 0.0F)};
        for (std::size_t place = begin; place < end; ++place) {
            for (std::size_t n = 0; n < elements_; ++n) {
                of_one.times[n] = of_elements.time(n)[place];
                const float* const wave = of_elements.waves(n) + floats_per_wave<nodes> * place;
                for (std::size_t part = 0; part < floats_per_wave<nodes>; ++part)
                    of_one.waves[part * columns_ + n] = wave[part];
            }
            for (std::size_t t = 0; t < fronts_.size(); ++t) send(fronts_[t], of_one, sent, t, place);
        }
    }

  private:
    static constexpr int width = max_simd_width;
    using floats = lanes<width>;

    struct front {
        std::vector<float> delay{}, x{}, y{}; // of each element: s; its weight with the phase of its delay
    };
    struct arrivals {                    // at one reflector, of each element
        std::vector<float> times, waves; // waves: real and imaginary part at each node, part by part
    };

    void send(const front& own, const arrivals& from, table& sent, std::size_t column, std::size_t place) const {
        const auto arrival = [&](std::size_t n) {
            return load<width>(from.times.data() + n) + load<width>(own.delay.data() + n);
        };
        floats earliest(table::never);
        for (std::size_t n = 0; n < columns_; n += width) earliest = min(earliest, arrival(n));
        const float first = reduce_min(earliest);
        if (!(first < table::never)) return sent.clear(column, place);
        floats parts[2 * nodes], moment_x(0.0F), moment_y(0.0F);
        for (floats& one : parts) one = floats(0.0F);
        for (std::size_t n = 0; n < columns_; n += width) {
            const floats later = arrival(n) - floats(first), part = later * floats(frequency_ / 3);
            const auto near = part < floats(1.0F);
            if (bits_of(near) == 0) continue;
            const floats window = floats(1.0F) - part * part, weight = select(near, window * window, floats(0.0F));
            const floats x = weight * load<width>(own.x.data() + n), y = weight * load<width>(own.y.data() + n);
            const floats half_later = select(near, floats(0.5F) * later, floats(0.0F));
            for (std::size_t k = 0; k < nodes; ++k) {
                const float* const wave = from.waves.data() + 2 * k * columns_ + n;
                const floats a = load<width>(wave), b = load<width>(wave + columns_);
                const floats here_x = x * a - y * b, here_y = x * b + y * a;
                parts[2 * k] = parts[2 * k] + here_x;
                parts[2 * k + 1] = parts[2 * k + 1] + here_y;
                moment_x = moment_x + half_later * here_x;
                moment_y = moment_y + half_later * here_y;
            }
        }
        // -d phase / d omega of the sum is Re(moment / value); what is left of the moment turns it over frequency.
        vec2 wave[nodes], middle{0, 0};
        for (std::size_t k = 0; k < nodes; ++k) {
            wave[k] = {sum(parts[2 * k]), sum(parts[2 * k + 1])};
            middle += wave[k] / static_cast<float>(nodes);
        }
        const vec2 moment{sum(moment_x), sum(moment_y)};
        const float power = dot(middle, middle);
        if (!(power > 0)) return sent.clear(column, place);
        const float later = dot(moment, middle) / power;
        const vec2 left = 2 * pi * node_step_ * (moment - later * middle);
        float* const to = sent.set(column, place, first + later, 0.5F);
        for (std::size_t k = 0; k < nodes; ++k) {
            const vec2 turned = wave[k] + (static_cast<float>(k) - 0.5F * (nodes - 1)) * vec2{left.y, -left.x};
            to[2 * k] = turned.x;
            to[2 * k + 1] = turned.y;
        }
    }

    std::size_t elements_, columns_;
    float frequency_, node_step_;
    std::vector<front> fronts_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
