#ifndef INSONIFY_TRACING_READ_GAS_REVERBERATION_HPP
#define INSONIFY_TRACING_READ_GAS_REVERBERATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <cmath>
#include <cstdint>

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

/// The first surface of gas on a line, and what sound loses on the way back from it. Models without `timing`, `loss` or
/// `pulse_loss` have those of `physical`.
template <class Model>
class gas_surface {
  public:
    gas_surface(view<const layer> layers, view<const medium> media, const traced_line& pulse, const Model& model)
        : layers_{layers}, media_{media}, pulse_{pulse}, model_{model} {
        for (; next_ < layers.size() && !is_gas(medium_of(next_)); ++next_) {
            crossed_db_ += crossed_db(next_);
            shown_ += stretch();
            lost_db_ += lost_db();
        }
        if (next_ == 0 || next_ == layers.size()) return;
        below = &layers[next_];
        shown = shown_;
        reflected = reflection(medium_of(next_ - 1), medium_of(next_));
        lens_reflected = reflection(medium_of(0), tissue::lens);
        lost_at_gas_ = lost_db_;
        crossed_at_gas_ = crossed_db_;
    }

    const layer* below = nullptr; ///< the layer of gas; null: there is none, or the line starts in it
    float shown = 0;              ///< its displayed depth, metres
    float reflected = 0;          ///< amplitude, by its surface
    float lens_reflected = 0;     ///< amplitude, of sound that returns to the face

    /// What an echo loses that goes to the gas and back once more, dB.
    float once_more_db() const { return loss_db(2 * lost_at_gas_) - loss_db(lost_at_gas_) + crossed_at_gas_; }
    /// The same from a displayed depth to the gas and back, twice, dB. From call to call less deep.
    float twice_from_db(float depth) {
        while (next_ > 0 && depth < shown_) {
            if (next_ < layers_.size() && !is_gas(medium_of(next_))) crossed_db_ -= crossed_db(next_);
            --next_;
            shown_ -= stretch();
            lost_db_ -= lost_db();
        }
        const float lost = lost_db_ + max(depth - shown_, 0) * (lost_db() / max(stretch(), 1e-9F));
        return loss_db(2 * lost_at_gas_ - lost) - loss_db(lost) + 2 * (crossed_at_gas_ - crossed_db_);
    }

  private:
    const medium& medium_of(std::size_t i) const { return media_[layers_[i].medium]; }
    // What an echo loses at the surface in front of a layer, there and back.
    float crossed_db(std::size_t i) const {
        if (i == 0 || layers_[i].medium == layers_[i - 1].medium) return 0;
        const float r = reflection(medium_of(i - 1), medium_of(i));
        return -20 * std::log10(max(1 - r * r, 1e-6F));
    }
    // Displayed length and attenuation, there and back, of the layer `next_`.
    float length() const { return layers_[next_].end - layers_[next_].begin; }
    float stretch() const {
        if constexpr (requires { model_.timing; })
            return length() * detail::displayed_stretch(model_.timing, medium_of(next_));
        else
            return length() * insonify::displayed_stretch(medium_of(next_));
    }
    float lost_db() const {
        const medium& m = medium_of(next_);
        if constexpr (requires { model_.loss(m, pulse_.frequency); })
            return length() * model_.loss(m, pulse_.frequency);
        else
            return length() * echo_loss(m, pulse_.frequency);
    }
    // Of the peak of the pulse, where its carrier loses `carrier_db`.
    float loss_db(float carrier_db) const { return pulse_loss(model_, pulse_, carrier_db); }

    view<const layer> layers_;
    view<const medium> media_;
    const traced_line& pulse_;
    const Model& model_;
    std::size_t next_ = 0; // the layer that begins at `shown_`
    float shown_ = 0, lost_db_ = 0, crossed_db_ = 0;
    float lost_at_gas_ = 0, crossed_at_gas_ = 0;
};

} // namespace detail

