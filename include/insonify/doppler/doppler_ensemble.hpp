#ifndef INSONIFY_DOPPLER_DOPPLER_ENSEMBLE_HPP
#define INSONIFY_DOPPLER_DOPPLER_ENSEMBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/slow_time.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/electronic_noise.hpp>
#include <insonify/tracing/trace.hpp>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Pulses at equal intervals.
struct pulse_train {
    float start = 0;         ///< time of pulse 0, seconds: tissue and blood are where they are at rest
    float interval = 0;      ///< one over the pulse repetition frequency, seconds
    std::uint32_t count = 1; ///< number of pulses that are acquired
    std::uint32_t first = 0; ///< the first of them: a long train is acquired in parts
    float burst = 0; ///< length of the excitation in cycles, as of a `pulse`: a long one loses more to attenuation
    float from = 0;  ///< moving scatterers that are nearer to the probe are left out, metres along the lines

    /// The pulse after the last one.
    INSONIFY_FN std::uint32_t end() const { return first + count; }
    /// Time of a pulse, seconds.
    INSONIFY_FN float time(std::uint32_t pulse) const {
        return static_cast<float>(static_cast<double>(start) +
                                  static_cast<double>(interval) * static_cast<double>(pulse));
    }
};

/// Received echoes of a pulse train: those of a pulse are the sum of what rests and of what moves.
struct ensemble_echoes {
    iq_lines resting{};             ///< the same for all pulses
    std::vector<iq_lines> moving{}; ///< for each pulse
};

namespace detail {

/// What the scatterers that are emitted next belong to.
struct emitted_part {
    std::uint32_t pulse = ~0U; ///< number in the train; ~0U: all, for tissue at rest
    float weight = 1;          ///< of the amplitudes
};

/// A scatterer field at the time of each pulse of a train.
///
/// Space is divided along the line into pieces of one wavelength. From pulse to pulse, the scatterers of a piece move
/// with the velocity at its centre; pieces slide past each other where there is shear. So the phase of their echoes
/// changes by exactly what the velocity says, however long the train. Pieces at rest are emitted once, for all pulses.
///
/// Scatterers move in tissue at rest, and the deformation moves them on from there. Where it has the gradient F, a
/// velocity V at rest becomes F V. Blood moves by V / det F at rest, so that its volume flow through a vessel is that
/// of the field however the vessel is deformed (the Piola transform).
template <scattering_field Scattering, velocity_field Field>
struct moving_scatterers {
    Scattering at_rest{};            ///< at the first pulse
    const Field* field = nullptr;    ///< velocities
    pulse_train pulses{};            ///< their times
    float piece = 0;                 ///< metres
    emitted_part* current = nullptr; ///< receives what is emitted next

    /// See `scattering_field`.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line& line, float begin, float end, float spacing, Emit&& emit) const {
        if (!(end - begin < 0x1p25F * min(spacing, piece))) return;
        float resting_from = begin;
        const auto emit_resting = [&](float until) {
            *current = {};
            if (until > resting_from) at_rest.scatter(line, resting_from, until, spacing, emit);
        };
        const auto first = static_cast<std::uint32_t>(begin / piece), last = static_cast<std::uint32_t>(end / piece);
        const std::uint32_t stay = line.frame_number != 0 ? generation_of(line, first, last) : 0;
        for (std::uint32_t i = first; i <= last; ++i) {
            const float piece_begin = max(begin, static_cast<float>(i) * piece),
                        piece_end = min(end, static_cast<float>(i + 1) * piece);
            if (!(piece_end > piece_begin)) continue;
            const velocity_at_rest around = middle_of(line, i);
            if (!moves(line.object, around.point)) continue;
            emit_resting(piece_begin);
            if (piece_end > pulses.from) emit_moving(line, piece_begin, piece_end, around, stay, spacing, emit);
            resting_from = piece_end;
        }
        emit_resting(end);
    }

    /// See `scattering_field`.
    INSONIFY_FN float covariance(float distance, float angle) const { return at_rest.covariance(distance, angle); }

  private:
    // What the field says of a piece, in coordinates of the object.
    struct velocity_at_rest {
        vec3 point;       // where its centre was at rest
        float factor = 1; // of the velocity there

        INSONIFY_FN velocity_at_rest(const material_line& line, vec3 centre) : point{centre} {
            if (line.displacement == nullptr) return;
            point = line.displacement->rest(centre);
            if (line.flowing) factor = determinant(line.displacement->gradient(centre)); // of the inverse of F
        }
    };

    INSONIFY_FN velocity_at_rest middle_of(const material_line& line, std::uint32_t number) const {
        return {line, line.at((static_cast<float>(number) + 0.5F) * piece)};
    }

