#ifndef INSONIFY_DOPPLER_TRACE_ENSEMBLE_HPP
#define INSONIFY_DOPPLER_TRACE_ENSEMBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/doppler/moving_scatterers.hpp>
#include <insonify/tracing/line_tracer.hpp>
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

namespace insonify::inline INSONIFY_ABI {

/// Received echoes of a pulse train: those of a pulse are the sum of what rests and of what moves.
struct ensemble_echoes {
    iq_lines resting{};             ///< the same for all pulses
    std::vector<iq_lines> moving{}; ///< for each pulse
};

namespace detail {

/// Distributes the echoes of one line over the pulses; for models it is an `echo_line`.
struct pulse_echoes {
    const line_task& task;
    view<vec2> out;               ///< `samples` of the resting echoes, then as many of each pulse
    std::size_t samples;          ///< along the line
    const std::uint32_t& current; ///< the pulse, or `moving_scatterers::all_pulses`
    bool has_surfaces;            ///< else the echoes of surfaces are dropped

    detail::compensated_echoes now() const {
        const std::size_t slot = current + 1U; // 0 for all pulses
        return task.echoes({out.data() + slot * samples, samples});
    }
    float depth() const { return now().depth(); }
    void surface(float at, float amplitude, vec2 slope) const {
        if (has_surfaces) now().surface(at, amplitude, slope);
    }
    void curved_surface(const curved_echo& one) const {
        if (has_surfaces) now().curved_surface(one);
    }
    template <class Value>
    void rough_surface(float at, float amplitude, vec2 slope, vec3 curvature, const Value& value) const {
        if (has_surfaces) now().rough_surface(at, amplitude, slope, curvature, value);
    }
    void scatterers(const scatterer_echoes& run) const { now().scatterers(run); }
};

/// Emits the echoes of one line for every pulse. Its layers are those of the first one: within a train, tissue moves by
/// much less than the length of a pulse.
/// @param samples  along the line
/// @param out      those of the resting echoes, then as many of each pulse; echoes are added
template <class Model, velocity_field Field>
void emit_ensemble(const line_task& task, const Model& model, view<const layer> layers, const Field& field,
                   const pulse_train& pulses, moving_surfaces& surfaces, std::size_t samples, view<vec2> out) {
    traced_line line = task.line;
    line.layers = layers;
    const bool surfaces_move = surfaces.assign(line, layers, field, pulses);
    using scatterers = moving_scatterers<std::remove_cvref_t<decltype(model.scattering)>, Field>;
    std::uint32_t current = scatterers::all_pulses;
    model
        .with_scattering(
            scatterers{model.scattering, &field, pulses, display_speed / line.frequency, pulses.from, &current})
        .emit(line, pulse_echoes{task, out, samples, current, !surfaces_move});
    if (!surfaces_move) return;
    const auto no_speckle = model.with_scattering(no_scatterers{});
    for (std::uint32_t k = 0; k < pulses.end(); ++k) {
        if (k >= pulses.first) {
            current = k - pulses.first;
            line.layers = surfaces.layers();
            no_speckle.emit(line, pulse_echoes{task, out, samples, current, true});
        }
        surfaces.advance(field, pulses, k);
    }
}

} // namespace detail

/// `trace_ensemble`, train after train: holds tables, layers and memory, so that it allocates only while buffers grow.
template <transducer Probe, acoustic_model Model = physical<>>
class ensemble_tracer {
  public:
    /// See `trace_ensemble`.
    /// @param out  receives the echoes; its memory is reused
    template <exec::policy Policy, velocity_field Field>
    void trace(const Policy& policy, const scene& body, const Probe& probe, const pose& at, const Model& model,
               const Field& field, const acquisition& scan, const pulse_train& pulses, ensemble_echoes& out) {
        const std::uint32_t samples = detail::check_acquisition(body, probe, at, model, scan);
        detail::frame_view<Probe> frame = plan_.view_of(policy, probe, at, model, scan, samples, body.media());
        pulse sent = nominal_pulse(probe);
        sent.burst = pulses.burst;
        frame.bandwidth = sent.bandwidth_at_peak();
        out.moving.resize(pulses.count);
        sinks_.assign(1, &out.resting);
        for (iq_lines& each : out.moving) sinks_.push_back(&each);
        for (iq_lines* const each : sinks_) each->reshape(probe.lines, samples, scan.depth);
        if (surfaces_.size() < detail::blocks_of(probe.lines)) surfaces_.resize(detail::blocks_of(probe.lines));
        constexpr float line_time = 1e6F;
        driver_.emit_lines(policy, body, frame, model, straight_lines{}, line_time, {sinks_.data(), sinks_.size()},
                           [&](std::size_t block, const line_task& task, view<const layer> layers, view<vec2> echoes) {
                               detail::emit_ensemble(task, model, layers, field, pulses, surfaces_[block], samples,
                                                     echoes);
                           });
    }

  private:
    detail::frame_plan<Probe, Model> plan_{};
    detail::line_driver<vec2> driver_{};
    std::vector<detail::moving_surfaces> surfaces_{}; // of each block of lines
    std::vector<iq_lines*> sinks_{};
};

/// What the probe receives of a pulse train while tissue and blood move as `field` says: the geometry is that of the scene for
/// all pulses.
///
/// @param model   `physical`, or another model with its members `scattering`, `with_scattering` and `emit`
/// @param pulses  their times
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
ensemble_echoes trace_ensemble(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                               const Model& model, const Field& field, const acquisition& scan,
                               const pulse_train& pulses) {
    ensemble_echoes echoes;
    ensemble_tracer<Probe, Model>{}.trace(detail::any_policy{policy}, body, probe, at, model, field, scan, pulses,
                                          echoes);
    return echoes;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