/// Adds the echoes that appear behind gas to traced echoes: straight lines end at its surface. Call it between `trace`
/// and `convolve`.
///
///     at 2 D - z:  r^2 10^(-A(z) / 20) / sqrt(|1 + 2 h k_x| |1 + 2 h k_y|) of the conjugate echo at z < D
///     at D + z:    n r f c 10^(-B / 20) of the echo at z, n = 2 for z < D, else 1
///
/// with D the displayed depth of the gas, A(z) what sound loses from z to the gas and back, twice, and B from the face
/// to the gas and back (attenuation of the pulse and interfaces, dB), r what gas reflects, f what the lens of the probe
/// does (from the impedances of `tissue::lens` and of the first medium), h = D - z, k the curvatures of the surface,
/// behind which sound diverges, and c the part of the amplitude that returns to the aperture: by the law of specular
/// echoes, for the slope of the surface and the angle of the line to the face. The image is that of the line itself;
/// `paths` follows the sound to where it goes.
/// @param found  what lies along the lines of the probe
/// @throws usage_error  for lines that are not those of the probe, or a setting out of range
template <exec::policy Policy, transducer Probe, class Model>
iq_lines add_gas_reverberation(const Policy& policy, iq_lines echoes, const line_layers& found, const Probe& probe,
                               const Model& model, const gas_reverberation& settings = {}) {
    settings.check();
    probe.check();
    detail::check_layers(found, probe.lines, "add_gas_reverberation");
    detail::check_echoes(echoes, probe.lines, "add_gas_reverberation");
    if (!detail::has_gas(found.media)) return echoes;
    constexpr float min_spread = 0.5F; // in the focus of a hollow surface, which is not sharp: as `paths`
    const detail::stated_settings stated{probe};
    const traced_line pulse{.frequency = stated.frequency, .bandwidth = stated.bandwidth};
    const float spacing = echoes.depth / static_cast<float>(echoes.samples);
    const auto rotation = [&](float depth) { // of the phase of an echo that is that much deeper
        const vec2 forwards = detail::turned(2 * double{stated.frequency} / double{display_speed} * double{depth});
        return vec2{forwards.x, -forwards.y};
    };
    exec::for_each_in_blocks(policy, echoes.count, 8, 2e4F, [&](std::size_t i) {
        detail::gas_surface<Model> gas{found(static_cast<std::uint32_t>(i)), found.media, pulse, model};
        if (gas.below == nullptr || gas.shown <= spacing || gas.shown >= echoes.depth) return;
        const vec2 curvature{gas.below->curvature.x, gas.below->curvature.y};
        vec2* const line = echoes.values.data() + i * echoes.samples;
        const auto samples = static_cast<std::int64_t>(echoes.samples),
                   surface = static_cast<std::int64_t>(std::lround(gas.shown / spacing)),
                   twice = static_cast<std::int64_t>(std::lround(2 * gas.shown / spacing)) - 1;
        const std::int64_t above = surface - 2; // the echo of the gas itself is divided between two samples
        const vec2 once_deeper = rotation(gas.shown), twice_deeper = rotation(2 * gas.shown);
        const float wavelengths = gas.shown * stated.frequency / display_speed;
        const auto number = static_cast<float>(i);
        const vec3 face = probe.beam(number + 0.5F).origin - probe.beam(number - 0.5F).origin;
        const float width = length(face); // 0: lines from one point of a plane face
        const vec3 along = probe.beam(number).direction;
        const float sine = width > 0 ? dot(along, face) / width : along.x; // of the angle to the normal of the face
        const float tilt = length(vec2{gas.below->slope.x, sine});
        const float returned =
            specular_return{}(std::atan(tilt), stated.fnumber, wavelengths) *
            specular_return{}(std::atan(gas.below->slope.y), gas.shown / stated.elevation_height, wavelengths);
        const float mirrored = settings.mirror * gas.reflected * gas.reflected,
                    repeated = settings.face * gas.reflected * gas.lens_reflected * returned *
                               amplitude_of_decibels(-gas.once_more_db());
        for (std::int64_t k = surface + 1; k < samples; ++k) {
            if (const std::int64_t from = twice - k; from >= 0 && from < above) {
                const float depth = (static_cast<float>(from) + 0.5F) * spacing;
                const vec2 spread = max(abs(vec2{1, 1} + 2 * (gas.shown - depth) * curvature), vec2{min_spread});
                const float level =
                    mirrored * amplitude_of_decibels(-gas.twice_from_db(depth)) / std::sqrt(spread.x * spread.y);
                line[k] += level * detail::complex_product(vec2{line[from].x, -line[from].y}, twice_deeper);
            }
            const std::int64_t from = k - surface;
            line[k] += (from < above ? 2 : 1) * repeated * detail::complex_product(line[from], once_deeper);
        }
    });
    return echoes;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
