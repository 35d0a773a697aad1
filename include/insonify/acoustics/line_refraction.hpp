#ifndef INSONIFY_ACOUSTICS_LINE_REFRACTION_HPP
#define INSONIFY_ACOUSTICS_LINE_REFRACTION_HPP

#include <insonify/acoustics/fresnel.hpp>
#include <insonify/acoustics/layer.hpp>

/// Refraction along a straight line. The line itself never bends, but the direction that refraction would give the sound
/// is carried along it: angles of incidence and attenuation follow from that direction, exactly so for parallel layers.
/// Depths stay those of the straight line: behind 10 mm of fat at 40 degrees they are 0.03 mm too large. Where sound has
/// the speed again with which it left the probe, its direction is that of the line again, as behind a parallel layer;
/// behind a rib, say, other rays than the one that was bent away reach the line.
namespace insonify::inline INSONIFY_ABI {

/// How refraction changes a layer of a straight line.
struct refracted_layer {
    float cosine = 1;         ///< of the angle of incidence at its beginning
    float length_factor = 1;  ///< length of the path over that of the line
    float spared = 0;         ///< length of path that is saved in the layer before, over that of the line in this one
    std::uint32_t before = 0; ///< medium of the layer before

    /// Attenuation per metre of the line. @param in_this, in_before  per metre of path in this medium and in the one before
    INSONIFY_FN float loss(float in_this, float in_before) const {
        const float saved = spared * in_before;
        return spared == 0 ? length_factor * in_this : max(length_factor * in_this - saved, 0);
    }
};

namespace detail {

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
    INSONIFY_FN refracted_layer next() {
        const std::size_t i = next_++;
        const layer& here = line_.layers[i];
        refracted_layer found{.cosine = here.cosine, .before = line_.layers[i == 0 ? 0 : i - 1].medium};
        if constexpr (requires(const medium& m) { model_.refracted(vec3{}, vec3{}, m, m); }) {
            if (found.before != here.medium) {
                const vec3 normal = normal_of(here);
                if (!straight()) found.cosine = min(std::fabs(dot(normal, direction_)), 1);
                const vec3 bent =
                    model_.refracted(direction_, normal, line_.media[found.before], line_.media[here.medium]);
                if (bent != vec3{0, 0, 0} && is_finite(bent)) direction_ = bent; // else no sound goes on
                const medium& first = line_.media[line_.layers[0].medium];
                if (line_.media[here.medium].sound_speed == first.sound_speed) direction_ = {0, 0, 1};
            }
            if (straight() || i + 1 == line_.layers.size()) return found;
            // Path and line end on the plane of the surface that ends the layer.
            const vec3 end = normal_of(line_.layers[i + 1]);
            found.length_factor = clamp(end.z / max(dot(end, direction_), 1e-3F), 0.25F, 4);
            found.spared = found.length_factor * max(direction_.z, 0) - 1;
        }
        return found;
    }

  private:
    INSONIFY_FN bool straight() const { return direction_.x == 0 && direction_.y == 0; }

    // Of the surface at the beginning of a layer: x in the slice plane across the line, y out of the slice, z along it.
    INSONIFY_FN static vec3 normal_of(const layer& below) {
        const vec3 normal{std::tan(below.tilt.x), std::tan(below.tilt.y), 1};
        return normal / length(normal);
    }

    const Model& model_;
    const traced_line& line_;
    std::size_t next_ = 0;
    vec3 direction_{0, 0, 1}; // in the same axes
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI
#endif
