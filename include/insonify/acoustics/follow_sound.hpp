#ifndef INSONIFY_ACOUSTICS_FOLLOW_SOUND_HPP
#define INSONIFY_ACOUSTICS_FOLLOW_SOUND_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/core/units.hpp>
#include <cmath>
#include <cstddef>

/// Sound along a line, from layer to layer: its direction, its travel time and what is left of it.
namespace insonify::inline INSONIFY_ABI {

/// Depth at which an echo is displayed: by its travel time through the media, or as if all had `display_speed`.
enum class timing { sound_speed, uniform };

/// Angle of incidence on surfaces: the actual one, or normal incidence throughout.
enum class angle { oblique, normal };

/// Bandwidth of the pulse under attenuation: a single frequency, as of a long burst, or the spectrum of the pulse,
/// which loses less (`attenuated`). The downshift of its centre is neglected.
enum class pulse_bandwidth { narrow, broad };

namespace detail {

/// How refraction changes a layer of a straight line.
struct refracted_layer {
    float cosine = 1;         ///< of the angle of incidence at its beginning
    float length_factor = 1;  ///< length of the ray over that of the line
    float enters_at = 0;      ///< where the ray enters it: metres of the ray from its beginning; below 0: before
    std::uint32_t before = 0; ///< medium of the layer before

    /// Length of the ray within the layer, down to a point of the line `along` metres below its beginning: 0 until the
    /// ray enters. Above its beginning (`along` < 0) it is extrapolated.
    INSONIFY_FN float length(float along) const {
        const float whole = length_factor * along;
        return max(whole - enters_at, min(whole, 0));
    }
};

/// Follows refraction from layer to layer of a line. Nothing is refracted where the model has no `refracted`.
///
/// The line stays straight, and the refracted ray is followed beside it: angles of incidence and attenuation are those
/// of the ray, exactly for plane surfaces. Depths are those of the line: behind 10 mm of fat at 40 degrees they are
/// 0.03 mm too large. Where the ray returns to the sound speed before a layer, it returns to its direction there.
template <class Model>
class line_refraction {
  public:
    INSONIFY_FN line_refraction(const Model& model, const traced_line& line) : model_{model}, line_{line} {}

    /// The next layer; called once for each, from the face on.
    INSONIFY_FN refracted_layer next() {
        const std::size_t i = next_++;
        const layer& here = line_.layers[i];
        refracted_layer found{.cosine = here.cosine, .before = line_.layers[i == 0 ? 0 : i - 1].medium};
        if constexpr (requires(const medium& m) { model_.refracted(vec3{}, vec3{}, m, m); }) {
            if (found.before != here.medium) cross(i, found);
            if (straight() && ahead_ == vec3{0, 0, 0}) return found;
            // Line and ray end on the plane of the surface that ends the layer; the last layer has none.
            const vec3 end = i + 1 == line_.layers.size() ? vec3{0, 0, 1} : normal_of(i + 1);
            const float towards = max(dot(end, direction_), 1e-3F), length = here.end - here.begin;
            found.length_factor = clamp(end.z / towards, 0.25F, 4);
            // Where ray and line end on a surface that the ray grazes, it is not plane as far as they are apart.
            const float bound = min(3 * std::sqrt(dot(ahead_, ahead_)), max_entry);
            found.enters_at = clamp(dot(end, ahead_) / towards, -bound, bound);
            ahead_ = ahead_ + found.length(length) * direction_ - vec3{0, 0, length};
        }
        return found;
    }

  private:
    static constexpr float max_entry = 0.02F; // metres: surfaces are not plane as far as that

    INSONIFY_FN bool straight() const { return direction_.x == 0 && direction_.y == 0; }

