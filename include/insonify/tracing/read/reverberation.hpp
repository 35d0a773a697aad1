#ifndef INSONIFY_TRACING_READ_REVERBERATION_HPP
#define INSONIFY_TRACING_READ_REVERBERATION_HPP

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
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Echoes that appear behind gas and bone, of sound that they reflect. Gas shows the mirror image of the tissue in
/// front of it, and the reverberation between gas and the face of the probe; bone is rough, and fills its shadow with
/// haze.
struct reverberation_settings {
    float mirror = 1;  ///< fraction of the amplitude of the mirror image that is drawn, 0 (none) to 1
    float face = 1;    ///< the same of the reverberation with the face
    float haze = 0.5F; ///< the same of the haze behind bone; of what is reflected, not all returns. Convention

    /// @throws usage_error  for a setting that is out of range
    void check() const {
        for (const float part : {mirror, face, haze})
            if (!(part >= 0 && part <= 1))
                throw usage_error{"reverberation: `mirror`, `face` and `haze` must be 0 (not drawn) to 1"};
    }

    friend bool operator==(const reverberation_settings&, const reverberation_settings&) = default;
};

namespace detail {

/// Size of the parts of tissue that rough bone reflects in phase, metres: speckle cells. Convention.
inline constexpr float haze_grain = 0.5e-3F;
/// Random bits of the cell of the unit lattice in which a point lies. Cells have their middle at 0: the slice plane of
/// a pose that is not turned lies on no border.
inline std::uint32_t bits_of_cell(vec3 point) {
    std::uint32_t bits = 0;
    for (int i = 0; i < 3; ++i) bits = mix_bits(bits + static_cast<std::uint32_t>(std::lround(point[i])));
    return bits;
}

/// Whether lines behind a medium have echoes of what it reflects.
INSONIFY_FN inline bool is_reflector(const medium& m) { return is_gas(m) || is_bone(m); }

/// Distance over which rough bone spreads each echo that it reflects, to either side, metres. Convention.
inline constexpr float haze_range = 5e-3F;
/// Distance from the bone at which sound that it reflects has spread to twice the width of the beam, metres.
/// Convention.
inline constexpr float haze_decay = 10e-3F;

/// The first surface of gas or bone on a line, and what sound loses on the way back from it. Models without `timing`,
/// `loss` or `pulse_loss` have those of `physical`.
template <class Model>
class reflecting_surface {
  public:
    reflecting_surface(view<const layer> layers, view<const medium> media, const traced_line& pulse, const Model& model)
        : layers_{layers}, media_{media}, pulse_{pulse}, model_{model} {
        for (; next_ < layers.size() && !is_reflector(medium_of(next_)); ++next_) {
            crossed_db_ += crossed_db(next_);
            shown_ += stretch();
            lost_db_ += lost_db();
        }
        if (next_ == 0 || next_ == layers.size()) return;
        below = &layers[next_];
        is_bone = detail::is_bone(medium_of(next_));
        shown = shown_;
        reflected = reflection(medium_of(next_ - 1), medium_of(next_));
        lens_reflected = reflection(medium_of(0), tissue::lens);
        lost_there_ = lost_db_;
        crossed_there_ = crossed_db_;
    }

    const layer* below = nullptr; ///< behind it; null: there is none, or the line starts in it
    bool is_bone = false;         ///< whether it is that of bone
    float shown = 0;              ///< its displayed depth, metres
    float reflected = 0;          ///< amplitude, by its surface
    float lens_reflected = 0;     ///< amplitude, of sound that returns to the face