    INSONIFY_FN bool moves(std::uint32_t object, vec3 point) const {
        for (std::uint32_t k = 0; k < pulses.end(); ++k)
            if ((*field)(object_id{object}, point, pulses.time(k)) != vec3{0, 0, 0}) return true;
        return false;
    }

    // Long trains would shear blood until neighbouring lines see none of the same scatterers. So flowing media are
    // renewed: one generation of scatterers is alone for `stay` pulses, and fades into the next one during as many.
    //
    // What passes from piece to piece changes its phase by as much as these have slid past each other since their
    // generation began. Up to 0.6 of a piece, the spectrum of Poiseuille flow ends where that of plug flow does
    // (tests/doppler/pulsed_doppler.cpp). A power of two, so that most neighbouring lines have the same generations.
    // @return  `stay`, from velocities over a second
    INSONIFY_FN std::uint32_t generation_of(const material_line& line, std::uint32_t first, std::uint32_t last) const {
        constexpr std::uint32_t shortest = 16, longest = 64, times = 10; // an ensemble of colour is one generation
        const float max_slide = 0.6F * piece;                            // that they slide
        if (pulses.end() <= shortest) return longest;
        float fastest = 0, before[times] = {}; // m/s along the line
        for (std::uint32_t i = first; i <= last; ++i) {
            const velocity_at_rest around = middle_of(line, i);
            for (std::uint32_t k = 0; k < times; ++k) {
                const vec3 velocity = (*field)(object_id{line.object}, around.point,
                                               pulses.start + static_cast<float>(k) / static_cast<float>(times));
                const float now = around.factor * dot(velocity, line.along);
                if (i > first) fastest = max(fastest, std::fabs(now - before[k]));
                before[k] = now;
            }
        }
        std::uint32_t stay = longest;
        while (stay > shortest && 2 * static_cast<float>(stay) * pulses.interval * fastest > max_slide) stay /= 2;
        return stay;
    }

    // @param stay  0: the scatterers stay for ever
    template <class Emit>
    INSONIFY_FN void emit_moving(const material_line& line, float begin, float end, const velocity_at_rest& around,
                                 std::uint32_t stay, float spacing, Emit&& emit) const {
        const bool renewed = stay != 0;
        const std::uint32_t generation = renewed ? 2 * stay : 1;
        dvec3 moved{0, 0, 0}, birth{0, 0, 0}, next_birth{0, 0, 0}; // floats would lose the phase in a long train
        const auto emit_generation = [&](std::uint32_t number, const dvec3& born, float weight) {
            material_line now = line;
            displacement_view deformed;
            if (line.displacement == nullptr) {
                now.origin = vec3{dvec3{line.origin} - (moved - born)};
            } else {
                deformed = *line.displacement;
                deformed.offset = vec3{born - moved};
                now.displacement = &deformed;
            }
            now.frame_number += number * 0x9E3779B9U;
            current->weight = weight;
            at_rest.scatter(now, begin, end, spacing, emit);
        };
        const std::uint32_t first =
            renewed && pulses.first >= generation ? pulses.first / generation * generation - stay : 0;
        for (std::uint32_t k = first; k < pulses.end(); ++k) {
            const std::uint32_t number = k / generation, age = k % generation;
            if (renewed && age == stay) next_birth = moved;
            if (renewed && age == 0) birth = next_birth;
            if (k >= pulses.first) {
                current->pulse = k - pulses.first;
                if (!renewed || age < stay) {
                    emit_generation(renewed ? number : 0, birth, 1);
                } else {
                    const float turn = 0.5F * pi * (static_cast<float>(age - stay) + 0.5F) / static_cast<float>(stay);
                    emit_generation(number, birth, std::cos(turn));
                    emit_generation(number + 1, next_birth, std::sin(turn));
                }
            }
            const vec3 velocity =
                (*field)(object_id{line.object}, around.point, pulses.time(k) + 0.5F * pulses.interval);
            moved += static_cast<double>(pulses.interval * around.factor) * dvec3{velocity};
        }
    }
};

