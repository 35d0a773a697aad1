#ifndef INSONIFY_TRACING_READ_GAS_REVERBERATION_HPP
#define INSONIFY_TRACING_READ_GAS_REVERBERATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// Echoes that appear behind gas, of sound that it reflects: the mirror image of the tissue in front of it, and the
/// reverberation between gas and the face of the probe.
struct gas_reverberation {
    float mirror = 1; ///< part of the amplitude of the mirror image that is drawn, 0 (none) to 1
    float face = 1;   ///< the same of the reverberation with the face

    /// @throws usage_error  for a setting that is out of range
    void check() const {
        if (!(mirror >= 0 && mirror <= 1) || !(face >= 0 && face <= 1))
            throw usage_error{"gas_reverberation: `mirror` and `face` must be 0 (not drawn) to 1"};
    }

    friend bool operator==(const gas_reverberation&, const gas_reverberation&) = default;
};

namespace detail {

/// The first surface of gas on a line, and the losses on the way back from it.
class gas_surface {
  public:
    gas_surface(view<const layer> layers, view<const medium> media, float frequency)
        : layers_{layers}, media_{media}, frequency_{frequency} {
        while (next_ < layers.size() && !is_gas(media[layers[next_].medium])) {
            shown_ += stretch();
            loss_db_ += loss();
            ++next_;
        }
        if (next_ == 0 || next_ == layers.size()) return;
        const float before = media[layers[next_ - 1].medium].impedance(), gas = media[layers[next_].medium].impedance();
        reflected = (gas - before) / (gas + before);
        const float first = media[layers[0].medium].impedance(), lens = tissue::lens.impedance();
        lens_reflected = (lens - first) / (lens + first);
        curvature = {layers[next_].curvature.x, layers[next_].curvature.y};
        shown = shown_;
        loss_db = loss_db_;
    }

    float shown = 0;          ///< displayed depth, metres; 0: there is none, or the line starts in gas
    float loss_db = 0;        ///< attenuation down to it, there and back, dB
    float reflected = 0;      ///< amplitude
    float lens_reflected = 0; ///< amplitude, of sound that returns to the face
    vec2 curvature{0, 0};     ///< 1/m, above 0 where it bulges towards the probe

    /// Attenuation down to a displayed depth, there and back, dB; from call to call less deep.
    float loss_to(float depth) {
        while (next_ > 0 && depth < shown_) {
            --next_;
            shown_ -= stretch();
            loss_db_ -= loss();
        }
        return loss_db_ + max(depth - shown_, 0) * (loss() / max(stretch(), 1e-9F));
    }

  private:
    // Displayed length and loss of the layer `next_`.
    float length() const { return layers_[next_].end - layers_[next_].begin; }
    float stretch() const { return length() * displayed_stretch(media_[layers_[next_].medium]); }
    float loss() const { return length() * echo_loss(media_[layers_[next_].medium], frequency_); }

    view<const layer> layers_;
    view<const medium> media_;
    float frequency_;
    std::size_t next_ = 0; // the layer that begins at `shown_`
    float shown_ = 0, loss_db_ = 0;
};

} // namespace detail

/// Adds the echoes that appear behind gas to traced echoes: straight lines end at its surface. Call it between `trace`
/// and `convolve`.
///
///     at 2 D - z:  r^2 10^((L(z) - L(D)) / 10) / sqrt((1 + 2 h k_x)(1 + 2 h k_y)) of the conjugate echo at z < D
///     at D + z:    n r f 10^(-L(D) / 20) of the echo at z, n = 2 for z < D, else 1
///
/// with D the displayed depth of the gas, L(z) the loss down to z in dB, there and back, r what gas reflects, f
/// what the lens of the probe does (from the impedances of `tissue::lens` and of the first medium), h = D - z, and k the curvatures of its surface, behind which sound diverges. Sound that gas
/// reflects returns to it by the same way, so its image is that of the line itself; `paths` follows it to where it goes.
/// @param found      what lies along the lines of the echoes
/// @param frequency  of the carrier, hertz
/// @throws usage_error  for layers of other lines, or a setting out of range
template <exec::policy Policy>
iq_lines add_gas_reverberation(const Policy& policy, iq_lines echoes, const line_layers& found, float frequency,
                               const gas_reverberation& settings = {}) {
    settings.check();
    if (found.lines != echoes.count)
        throw usage_error{detail::joined({"add_gas_reverberation: the layers have ", std::to_string(found.lines),
                                          " lines and the echoes ", std::to_string(echoes.count),
                                          "; give those that find_layers finds for their probe"})};
    if (std::none_of(found.media.begin(), found.media.end(), [](const medium& m) { return detail::is_gas(m); }))
        return echoes;
    constexpr float min_spread = 0.1F; // in front of a hollow surface sound has a focus, which is not sharp
    const float spacing = echoes.depth / static_cast<float>(std::max(echoes.samples, 1U));
    const auto rotation = [&](float depth) { // of the phase of an echo that is that much deeper
        const double cycles = 2 * double{frequency} / double{display_speed} * double{depth};
        const auto turn = static_cast<float>(cycles - std::floor(cycles)) * 2 * pi;
        return vec2{std::cos(turn), -std::sin(turn)};
    };
    const auto product = [](vec2 a, vec2 b) { return vec2{a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x}; };
    exec::for_each_block(policy, echoes.count, 8, 2e4F, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            detail::gas_surface gas{found(static_cast<std::uint32_t>(i)), found.media, frequency};
            if (gas.shown <= spacing || gas.shown >= echoes.depth) continue;
            vec2* const line = echoes.values.data() + i * echoes.samples;
            const auto samples = static_cast<std::int64_t>(echoes.samples),
                       surface = static_cast<std::int64_t>(std::lround(gas.shown / spacing)),
                       twice = static_cast<std::int64_t>(std::lround(2 * gas.shown / spacing)) - 1;
            const vec2 once_deeper = rotation(gas.shown), twice_deeper = rotation(2 * gas.shown);
            const float mirrored = settings.mirror * gas.reflected * gas.reflected,
                        repeated =
                            gas.reflected * gas.lens_reflected * settings.face * amplitude_of_decibels(-gas.loss_db);
            for (std::int64_t k = surface + 1; k < samples; ++k) {
                if (const std::int64_t from = twice - k; from >= 0 && from < surface) {
                    const float depth = (static_cast<float>(from) + 0.5F) * spacing;
                    const vec2 spread = max(vec2{1, 1} + 2 * (gas.shown - depth) * gas.curvature, vec2{min_spread});
                    const float level = mirrored * amplitude_of_decibels(2 * (gas.loss_to(depth) - gas.loss_db)) /
                                        std::sqrt(spread.x * spread.y);
                    line[k] += level * product(vec2{line[from].x, -line[from].y}, twice_deeper);
                }
                const std::int64_t from = k - surface;
                const bool is_above = from + 2 < surface; // the echo of the gas itself is divided between two samples
                line[k] += (is_above ? 2 : 1) * repeated * product(line[from], once_deeper);
            }
        }
    });
    return echoes;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