    /// Attenuation in front of the surface, there and back, dB per displayed metre.
    float lost_db_per_metre() const { return loss_db(lost_there_) / max(shown, 1e-9F); }
    /// What an echo loses that goes there and back once more, dB.
    float once_more_db() const { return loss_db(2 * lost_there_) - loss_db(lost_there_) + crossed_there_; }
    /// The same from a displayed depth to the surface and back, twice, dB. From call to call less deep.
    float twice_from_db(float depth) {
        while (next_ > 0 && depth < shown_) {
            if (next_ < layers_.size() && !is_reflector(medium_of(next_))) crossed_db_ -= crossed_db(next_);
            --next_;
            shown_ -= stretch();
            lost_db_ -= lost_db();
        }
        const float lost = lost_db_ + max(depth - shown_, 0) * (lost_db() / max(stretch(), 1e-9F));
        return loss_db(2 * lost_there_ - lost) - loss_db(lost) + 2 * (crossed_there_ - crossed_db_);
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
    float lost_there_ = 0, crossed_there_ = 0;
};

/// Fractions of the amplitudes of echoes with which they contribute to the haze behind bone: bright surfaces, which
/// would show as dots, count little more than the tissue around them.
class haze_parts {
  public:
    /// @param echoes  of the line, up to the bone
    haze_parts(view<const vec2> echoes, float spacing) {
        block_ = std::max(static_cast<std::size_t>(block_length / spacing) + 1, echoes.size() / max_blocks + 1);
        const auto blocks = static_cast<int>((echoes.size() + block_ - 1) / block_),
                   around = static_cast<int>(haze_range / spacing / static_cast<float>(block_)) + 1;
        float root[max_blocks], power[max_blocks];
        for (int i = 0; i < blocks; ++i) {
            const std::size_t first = static_cast<std::size_t>(i) * block_,
                              last = std::min(first + block_, echoes.size());
            power[i] = 0;
            for (std::size_t k = first; k < last; ++k)
                power[i] += dot(echoes[k], echoes[k]) / static_cast<float>(last - first);
            root[i] = std::sqrt(std::sqrt(power[i]));
        }
        for (int i = 0; i < blocks; ++i) {
            const int first = std::max(i - around, 0), last = std::min(i + around + 1, blocks);
            float mean = 0; // of the fourth roots, which a few bright surfaces hardly change
            for (int k = first; k < last; ++k) mean += root[k] / static_cast<float>(last - first);
            const float largest = max_ratio * mean * mean * mean * mean;
            part_[i] = power[i] > largest ? std::sqrt(largest / power[i]) : 1.0F;
        }
    }

    float operator()(std::int64_t k) const { return part_[static_cast<std::size_t>(k) / block_]; }

  private:
    static constexpr std::size_t max_blocks = 256;
    static constexpr float block_length = 0.5e-3F; // metres: about a pulse
    static constexpr float max_ratio = 3;          // of the power of a block to that of the tissue around. Convention

