#ifndef INSONIFY_TRACING_TRACE_ENSEMBLE_HPP
#define INSONIFY_TRACING_TRACE_ENSEMBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/moving_scatterers.hpp>
#include <insonify/tracing/moving_surfaces.hpp>
#include <insonify/tracing/trace.hpp>
#include <insonify/tracing/trace_line.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Received echoes of a pulse train: those of a pulse are the sum of what rests and of what moves.
struct ensemble_echoes {
    iq_lines resting{};             ///< the same for all pulses
    std::vector<iq_lines> moving{}; ///< for each pulse
};

/// Tables and buffers of `trace_ensemble`, kept so that it allocates only while buffers grow.
template <transducer Probe, acoustic_model Model, velocity_field Field>
struct ensemble_workspace {
    trace_workspace<Probe, Model> tracing{};                ///< of the frame
    std::vector<detail::moving_surfaces<Field>> surfaces{}; ///< for each block of lines
};

namespace detail {

/// Distributes the echoes of one line over the pulses; for models it is an `echo_line`.
struct pulse_echoes {
    const line_task& task;
    view<vec2> out;               ///< `samples` of the resting echoes, then as many of each pulse
    std::size_t samples;          ///< along the line
    const std::uint32_t& current; ///< the pulse, or `moving_scatterers::all_pulses`
    bool has_surfaces;            ///< else the echoes of surfaces are dropped

    compensated_echoes now() const {
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
/// @param out  `samples` of the resting echoes, then as many of each pulse; echoes are added
template <class Model, velocity_field Field>
void emit_ensemble(const line_task& task, const Model& model, view<const layer> layers, const Field& field,
                   const pulse_train& pulses, float from, moving_surfaces<Field>& surfaces, std::size_t samples,
                   view<vec2> out) {
    traced_line line = task.line;
    line.layers = layers;
    const bool surfaces_move = surfaces.assign(line, layers, field, pulses);
    using scatterers = moving_scatterers<std::remove_cvref_t<decltype(model.scattering)>, Field>;
    std::uint32_t current = scatterers::all_pulses;
    model.with_scattering(scatterers{model.scattering, &field, pulses, display_speed / line.frequency, from, &current})
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

/// What the probe receives of a pulse train while tissue and blood move as `field` says: the geometry is traced once.
///
/// @param model   `physical`, or another model with its members `scattering`, `with_scattering` and `emit`
/// @param pulses  their times
/// @param from    moving scatterers that are nearer to the probe are left out, metres along the lines
/// @param own     kept from frame to frame
/// @param out     receives the echoes; its memory is reused
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
void trace_ensemble(const Policy& policy, const scene& body, const Probe& probe, const pose& at, const Model& model,
                    const acquisition& scan, const Field& field, const pulse_train& pulses, float from,
                    ensemble_workspace<Probe, Model, Field>& own, ensemble_echoes& out) {
    const std::uint32_t samples = detail::check_acquisition(body, probe, at, model, scan);
    frame_view<Probe> frame = own.tracing.plan.view_of(policy, probe, at, model, scan, samples, body.media());
    pulse sent = nominal_pulse(probe);
    sent.burst = pulses.burst;
    frame.bandwidth = sent.bandwidth_at_peak();
    out.moving.resize(pulses.count);
    out.resting.reshape(probe.lines, samples, scan.depth);
    for (iq_lines& each : out.moving) each.reshape(probe.lines, samples, scan.depth);
    constexpr std::size_t block = detail::lines_per_block;
    own.surfaces.resize(std::max((probe.lines + block - 1) / block, own.surfaces.size()));
    const auto trace_block = [&](const scene_view& seen, const detail::block_tracer& tracer, std::size_t begin,
                                 std::size_t end) {
        detail::scratch_memory& memory = own.tracing.scratch[begin / block];
        std::vector<vec2>& room = own.tracing.plane_samples[begin / block];
        for (std::size_t i = begin; i < end; ++i) {
            const auto number = static_cast<std::uint32_t>(i);
            for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
                room.assign((std::size_t{pulses.count} + 1) * samples, vec2{0, 0});
                const line_task task = tracer.seen(detail::task_of(frame, seen, number, plane));
                memory.fit([&](line_scratch& scratch) {
                    const view<const layer> layers = tracer.template layers_of<Model>(task, scratch);
                    if (layers.empty()) return false;
                    detail::emit_ensemble(task, model, layers, field, pulses, from, own.surfaces[begin / block],
                                          samples, view<vec2>{room});
                    return true;
                });
                for (std::uint32_t slot = 0; slot <= pulses.count; ++slot) {
                    iq_lines& lines = slot == 0 ? out.resting : out.moving[slot - 1];
                    const view<vec2> sums{lines.values.data() + i * samples, samples},
                        echoes{room.data() + std::size_t{slot} * samples, samples};
                    if (plane == 0) std::fill(sums.begin(), sums.end(), vec2{0, 0});
                    if (frame.planes > 1)
                        detail::add_weighted(echoes, frame.weights(number, plane), sums);
                    else
                        std::copy(echoes.begin(), echoes.end(), sums.begin());
                }
            }
        }
    };
    detail::trace_blocks(policy, body, frame, model, straight_lines{}, 1e6F, own.tracing, trace_block);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