/// The surfaces of one line, which move with the tissue beside them. Flowing media do not move their walls.
///
/// A plane surface that moves with the velocity v is met at a distance that changes by v . n / (a . n), where n is its
/// normal and a the direction of the line.
class moving_surfaces {
  public:
    /// @param line  with its layers at the first pulse
    /// @return      whether any surface moves
    template <velocity_field Field>
    bool assign(const traced_line& line, const Field& field, const pulse_train& pulses) {
        const view<const layer> layers = line.layers;
        now_.assign(layers.begin(), layers.end());
        motions_.clear();
        bool any = false;
        for (std::size_t i = 1; i < layers.size(); ++i) {
            const layer &above = layers[i - 1], &below = layers[i];
            const bool flows_above = line.media[above.medium].flowing, flows_below = line.media[below.medium].flowing;
            motion of_surface{};
            if (!(flows_above && flows_below)) {
                // Of two tissues, the one whose surface it is.
                const layer& tissue = flows_above || (!flows_below && below.own_begin.cosine > 0) ? below : above;
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
            now_[i + 1].moved.x = now_[i].moved.y = now_[i + 1].begin - of_surface.distance;
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

/// Distributes the echoes of one line over the pulses; for models it is an `echo_line`.
struct pulse_echoes {
    const line_task& task;
    view<vec2> out;              ///< `samples` of the resting echoes, then as many of each pulse
    std::size_t samples;         ///< along the line
    const emitted_part& current; ///< to which the echoes belong
    bool has_surfaces;           ///< else the echoes of surfaces are dropped

    detail::compensated_echoes now() const {
        const std::size_t slot = current.pulse + 1U; // 0 for all pulses
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
    void scatterers(scatterer_echoes run) const {
        run.first_level *= current.weight;
        run.last_level *= current.weight;
        now().scatterers(run);
    }
};

/// Emits the echoes of one line for every pulse. Its layers are those of the first one: within a train, tissue moves by
/// much less than the length of a pulse.
/// @param samples  along the line
/// @param out      those of the resting echoes, then as many of each pulse; echoes are added
template <class Model, velocity_field Field>
void emit_ensemble(const line_task& task, const Model& model, const Field& field, const pulse_train& pulses,
                   moving_surfaces& surfaces, std::size_t samples, view<vec2> out) {
    traced_line line = task.line;
    const bool surfaces_move = surfaces.assign(line, field, pulses);
    using scatterers = moving_scatterers<std::remove_cvref_t<decltype(model.scattering)>, Field>;
    emitted_part current;
    const scatterers moving{model.scattering, &field, pulses, display_speed / line.frequency, &current};
    model.with_scattering(moving).emit(line, pulse_echoes{task, out, samples, current, !surfaces_move});
    if (!surfaces_move) return;
    const auto no_speckle = model.with_scattering(no_scatterers{});
    for (std::uint32_t k = 0; k < pulses.end(); ++k) {
        if (k >= pulses.first) {
            current.pulse = k - pulses.first;
            line.layers = surfaces.layers();
            no_speckle.emit(line, pulse_echoes{task, out, samples, current, true});
        }
        surfaces.advance(field, pulses, k);
    }
}

} // namespace detail

/// How `doppler_ensemble` acquires the echoes of a pulse train.
struct ensemble_settings {
    float depth = 0.08F;       ///< metres
    std::uint32_t samples = 0; ///< depth samples of each line; 0: two per standard deviation of the shortest pulse
    float prf = 4e3F;          ///< pulse repetition frequency, hertz
    std::uint32_t pulses = 8;  ///< number of pulses along each line
    std::uint32_t first = 0;   ///< the first of them, where a long train is acquired in parts
    float from = 0;            ///< depth from which moving scatterers are needed, metres
    float burst = 4;           ///< length of the excitation in cycles: see `pulse`
    std::uint32_t planes = 1;  ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float time = 0;            ///< of pulse 0, seconds: the same time gives the same echoes
    float noise_db = -135;     ///< see `electronic_noise_settings`
    std::uint64_t seed = 1;    ///< of the noise

    /// @throws usage_error  for a setting out of range
    void check() const {
        check_depth(depth, "doppler");
        if (!is_finite(prf) || !(prf >= 1 && prf <= 1e6F))
            throw usage_error{"doppler: the prf is ", prf, " Hz; it must be 1 Hz to 1 MHz, such as 4_kHz"};
        if (pulses < 1 || pulses > 1U << 20U || first > 1U << 24U)
            throw usage_error{"doppler: the number of pulses must be 1 to 2^20; 8 to 16 are usual for colour"};
        detail::check_planes(planes, "doppler");
        if (!is_finite(time)) throw usage_error{"doppler: `time` must be a finite number of seconds"};
    }
};

/// `doppler_ensemble` and `trace_ensemble`, train after train: holds tables, layers and memory, so that it allocates
/// only while buffers grow.
template <acoustic_model Model = physical<>>
class ensemble_scanner {
  public:
    /// See `doppler_ensemble`. @return valid until the next call
    template <exec::policy Policy, transducer Probe, velocity_field Field>
    const iq_ensemble& acquire(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                               const Model& model, const Field& field, const ensemble_settings& settings) {
        settings.check();
        if constexpr (requires { field.check(); }) field.check();
        const pulse sent = nominal_pulse(probe, settings.burst);
        const std::uint32_t samples =
            settings.samples != 0 ? settings.samples : samples_for(settings.depth, sent.sigma_z(probe.frequency));
        const std::uint32_t frame =
            mix_bits(__builtin_bit_cast(std::uint32_t, settings.time)) | 1U; // not 0: blood flows
        float slowest = 1; // over c0: the echoes behind slow media are displayed deeper than they lie
        for (const medium& each : body.media())
            if (!detail::blocks_sound(each)) slowest = min(slowest, each.sound_speed / display_speed);
        trace(detail::any_policy{policy}, body, probe, at, model, field,
              {.depth = settings.depth, .samples = samples, .planes = settings.planes, .frame = frame},
              {.start = settings.time,
               .interval = 1 / settings.prf,
               .count = settings.pulses,
               .first = settings.first,
               .burst = settings.burst,
               .from = slowest * settings.from},
              resting_, echoes_.pulses);
        const auto formed = [&](iq_lines echoes) {
            return convolver_.convolve(policy, std::move(echoes), sent, probe);
        };
        resting_ = formed(std::move(resting_));
        echoes_.prf = settings.prf;
        for (std::uint32_t k = 0; k < settings.pulses; ++k) {
            iq_lines& echoes = echoes_.pulses[k];
            echoes = formed(std::move(echoes));
            exec::for_each_in_blocks(policy, echoes.values.size(), 4096, 1,
                                     [&](std::size_t i) { echoes.values[i] += resting_.values[i]; });
            echoes = add_electronic_noise(
                policy, std::move(echoes),
                {.level_db = settings.noise_db, .seed = settings.seed, .frame = frame + settings.first + k});
        }
        return echoes_;
    }

    /// See `trace_ensemble`.
    /// @param resting, moving  receive the echoes, as in `ensemble_echoes`; their memory is reused
    template <exec::policy Policy, transducer Probe, velocity_field Field>
    void trace(const Policy& policy, const scene& body, const Probe& probe, const pose& at, const Model& model,
               const Field& field, const acquisition& scan, const pulse_train& pulses, iq_lines& resting,
               std::vector<iq_lines>& moving) {
        probe_.assign(probe);
        const std::uint32_t samples = detail::check_acquisition(body, probe_.settings(), at, model, scan);
        detail::frame_view frame = plan_.view_of(policy, probe_, at, model, scan, samples, body.media());
        frame.bandwidth = nominal_pulse(probe, pulses.burst).bandwidth_at_peak();
        moving.resize(pulses.count);
        sinks_.assign(1, &resting);
        for (iq_lines& each : moving) sinks_.push_back(&each);
        for (iq_lines* const each : sinks_) each->reshape(probe.lines, samples, scan.depth);
        if (surfaces_.size() < detail::blocks_of(probe.lines)) surfaces_.resize(detail::blocks_of(probe.lines));
        constexpr float line_time = 1e6F;
        driver_.emit_lines(policy, body, probe_, frame, model, straight_lines{}, line_time,
                           {sinks_.data(), sinks_.size()},
                           [&](std::size_t block, const line_task& task, view<vec2> echoes) {
                               detail::emit_ensemble(task, model, field, pulses, surfaces_[block], samples, echoes);
                           });
    }

  private:
    detail::probe_lines probe_{};
    detail::frame_plan<Model> plan_{};
    detail::line_driver<vec2> driver_{};
    std::vector<detail::moving_surfaces> surfaces_{}; // of each block of lines
    std::vector<iq_lines*> sinks_{};
    convolver convolver_{};
    iq_lines resting_{};
    iq_ensemble echoes_{};
};

/// What the probe receives of a pulse train while tissue and blood move as `field` says: the geometry is that of the
/// scene for all pulses.
///
/// @param model   `physical`, or another model with its members `scattering`, `with_scattering` and `emit`
/// @param pulses  their times
/// @throws usage_error, geometry_error  as `trace`
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
ensemble_echoes trace_ensemble(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                               const Model& model, const Field& field, const acquisition& scan,
                               const pulse_train& pulses) {
    ensemble_echoes echoes;
    ensemble_scanner<Model>{}.trace(detail::any_policy{policy}, body, probe, at, model, field, scan, pulses,
                                    echoes.resting, echoes.moving);
    return echoes;
}

/// The echoes of a pulse train along the lines of a probe, after pulse and beam: the input of all Doppler methods.
///
/// Between pulses, scatterers and surfaces move as `field` says; the geometry is that of the scene for all pulses. All
/// lines are acquired at once. Blood that flows out of the slice is followed by other blood.
///
/// @throws usage_error, geometry_error  as `trace`, and for settings out of range
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
iq_ensemble doppler_ensemble(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                             const Model& model, const Field& field, const ensemble_settings& settings = {}) {
    return ensemble_scanner<Model>{}.acquire(policy, body, probe, at, model, field, settings);
}
/// The same with `physical`.
template <exec::policy Policy, transducer Probe, velocity_field Field>
iq_ensemble doppler_ensemble(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                             const Field& field, const ensemble_settings& settings = {}) {
    return doppler_ensemble(policy, body, probe, at, physical<>{}, field, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
