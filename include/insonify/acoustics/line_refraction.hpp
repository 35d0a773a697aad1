#ifndef INSONIFY_ACOUSTICS_LINE_REFRACTION_HPP
#define INSONIFY_ACOUSTICS_LINE_REFRACTION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/fresnel.hpp>
#include <insonify/acoustics/layer.hpp>

/// Refraction along a straight line. The line itself stays straight, but the refracted ray is followed beside it: angles of
/// incidence and attenuation are those of the ray, exactly for plane surfaces. Depths are those of the straight line: behind
/// 10 mm of fat at 40 degrees they are 0.03 mm too large.
///
/// Where the ray returns to the sound speed that it had before a layer, it also returns to its direction there, as behind a
/// parallel layer. Behind a layer that is not parallel, such as a rib, other rays reach the line.
namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// How refraction changes a layer of a straight line.
struct refracted_layer {
    float cosine = 1;         ///< of the angle of incidence at its beginning
    float length_factor = 1;  ///< length of the ray over that of the line
    float enters_at = 0;      ///< where the ray enters it: metres of the ray from its beginning; below 0: before
    std::uint32_t before = 0; ///< medium of the layer before

    /// Length of the ray within the layer, down to a point of the line `along` metres below its beginning: 0 until the ray
    /// enters. Above its beginning (`along` < 0) it is extrapolated.
    INSONIFY_FN float length(float along) const {
        const float whole = length_factor * along;
        return max(whole - enters_at, min(whole, 0));
    }
};

/// The propagation direction behind an interface: by the law's own `refracted(direction, normal, before, after)` where it
/// has one, else by Snell's; {0, 0, 0} where it is totally reflected.
template <class Law>
INSONIFY_FN vec3 refracted_by(const Law& law, vec3 direction, vec3 normal, const medium& before, const medium& after) {
    if constexpr (requires { law.refracted(direction, normal, before, after); })
        return law.refracted(direction, normal, before, after);
    else
        return refracted(direction, normal, before, after);
}

/// Follows refraction from layer to layer of a line. Nothing is refracted where the model has no `refracted`.
template <class Model>
class line_refraction {
  public:
    INSONIFY_FN line_refraction(const Model& model, const traced_line& line) : model_{model}, line_{line} {}

    /// The next layer; called once for each, from the face on.
    INSONIFY_FN detail::refracted_layer next() {
        const std::size_t i = next_++;
        const layer& here = line_.layers[i];
        detail::refracted_layer found{.cosine = here.cosine, .before = line_.layers[i == 0 ? 0 : i - 1].medium};
        if constexpr (requires(const medium& m) { model_.refracted(vec3{}, vec3{}, m, m); }) {
            if (found.before != here.medium) cross(i, found);
            if (straight() && ahead_ == vec3{0, 0, 0}) return found;
            // Line and ray end on the plane of the surface that ends the layer; the last layer has none.
            const bool last = i + 1 == line_.layers.size();
            const vec3 end = last ? vec3{0, 0, 1} : normal_of(i + 1);
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
    INSONIFY_FN void cross(std::size_t i, detail::refracted_layer& found) {
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

    // Normal of the surface at the beginning of layer i, kept because the layer above and this one both use it. x: across the
    // line in the slice plane, y: out of it, z: along the line.
    INSONIFY_FN vec3 normal_of(std::size_t i) {
        if (i != normal_is_of_) {
            const vec2 slope = line_.layers[i].slope;
            normal_ = vec3{slope.x, slope.y, 1} / std::sqrt(dot(slope, slope) + 1);
            normal_is_of_ = i;
        }
        return normal_;
    }

    const Model& model_;
    const traced_line& line_;
    std::size_t next_ = 0;
    std::size_t normal_is_of_ = 0; // no surface begins the first layer
    vec3 normal_{0, 0, 1};
    vec3 direction_{0, 0, 1};        // of the ray, in the axes of `normal_of`
    vec3 ahead_{0, 0, 0};            // from the line to the ray, where both cross a surface
    float former_speed_ = -1;        // in the medium before the last surface
    vec3 former_direction_{0, 0, 1}; // of the ray there
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
