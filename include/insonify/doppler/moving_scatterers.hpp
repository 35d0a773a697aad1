#ifndef INSONIFY_DOPPLER_MOVING_SCATTERERS_HPP
#define INSONIFY_DOPPLER_MOVING_SCATTERERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/scatterers/scattering.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <cmath>
#include <cstdint>

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

namespace detail {

/// A scatterer field at the time of each pulse of a train.
///
/// Space is divided along the line into pieces of one wavelength. From pulse to pulse, the scatterers of a piece move
/// with the velocity at its centre; pieces slide past each other where there is shear. So the phase of their echoes
/// changes by exactly what the velocity says, however long the train. Pieces at rest are emitted once, for all pulses.
///
/// Scatterers move in tissue at rest, and the deformation moves them on from there. Where it has the gradient F, a velocity V
/// at rest becomes F V. Blood moves by V / det F at rest, so that its volume flow through a vessel is that of the field
/// however the vessel is deformed (the Piola transform).
template <scattering_field Scattering, velocity_field Field>
struct moving_scatterers {
    static constexpr std::uint32_t all_pulses = ~0U; ///< the value of `*current` for tissue at rest

    Scattering at_rest{};             ///< at the first pulse
    const Field* field = nullptr;     ///< velocities
    pulse_train pulses{};             ///< their times
    float piece = 0;                  ///< metres
    float from = 0;                   ///< those nearer to the probe are not needed, metres along the line
    std::uint32_t* current = nullptr; ///< receives the number in the train of the pulse that is emitted next

    /// See `scattering_field`.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line& line, float begin, float end, float spacing, Emit&& emit) const {
        if (!(end - begin < 0x1p25F * min(spacing, piece))) return;
        float resting_from = begin;
        const auto emit_resting = [&](float until) {
            *current = all_pulses;
            if (until > resting_from) scatter_along_fibres(at_rest, line, resting_from, until, spacing, emit);
        };
        const auto last = static_cast<std::uint32_t>(end / piece);
        for (auto i = static_cast<std::uint32_t>(begin / piece); i <= last; ++i) {
            const float piece_begin = max(begin, static_cast<float>(i) * piece),
                        piece_end = min(end, static_cast<float>(i + 1) * piece);
            if (!(piece_end > piece_begin)) continue;
            const velocity_at_rest around{line, line.at((static_cast<float>(i) + 0.5F) * piece)};
            if (!moves(line.object, around.point)) continue;
            emit_resting(piece_begin);
            if (piece_end > from) emit_moving(line, piece_begin, piece_end, around, spacing, emit);
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

    INSONIFY_FN bool moves(std::uint32_t object, vec3 point) const {
        for (std::uint32_t k = 0; k < pulses.end(); ++k)
            if ((*field)(object_id{object}, point, pulses.time(k)) != vec3{0, 0, 0}) return true;
        return false;
    }

    // Long trains would shear blood until neighbouring lines see none of the same scatterers, since velocities are those
    // of pieces. So flowing media are renewed, as blood is that leaves the beam: one generation of scatterers is alone for
    // `stay` pulses, and fades into the next one during as many, at constant power.
    static constexpr std::uint32_t stay = 64, generation = 2 * stay;

    template <class Emit>
    INSONIFY_FN void emit_moving(const material_line& line, float begin, float end, const velocity_at_rest& around,
                                 float spacing, Emit&& emit) const {
        const bool renewed = line.frame_number != 0;
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
            if (weight == 1)
                scatter_along_fibres(at_rest, now, begin, end, spacing, emit);
            else
                scatter_along_fibres(at_rest, now, begin, end, spacing,
                                     [&](const scatterer_run& run) { emit_weighted(run, weight, emit); });
        };
        const std::uint32_t first =
            renewed && pulses.first >= generation ? pulses.first / generation * generation - stay : 0;
        for (std::uint32_t k = first; k < pulses.end(); ++k) {
            const std::uint32_t number = k / generation, age = k % generation;
            if (renewed && age == stay) next_birth = moved;
            if (renewed && age == 0) birth = next_birth;
            if (k >= pulses.first) {
                *current = k - pulses.first;
                if (!renewed || age < stay) {
                    emit_generation(renewed ? number : 0, birth, 1);
                } else {
                    const float turn = 0.5F * pi * (static_cast<float>(age - stay) + 0.5F) / stay;
                    emit_generation(number, birth, std::cos(turn));
                    emit_generation(number + 1, next_birth, std::sin(turn));
                }
            }
            const vec3 velocity =
                (*field)(object_id{line.object}, around.point, pulses.time(k) + 0.5F * pulses.interval);
            moved += static_cast<double>(pulses.interval * around.factor) * dvec3{velocity};
        }
    }

    template <class Emit>
    INSONIFY_FN static void emit_weighted(scatterer_run run, float weight, Emit&& emit) {
        constexpr std::uint32_t room = 128;
        float real[room], imaginary[room];
        for (std::uint32_t done = 0; done < run.count; done += room) {
            const std::uint32_t count = run.count - done < room ? run.count - done : room;
            for (std::uint32_t i = 0; i < count; ++i) {
                real[i] = weight * run.real[done + i];
                imaginary[i] = weight * run.imaginary[done + i];
            }
            emit(scatterer_run{.first = run.first + static_cast<float>(done) * run.step,
                               .step = run.step,
                               .count = count,
                               .real = real,
                               .imaginary = imaginary,
                               .slope = run.slope});
        }
    }
};

/// Scatterers move first; where fibres are curved, what has moved is straightened.
template <class Scattering, class Field, class Emit>
INSONIFY_FN void scatter_along_fibres(const moving_scatterers<Scattering, Field>& moving, const material_line& line,
                                      float begin, float end, float spacing, const Emit& emit) {
    moving.scatter(line, begin, end, spacing, emit);
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
