#ifndef INSONIFY_DOPPLER_MOVING_SURFACES_HPP
#define INSONIFY_DOPPLER_MOVING_SURFACES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/doppler/moving_scatterers.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The surfaces of one line, which move with the tissue beside them. Flowing media do not move their walls.
///
/// A plane surface that moves with the velocity v is met at a distance that changes by v . n / (a . n), where n is its
/// normal and a the direction of the line.
class moving_surfaces {
  public:
    /// @param layers  of the line at the first pulse
    /// @return        whether any surface moves
    template <velocity_field Field>
    bool assign(const traced_line& line, view<const layer> layers, const Field& field, const pulse_train& pulses) {
        now_.assign(layers.begin(), layers.end());
        motions_.clear();
        bool any = false;
        for (std::size_t i = 1; i < layers.size(); ++i) {
            const layer &above = layers[i - 1], &below = layers[i];
            const bool flows_above = line.media[above.medium].flowing, flows_below = line.media[below.medium].flowing;
            motion of_surface{};
            if (!(flows_above && flows_below)) {
                // Of two tissues, the one whose surface it is.
                const layer& tissue = flows_above || (!flows_below && below.own_surfaces.x > 0) ? below : above;
                const pose place = line.places.empty() ? pose{} : line.places[tissue.place];
                const vec3 across = cross(line.frame.elevation, line.frame.along);
                constexpr float steepest = 5.8F; // 80 degrees
                const vec3 normal = line.frame.along + clamp(below.slope.x, -steepest, steepest) * across +
                                    clamp(below.slope.y, -steepest, steepest) * line.frame.elevation;
                of_surface = {tissue.object, place.local_point(line.frame.at(below.begin)),
                              place.local_direction(normal), below.begin, 0};
                if (const displacement_view* deformed = line.displacement(tissue.place)) {
                    of_surface.normal = transpose(inverse(deformed->gradient(of_surface.point))) * of_surface.normal;
                    of_surface.point = deformed->rest(of_surface.point);
                }
            }
            motions_.push_back(of_surface);
            for (std::uint32_t k = 0; k < pulses.end() && !any; ++k) any = of_surface.speed(field, pulses.time(k)) != 0;
        }
        return any;
    }

    /// The layers of the present pulse.
    view<const layer> layers() const { return {now_.data(), now_.size()}; }

    /// Goes on to the pulse after `pulse`.
    template <velocity_field Field>
    void advance(const Field& field, const pulse_train& pulses, std::uint32_t pulse) {
        const float time = pulses.time(pulse) + 0.5F * pulses.interval;
        for (std::size_t i = 0; i < motions_.size(); ++i) {
            motion& of_surface = motions_[i];
            of_surface.moved += static_cast<double>(pulses.interval * of_surface.speed(field, time));
            const auto distance = static_cast<float>(static_cast<double>(of_surface.distance) + of_surface.moved);
            // Surfaces do not overtake each other.
            now_[i + 1].begin = now_[i].end = max(now_[i].begin, min(distance, now_[i + 1].end));
        }
    }

  private:
    struct motion {
        std::uint32_t object = ~0U; ///< with which it moves
        vec3 point{0, 0, 0};        ///< where it was at rest, in coordinates of the object
        vec3 normal{0, 0, 0};       ///< over its component along the line, for velocities at rest; 0: does not move
        float distance = 0;         ///< along the line, at pulse 0
        double moved = 0;           ///< since then; a float would lose the phase

        template <velocity_field Field>
        float speed(const Field& field, float time) const {
            return normal == vec3{0, 0, 0} ? 0.0F : dot(field(object_id{object}, point, time), normal);
        }
    };

    std::vector<layer> now_{};
    std::vector<motion> motions_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