    // The ray crosses the surface at the beginning of a layer.
    INSONIFY_FN void cross(std::size_t i, refracted_layer& found) {
        const medium &before = line_.media[found.before], &after = line_.media[line_.layers[i].medium];
        const vec3 normal = normal_of(i), arriving = direction_;
        if (!straight()) found.cosine = min(std::fabs(dot(normal, arriving)), 1);
        const vec3 bent = model_.refracted(arriving, normal, before, after);
        if (after.sound_speed == former_speed_)
            direction_ = former_direction_;
        else if (bent != vec3{0, 0, 0} && is_finite(bent)) // else it is totally reflected
            direction_ = bent;
        former_speed_ = before.sound_speed;
        former_direction_ = arriving;
    }

    // Normal of the surface at the beginning of layer i. x: across the line in the slice plane, y: out of it, z: along
    // the line.
    INSONIFY_FN vec3 normal_of(std::size_t i) const {
        const vec2 slope = line_.layers[i].slope;
        return vec3{slope.x, slope.y, 1} / std::sqrt(dot(slope, slope) + 1);
    }

    const Model& model_;
    const traced_line& line_;
    std::size_t next_ = 0;
    vec3 direction_{0, 0, 1};        // of the ray, in the axes of `normal_of`
    vec3 ahead_{0, 0, 0};            // from the line to the ray, where both cross a surface
    float former_speed_ = -1;        // in the medium before the last surface
    vec3 former_direction_{0, 0, 1}; // of the ray there
};

} // namespace detail

/// State of the wave at a point of its path.
struct echo_path {
    float shown = 0;                      ///< displayed depth, metres
    float loss_db = 0;                    ///< attenuation so far, there and back, dB
    float passed = 1;                     ///< factor on amplitude of the interfaces so far, there and back
    float tissue_loss_db = 0;             ///< attenuation so far by soft tissue alone, see `tissue_lost_at`, dB
    float tissue_per_metre = 0;           ///< of the soft tissue of the present layer, or of the last one, dB/m
    detail::refracted_layer refraction{}; ///< of the present layer
    detail::layer_gains gains{};          ///< of the present layer

