#ifndef INSONIFY_DOPPLER_TRACE_ENSEMBLE_HPP
#define INSONIFY_DOPPLER_TRACE_ENSEMBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/moving_scatterers.hpp>
#include <insonify/doppler/moving_surfaces.hpp>
#include <insonify/tracing/line_tracer.hpp>
#include <vector>

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