    std::size_t block_ = 1; // samples
    float part_[max_blocks]{};
};

} // namespace detail

/// Adds the echoes that appear behind gas and bone to traced echoes: straight lines end at their surfaces. Call it
/// between `trace` and `convolve`.
///
///     gas, at 2 D - z:   mirror r^2 10^(-A(z) / 20) / sqrt(|1 + 2 h k_x| |1 + 2 h k_y|) of the conjugate echo at z < D
///          at D + z:     face n r f c 10^(-B / 20) of the echo at z, n = 2 for z < D, else 1
///     bone, at 2 D - z:  haze r^2 10^(-A(z) / 20) / (sqrt((1 + 2 h k_x) (1 + 2 h k_y)) (1 + h / 10 mm)), k >= 0
///
/// with D the displayed depth of the first such surface, A(z) what sound loses from z to it and back, twice, and B from
/// the face to it and back (attenuation of the pulse and interfaces, dB), r what it reflects, f what the lens of the
/// probe does (from the impedances of `tissue::lens` and of the first medium), h = D - z, k the curvatures of the
/// surface, behind which sound diverges, and c the part of the amplitude that returns to the aperture: by the law of
/// specular echoes, for the slope of the surface and the angle of the line to the face. The image is that of the line
/// itself; `paths` follows the sound to where it goes. Bone is taken as rough, whatever its `roughness`: it divides
/// each echo among random places within 5 mm, which belong to its own place in the world, so that no image is seen.
/// @param found  what lies along the lines of the probe
/// @throws usage_error  for lines that are not those of the probe, or a setting out of range
template <exec::policy Policy, transducer Probe, class Model>
iq_lines add_reverberation(const Policy& policy, iq_lines echoes, const line_layers& found, const Probe& probe,
                           const Model& model, const reverberation_settings& settings = {}) {
    settings.check();
    probe.check();
    detail::check_layers(found, probe.lines, "add_reverberation");
    detail::check_echoes(echoes, probe.lines, "add_reverberation");
    if (std::none_of(found.media.begin(), found.media.end(), detail::is_reflector)) return echoes;
    constexpr float min_spread = 0.5F; // in the focus of a hollow surface, which is not sharp: as `paths`
    const detail::stated_settings stated{probe};
    const traced_line pulse{.frequency = stated.frequency, .bandwidth = stated.bandwidth};
    const float spacing = echoes.depth / static_cast<float>(echoes.samples);
    const auto rotation = [&](float depth) { // of the phase of an echo that is that much deeper
        const vec2 forwards = detail::turned(2 * double{stated.frequency} / double{display_speed} * double{depth});
        return vec2{forwards.x, -forwards.y};
    };
    exec::for_each_in_blocks(policy, echoes.count, 8, 2e4F, [&](std::size_t i) {
        detail::reflecting_surface<Model> surface{found(static_cast<std::uint32_t>(i)), found.media, pulse, model};
        if (surface.below == nullptr || surface.shown <= spacing || surface.shown >= echoes.depth) return;
        vec2 curvature{surface.below->curvature.x, surface.below->curvature.y};
        if (surface.is_bone) curvature = max(curvature, vec2{0}); // what is rough has no focus
        vec2* const line = echoes.values.data() + i * echoes.samples;
        const auto samples = static_cast<std::int64_t>(echoes.samples),
                   middle = static_cast<std::int64_t>(std::lround(surface.shown / spacing)),
                   twice = static_cast<std::int64_t>(std::lround(2 * surface.shown / spacing)) - 1;
        // The echo of the surface itself is divided between two samples; that of bone reaches half a millimetre.
        const std::int64_t own = 2 + (surface.is_bone ? static_cast<std::int64_t>(0.5e-3F / spacing) : 0),
                           above = std::max(middle - own, std::int64_t{0});
        const vec2 twice_deeper = rotation(2 * surface.shown);
        // Calls add(from, k, echo) for each echo in front of the surface, from it on, and its image at k.
        const auto for_each_image = [&](float part, const auto& add) {
            for (std::int64_t from = above - 1; from >= 0; --from) {
                const float depth = (static_cast<float>(from) + 0.5F) * spacing;
                const vec2 spread = max(abs(vec2{1, 1} + 2 * (surface.shown - depth) * curvature), vec2{min_spread});
                const float level = part * surface.reflected * surface.reflected *
                                    amplitude_of_decibels(-surface.twice_from_db(depth)) /
                                    std::sqrt(spread.x * spread.y);
                add(from, twice - from,
                    level * detail::complex_product(vec2{line[from].x, -line[from].y}, twice_deeper));
            }
        };
        if (surface.is_bone) {
            // Each grain goes to `copies` of `places`, which are as much attenuated as what is there.
            constexpr std::uint32_t copies = 4, places = 64;
            std::int64_t steps[places];
            float weights[places];
            for (std::uint32_t j = 0; j < places; ++j) {
                const float apart = (2 * static_cast<float>(j) / (places - 1) - 1) * detail::haze_range;
                steps[j] = static_cast<std::int64_t>(std::lround(apart / spacing));
                weights[j] = amplitude_of_decibels(-surface.lost_db_per_metre() * apart) / std::sqrt(float{copies});
            }
            const line_frame& frame = found.frame(static_cast<std::uint32_t>(i));
            const detail::haze_parts parts{{line, static_cast<std::size_t>(above)}, spacing};
            for_each_image(settings.haze, [&](std::int64_t from, std::int64_t mirrored, vec2 echo) {
                const float depth = (static_cast<float>(from) + 0.5F) * spacing;
                echo *= parts(from) / (1 + (surface.shown - depth) / detail::haze_decay);
                std::uint32_t random = detail::bits_of_cell(frame.at(depth) / detail::haze_grain);
                for (std::uint32_t j = 0; j < copies; ++j, random >>= 7) {
                    const std::uint32_t place = random & 63U;
                    const std::int64_t k = mirrored + steps[place], behind = k > middle ? k : 2 * middle + 1 - k;
                    if (behind < samples)
                        line[behind] += ((random & 64U) != 0 ? weights[place] : -weights[place]) * echo;
                }
            });
            return;
        }
        for_each_image(settings.mirror, [&](std::int64_t, std::int64_t k, vec2 echo) {
            if (k < samples) line[k] += echo;
        });
        const vec2 once_deeper = rotation(surface.shown);
        const float wavelengths = surface.shown * stated.frequency / display_speed;
        const auto number = static_cast<float>(i);
        const vec3 face = probe.beam(number + 0.5F).origin - probe.beam(number - 0.5F).origin;
        const float width = length(face); // 0: lines from one point of a plane face
        const vec3 along = probe.beam(number).direction;
        const float sine = width > 0 ? dot(along, face) / width : along.x; // of the angle to the normal of the face
        const float tilt = length(vec2{surface.below->slope.x, sine});
        const float returned =
            specular_return{}(std::atan(tilt), stated.fnumber, wavelengths) *
            specular_return{}(std::atan(surface.below->slope.y), surface.shown / stated.elevation_height, wavelengths);
        const float repeated = settings.face * surface.reflected * surface.lens_reflected * returned *
                               amplitude_of_decibels(-surface.once_more_db());
        for (std::int64_t k = middle + 1; k < samples; ++k) {
            const std::int64_t from = k - middle;
            line[k] += (from < above ? 2 : 1) * repeated * detail::complex_product(line[from], once_deeper);
        }
    });
    return echoes;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