    /// Attenuation there and back, down to a point of the line, dB.
    /// @param along      metres below the beginning of the present layer
    /// @param per_metre  attenuation of its medium, there and back, dB/m
    INSONIFY_FN float lost_at(float along, float per_metre) const {
        return loss_db + per_metre * refraction.length(along);
    }
    /// The same with bone, gas and other obstacles replaced by the soft tissue before them.
    INSONIFY_FN float tissue_lost_at(float along) const {
        return tissue_loss_db + tissue_per_metre * refraction.length(along);
    }
};

namespace detail {

/// Displayed depth per metre of a medium.
INSONIFY_FN inline float displayed_stretch(timing how, const medium& m) {
    return how == timing::sound_speed ? insonify::displayed_stretch(m) : 1.0F;
}

/// The loss at the peak of the pulse of a line by a model, dB; that of the carrier for models that state no other.
/// @param loss_db  that of the carrier
template <class Model>
INSONIFY_FN float pulse_loss(const Model& model, const traced_line& line, float loss_db) {
    if constexpr (requires { model.pulse_loss(line, loss_db); })
        return model.pulse_loss(line, loss_db);
    else
        return loss_db;
}

/// Sound passes through a layer to its end.
template <class Model>
INSONIFY_FN void pass(const Model& model, const traced_line& line, const layer& here, echo_path& path) {
    const medium& m = line.media[here.medium];
    path.shown += (here.end - here.begin) * displayed_stretch(model.timing, m);
    path.loss_db = path.lost_at(here.end - here.begin, model.attenuation(m, line.frequency));
    path.tissue_loss_db = path.tissue_lost_at(here.end - here.begin);
}

/// The fraction of the power of a strip of the beam that passes beside a layer which is narrow out of the slice plane,
/// such as a needle, a wire or a small ball; 0 where it is wide, as bone and plates are.
///
/// The layer's section out of the slice plane is the ellipse that has, at the line, its thickness T and the first and
/// second derivatives T' and T'' of that by the height y, which follow from slope and curvature of the two surfaces.
/// T(y)^2 is then a polynomial of degree two, and its zeros are the sides of the section:
///
///     y = T (T' +- sqrt(-T T'')) / -(T'^2 + T T'')
///
/// Of a strip with the power exp(-y^2 / s^2), what lies outside them passes; nothing beside facets, which do not curve.
/// @param obstacle  a layer between two surfaces that are the object's own
/// @param behind    the next one
/// @param strip     s, metres
INSONIFY_FN inline float power_beside(const layer& obstacle, const layer& behind, float strip) {
    const float thickness = obstacle.end - obstacle.begin;
    const float first = obstacle.slope.y - behind.slope.y; // a slope is the negative derivative of the depth
    const float bend = thickness * (obstacle.curvature.y - behind.curvature.y), open = bend - first * first;
    if (!(strip > 0) || !(open > 0)) return 0;
    const float root = std::sqrt(bend), per_strip = thickness / (open * strip);
    return 0.5F * (std::erfc((root + first) * per_strip) + std::erfc((root - first) * per_strip));
}

/// Adds the sound that passes beside a narrow obstacle in the strip of the beam that the line stands for to what passes
/// through it: by power, and at the mean time. What lets half of the amplitude through is no obstacle.
/// @param above  in front of the obstacle
/// @param below  behind it
/// @return       whether any was added
template <class Model>
INSONIFY_FN bool add_sound_beside(const Model& model, const traced_line& line, const layer& obstacle,
                                  const layer& behind, const echo_path& above, echo_path& below) {
    if (!(obstacle.own_begin.cosine > 0) || !(obstacle.own_end.cosine > 0) || above.passed == 0) return false;
    layer tissue = obstacle; // beside it
    tissue.medium = behind.medium;
    echo_path around = above; // straight on
    around.refraction.enters_at = 0;
    pass(model, line, tissue, around);
    const float louder_db = pulse_loss(model, line, around.loss_db) - pulse_loss(model, line, below.loss_db);
    const float through = below.passed / above.passed * amplitude_of_decibels(min(louder_db, 300));
    if (!(through < 0.5F)) return false;
    const float beside = power_beside(obstacle, behind, line.aperture.strip(0.5F * (above.shown + around.shown)));
    if (beside == 0) return false;
    const float power = (1 - beside) * through * through + beside;
    below.shown += beside / power * (around.shown - below.shown);
    below.loss_db = around.loss_db;
    below.refraction.enters_at = 0; // what passes beside it arrives straight
    below.passed = above.passed * std::sqrt(power);
    return true;
}

/// Follows sound along a line from layer to layer: for the echoes that a model emits, and for what arrives at each
/// depth.
/// @param at_surface  at_surface(i, here, path): the transmission into layer i, there and back; called where it is of
///                    another medium than the layer above, at whose end `path` lies
/// @param in_layer    in_layer(i, here, path): called at the beginning of each layer; false ends the walk
template <class Model, class AtSurface, class InLayer>
INSONIFY_FN void follow_sound(const Model& model, const traced_line& line, const AtSurface& at_surface,
                              const InLayer& in_layer) {
    echo_path path{}, above{}; // at the end of the layer before, and of the one before that
    line_refraction<Model> refraction{model, line};
    for (std::size_t i = 0; i < line.layers.size(); ++i) {
        layer here = line.layers[i];
        echo_path entered = path;
        entered.refraction = refraction.next();
        entered.gains = path.gains.next(line.gains, here, line.media[here.medium]);
        if (here.medium != entered.refraction.before) {
            here.cosine = entered.refraction.cosine;
            entered.passed *= at_surface(i, here, path);
            if (add_sound_beside(model, line, line.layers[i - 1], here, above, entered) &&
                entered.gains.at_steps.empty())
                entered.gains.before = {}; // the gains within an obstacle do not hold for what passes beside it
        }
        if (const medium& m = line.media[here.medium]; !blocks_sound(m) && m.attenuation < max_loss_of_tissue)
            entered.tissue_per_metre = model.attenuation(m, line.frequency);
        above = path;
        path = entered;
        if (!in_layer(i, here, path)) return;
        pass(model, line, here, path);
    }
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
