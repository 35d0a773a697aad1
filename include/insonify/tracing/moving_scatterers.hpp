#ifndef INSONIFY_TRACING_MOVING_SCATTERERS_HPP
#define INSONIFY_TRACING_MOVING_SCATTERERS_HPP

#include <insonify/acoustics/scattering.hpp>
#include <insonify/scene/velocity_field.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Pulses at equal intervals.
struct pulse_train {
    float start = 0;         ///< time of pulse 0, seconds: tissue and blood are where they are at rest
    float interval = 0;      ///< one over the pulse repetition frequency, seconds
    std::uint32_t count = 1; ///< number of pulses that are acquired
    std::uint32_t first = 0; ///< the first of them: a long train is acquired in parts

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
/// changes by exactly what the velocity says, however long the train, and the scatterers of straight streamlines stay
/// the same ones. Pieces at rest are emitted once, for all pulses.
template <scattering_field Scattering, velocity_field Field>
struct moving_scatterers {
    static constexpr std::uint32_t all_pulses = ~0U; ///< the value of `*current` for tissue at rest

    Scattering at_rest{};             ///< at the first pulse
    const Field* field = nullptr;     ///< velocities
    pulse_train pulses{};             ///< their times
    std::uint32_t* current = nullptr; ///< receives the number in the train of the pulse that is emitted next

    /// See `scattering_field`.
    template <class Emit>
    INSONIFY_FN void scatter(const material_line& line, float begin, float end, float spacing, Emit&& emit) const {
        const float piece = 8 * spacing; // one wavelength
        if (!(end - begin < 0x1p25F * spacing)) return;
        float resting_from = begin;
        const auto emit_resting = [&](float until) {
            *current = all_pulses;
            if (until > resting_from) at_rest.scatter(line, resting_from, until, spacing, emit);
        };
        const auto last = static_cast<std::uint32_t>(end / piece);
        for (auto i = static_cast<std::uint32_t>(begin / piece); i <= last; ++i) {
            const float from = max(begin, static_cast<float>(i) * piece),
                        to = min(end, static_cast<float>(i + 1) * piece);
            const vec3 centre = line.at((static_cast<float>(i) + 0.5F) * piece);
            if (!(to > from) || !moves(line.object, centre)) continue;
            emit_resting(from);
            emit_moving(line, from, to, centre, spacing, emit);
            resting_from = to;
        }
        emit_resting(end);
    }

    /// See `scattering_field`.
    INSONIFY_FN float covariance(float distance, float angle) const { return at_rest.covariance(distance, angle); }

  private:
    INSONIFY_FN bool moves(std::uint32_t object, vec3 point) const {
        for (std::uint32_t k = 0; k < pulses.end(); ++k)
            if ((*field)(object_id{object}, point, pulses.time(k)) != vec3{0, 0, 0}) return true;
        return false;
    }

    template <class Emit>
    INSONIFY_FN void emit_moving(const material_line& line, float from, float to, vec3 centre, float spacing,
                                 Emit&& emit) const {
        dvec3 moved{0, 0, 0}; // a float would lose the phase in a long train
        for (std::uint32_t k = 0; k < pulses.end(); ++k) {
            if (k >= pulses.first) {
                material_line now = line;
                now.origin = vec3{dvec3{line.origin} - moved};
                *current = k - pulses.first;
                at_rest.scatter(now, from, to, spacing, emit);
            }
            const vec3 velocity = (*field)(object_id{line.object}, centre, pulses.time(k) + 0.5F * pulses.interval);
            moved += static_cast<double>(pulses.interval) * dvec3{velocity};
        }
    }
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI
#endif
