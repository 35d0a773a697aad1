#ifndef INSONIFY_TRACING_APERTURE_APERTURE_VIEW_HPP
#define INSONIFY_TRACING_APERTURE_APERTURE_VIEW_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/tracing/aperture/turned_line.hpp>
#include <insonify/tracing/emit/tracer.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <cfloat>
#include <cmath>
#include <cstddef>

/// Sound reaches a point from the whole width of the aperture, so shadows have a penumbra: behind a needle it comes
/// past it from both sides, and beside a needle part of it is blocked. Here lines are traced to every point from
/// several places of the aperture, and the `aperture_gains` of its line are computed from what arrives:
///
///     surfaces   mean(a)^2 / T               a^2: amplitude there and back along one of the lines, by the model
///     speckle    rms(a * a) / rms(1 * 1) / T      *: convolution across the aperture
///     depth      mean(a d) / mean(a)         d: displayed depth along one of the lines
///
/// over the aperture |u| < z / 2F; T is the amplitude there and back along the line that is displayed. Source: sound
/// that is focused adds by pressure, out and back; the echo power of independent scatterers is the integral of the
/// squared two-way beam, whose spectrum is a * a. Behind a strip 0.72 mm wide, F/2, 7.5 MHz, 5, 10 and 20 mm: -5.7,
/// -2.9, -1.4 dB; a sum of waves has -5.6, -3.0, -1.4 dB.
///
/// A line from the side is given the angle of incidence and the attenuation of the straight line through the same point
/// (`incidence_at`). So plane layers leave the gains at 1, and their echoes have the levels of plane waves.
namespace insonify::inline INSONIFY_ABI::detail {

/// What arrives at one depth of a line.
struct sound_at_depth {
    float amplitude = 0;     ///< one way
    float shown = 0;         ///< displayed depth, metres
    std::uint32_t place = 0; ///< what the depth lies in: see `layer::place`
};

/// What arrives along a line, at equal steps of depth: element k at (k + 1) * spacing.
struct sound_profile {
    static constexpr std::uint32_t steps = 64;

    sound_at_depth at[steps] = {};

    /// @param line     with its layers
    /// @param spacing  of the steps, metres
    template <class Model>
    INSONIFY_FN void compute(const traced_line& line, const Model& model, float spacing) {
        vec2 both_ways[steps];
        model.arrivals(line, spacing, view<vec2>{both_ways, steps});
        std::size_t i = 0;
        for (std::uint32_t k = 0; k < steps; ++k) {
            // A step on a surface lies behind it, as in `physical::arrivals`.
            while (i + 1 < line.layers.size() && line.layers[i].end <= static_cast<float>(k + 1) * spacing) ++i;
            at[k] = {std::sqrt(max(both_ways[k].x, aperture_gains::min_amplitude)), both_ways[k].y,
                     line.layers[i].place};
        }
    }
};

/// What arrives at a point through the whole aperture.
struct aperture_mean {
    float surfaces = 0; ///< square of the mean amplitude, one way
    float speckle = 0;  ///< rms of the amplitude's convolution with itself, over that of 1
    float shown = 0;    ///< displayed depth, metres
    bool any = false;   ///< some line arrives
};

/// Interpolates linearly between two values, either of which may be unusable.
struct blend_of_two {
    bool first = true, second = true;
    float fraction = 0;

    INSONIFY_FN bool any() const { return first || second; }
    template <class Value>
    INSONIFY_FN Value operator()(const Value& a, const Value& b) const {
        return first && second ? a + fraction * (b - a) : first ? a : b;
    }
};

/// Lines of the probe, equally far apart, whose points are shaded. They are reached by the lines of a fan: those of the
/// points, and of a phased array, whose aperture is as wide at the edges of its sector, also some beyond.
struct shaded_lines {
    face_shape face{};
    std::uint32_t first = 0; ///< line of the probe
    std::uint32_t stride = 1;
    std::uint32_t count = 0;
    std::uint32_t beyond = 0; ///< lines of the fan on either side of those of the points

    INSONIFY_FN std::uint32_t line_of(std::uint32_t point) const { return first + point * stride; }
    /// The point whose line is nearest to one of the fan.
    INSONIFY_FN std::uint32_t nearest(std::uint32_t line) const {
        const std::uint32_t point = line < beyond ? 0 : line - beyond;
        return point < count ? point : count - 1;
    }
};

/// Upper bound of the directions.
inline constexpr std::uint32_t max_aperture_directions = 64;

/// One of the directions in which lines are traced to the points, at one depth.
struct aperture_part {
    float fraction = 0; ///< of the aperture, that the direction stands for
    float crossed = 0; ///< lines that it has crossed on its way; where lines leave a point, each crosses another number
};

/// The gains of all lines of a frame, by plane, line and step.
struct frame_gains {
    view<aperture_gain> values{}; ///< none: each line alone counts
    std::uint32_t lines = 0;
    float spacing = 1; ///< from step to step, metres

    INSONIFY_FN std::size_t first(std::uint32_t line, std::uint32_t plane) const {
        return (std::size_t{plane} * lines + line) * sound_profile::steps;
    }
    INSONIFY_FN aperture_gains of_line(std::uint32_t line, std::uint32_t plane) const {
        if (values.empty()) return {};
        return {{values.data() + first(line, plane), sound_profile::steps}, spacing};
    }
};

/// The steps of an aperture shading, over flat arrays: each for all lines, in any order, on any threads or on a device.
/// Trivially copyable.
struct aperture_view {
    static constexpr std::uint32_t steps = sound_profile::steps;
    static constexpr std::uint32_t points_at_once = simd_width;

    frame_view frame;
    scene_view scene{};
    shaded_lines points{};
    view<const line_fan::line> fan{};  ///< in coordinates of its own
    pose upright{};                    ///< to those of the probe
    std::uint32_t directions = 0;      ///< of each plane
    float spacing = 1;                 ///< from step to step, metres
    view<const line_turn> turns{};     ///< of the lines in each direction and plane
    view<const aperture_part> parts{}; ///< by direction, plane and step
    view<sound_profile> profiles{};    ///< of each line by itself, by plane and line
    view<sound_at_depth> sound{};      ///< by direction, plane, step and line of the fan
    view<aperture_mean> means{};       ///< by plane, step and point
    frame_gains gains{};

    INSONIFY_FN std::size_t row(std::uint32_t plane, std::uint32_t step) const {
        return std::size_t{plane} * steps + step;
    }
    INSONIFY_FN std::size_t row_of(std::uint32_t direction, std::uint32_t plane, std::uint32_t step) const {
        return std::size_t{direction} * frame.planes * steps + row(plane, step);
    }

    /// Step 1: what arrives along a line of the probe.
    template <class Model>
    INSONIFY_FN void find_profile(std::uint32_t line, std::uint32_t plane, view<const layer> layers,
                                  const Model& model) const {
        traced_line traced = task_of(frame, scene, line, plane).line;
        traced.layers = layers;
        profiles[std::size_t{plane} * frame.count() + line].compute(traced, model, spacing);
    }

    /// Step 2: what arrives along a line of the fan in one direction.
    /// @param objects  that contain the origin of the nearest point's line, behind the face
    /// @param from     the crossings of the turned line, at metres along it
    /// @return         false where the room is too small
    template <class Model>
    INSONIFY_FN bool find_sound(std::uint32_t direction, std::uint32_t line, std::uint32_t plane,
                                view<const std::uint32_t> objects, const Model& model, const crossing_source& from,
                                line_room room) const {
        const line_turn turn = turn_of(direction, plane, line);
        // Lines beyond the points on one side reach none of them where they are shifted away from these.
        if (turn.shift > 0 ? line >= points.beyond + points.count : line < points.beyond) return true;
        traced_line heard = along_fan(line, plane);
        turned_line turned{heard.frame, turn};
        turned.tilt = frame.tilt(turned.direction(), plane);
        const crossing_collector collector{scene,
                                           {turned.origin(), turned.frame().path(), 0, turn.length_to(frame.max_depth)},
                                           frame.max_depth,
                                           room.found};
        // A turned line begins where that of the point does, in the same objects; a shifted one begins in the objects
        // whose surfaces it crosses an odd number of times.
        room.found.clear();
        if (!turn.is_shift())
            for (const std::uint32_t rank : objects) room.found.inside.toggle(rank);
        from.for_each(collector, [&](crossing one) {
            one.distance = turn.depth_at(one.distance);
            if (turn.is_shift())
                collector.add(one);
            else if (one.distance > touching_distance && one.distance <= frame.max_depth)
                room.found.add(one);
        });
        room.found.sort();
        if (!room.found.complete()) return false;
        heard.layers =
            stack_layers(scene, turned, frame.max_depth, room.found, room.layers, !takes_normal_incidence<Model>);
        if (heard.layers.empty()) return false;
        sound_profile profile;
        profile.compute(heard, model, spacing);
        for (std::uint32_t step = 0; step < steps; ++step)
            sound[row_of(direction, plane, step) * fan.size() + line] = profile.at[step];
        return true;
    }

    /// Step 3: what arrives at `points_at_once` points from one on, at one depth of one plane, through the whole
    /// aperture.
    INSONIFY_FN void find_means(std::uint32_t plane, std::uint32_t step, std::uint32_t first) const {
        float amplitudes[max_aperture_directions][points_at_once], fractions[max_aperture_directions][points_at_once];
        float depths[points_at_once] = {};
        std::uint32_t places[points_at_once];
        const std::uint32_t left = points.count - first, count = left < points_at_once ? left : points_at_once;
        for (std::uint32_t i = 0; i < count; ++i)
            places[i] = profile_of(points.line_of(first + i), plane).at[step].place;
        for (std::uint32_t k = 0; k < directions; ++k) {
            for (std::uint32_t i = 0; i < points_at_once; ++i) amplitudes[k][i] = fractions[k][i] = 0;
            const aperture_part part = parts[row_of(k, plane, step)];
            if (!(part.fraction > 0)) continue;
            for (std::uint32_t i = 0; i < count; ++i) {
                const blended_sound heard = sound_at(k, plane, step, first + i, part.crossed, places[i]);
                if (!heard.any) continue; // only sound that arrives in the same place counts
                fractions[k][i] = part.fraction;
                amplitudes[k][i] = part.fraction * heard.amplitude;
                depths[i] += amplitudes[k][i] * heard.shown;
            }
        }
        const received heard = receive(amplitudes), all = receive(fractions);
        const floats smallest(FLT_MIN); // divides where there is no line at all
        float mean[points_at_once], rms[points_at_once], depth[points_at_once], whole[points_at_once];
        store(load<simd_width>(depths) / max(heard.sum, smallest), depth);
        store(heard.sum / max(all.sum, smallest), mean);
        store(sqrt(heard.power / max(all.power, smallest)), rms);
        store(all.sum, whole);
        for (std::uint32_t i = 0; i < count; ++i)
            means[row(plane, step) * points.count + first + i] = {mean[i] * mean[i], rms[i], depth[i], whole[i] > 0};
    }

    /// Step 4: the gains of a line: what arrives at the nearest points through the aperture, divided by what arrives
    /// along the line.
    INSONIFY_FN void find_gains(std::uint32_t line, std::uint32_t plane) const {
        const float apart =
            (static_cast<float>(line) - static_cast<float>(points.first)) / static_cast<float>(points.stride);
        const bool circle = points.face.full_circle;
        const float within = circle ? apart : clamp(apart, 0, static_cast<float>(points.count - 1));
        const auto before = static_cast<std::uint32_t>(within), next = before + 1;
        const std::uint32_t after = next < points.count ? next : circle ? 0 : before;
        const float fraction = within - static_cast<float>(before);
        const sound_profile &own = profile_of(line, plane), &left = profile_of(points.line_of(before), plane),
                            &right = profile_of(points.line_of(after), plane);
        aperture_gain gain{}; // where no point is of use, that of the step above holds
        float here = 1;       // amplitude along the line alone, there and back
        for (std::uint32_t step = 0; step < steps; ++step) {
            const std::uint32_t place = own.at[step].place;
            const aperture_mean &a = means[row(plane, step) * points.count + before],
                                &b = means[row(plane, step) * points.count + after];
            const blend_of_two between{a.any && left.at[step].place == place, b.any && right.at[step].place == place,
                                       fraction};
            const float above = here;
            here = own.at[step].amplitude * own.at[step].amplitude;
            if (between.any())
                gain = {between(a.surfaces, b.surfaces) / here, between(a.speckle, b.speckle) / here,
                        between(a.shown, b.shown) - own.at[step].shown};
            else { // no more sound arrives than at the step above, unless the line itself brings it
                gain.surfaces = min(gain.surfaces, max(gain.surfaces * (above / here), 1));
                gain.speckle = min(gain.speckle, max(gain.speckle * (above / here), 1));
            }
            gains.values[gains.first(line, plane) + step] = gain;
        }
    }

    /// Those of the lines of the fan in one direction of one plane.
    INSONIFY_FN line_turn turn_of(std::uint32_t direction, std::uint32_t plane, std::uint32_t line) const {
        line_turn own = turns[std::size_t{direction} * frame.planes + plane];
        if (!own.is_shift()) return own;
        const vec2 along = fan[line].along, across = own.face.across;
        own.sine = dot(across, along);
        own.cosine = across.x * along.y - across.y * along.x;
        return own;
    }

  private:
    using floats = lanes<simd_width>;

    INSONIFY_FN const sound_profile& profile_of(std::uint32_t line, std::uint32_t plane) const {
        return profiles[std::size_t{plane} * frame.count() + line];
    }

    // A line of the fan in one plane. Those beyond the lines of the probe are like the nearest of these, but for their
    // direction.
    INSONIFY_FN traced_line along_fan(std::uint32_t line, std::uint32_t plane) const {
        const std::uint32_t point = points.nearest(line);
        traced_line own = task_of(frame, scene, points.line_of(point), plane).line;
        if (line == point + points.beyond) return own;
        const vec2 along = fan[line].along;
        own.frame.along = frame.at.direction(upright.direction({along.x, 0, along.y}));
        own.frame.tilt = frame.tilt(own.frame.along, plane);
        return own;
    }

    struct blended_sound {
        bool any = false;
        float amplitude = 0, shown = 0; // see `sound_at_depth`
    };
    // What arrives at a point along one direction, in one place. The line that ends in the point lies between those of
    // two points, neither of which is used where it has left the fan: slices end there.
    INSONIFY_FN INSONIFY_INLINE blended_sound sound_at(std::uint32_t direction, std::uint32_t plane, std::uint32_t step,
                                                       std::uint32_t point, float crossed, std::uint32_t place) const {
        const auto count = static_cast<std::int32_t>(points.count), beyond = static_cast<std::int32_t>(points.beyond);
        const bool is_point = points.face.form == face_form::point; // else all cross as many lines
        const float back = -(
            is_point
                ? turn_of(direction, plane, point + points.beyond).lines_crossed(static_cast<float>(step + 1) * spacing)
                : crossed);
        constexpr float beyond_all = 1e9F; // lines
        const float whole = clamp(std::floor(back), -beyond_all, beyond_all), fraction = back - whole;
        std::int32_t from = static_cast<std::int32_t>(point) + beyond + static_cast<std::int32_t>(whole),
                     next = from + 1;
        bool from_within = true, next_within = true;
        if (points.face.full_circle) {
            from = (from % count + count) % count;
            next = (from + 1) % count;
        } else {
            const std::int32_t all = count + 2 * beyond;
            from_within = from >= 0 && from < all && (is_point || point > 0 || fraction == 0);
            next_within = next >= 0 && next < all && (is_point || point + 1 < points.count);
            if (!from_within) from = next;
            if (!next_within) next = from;
            if (!from_within && !next_within) return {};
        }
        const sound_at_depth* const along = sound.data() + row_of(direction, plane, step) * fan.size();
        const blend_of_two between{from_within && along[from].place == place, next_within && along[next].place == place,
                                   fraction};
        if (!between.any()) return {};
        return {true, between(along[from].amplitude, along[next].amplitude),
                between(along[from].shown, along[next].shown)};
    }

    // Sum over the directions, and the sum of the squares of their convolution with themselves.
    struct received {
        floats sum{0.0F}, power{0.0F};
    };
    INSONIFY_FN INSONIFY_INLINE received
    receive(const float (&of_points)[max_aperture_directions][points_at_once]) const {
        floats of[max_aperture_directions];
        received all;
        for (std::uint32_t k = 0; k < directions; ++k) {
            of[k] = load<simd_width>(of_points[k]);
            all.sum = all.sum + of[k];
        }
        for (std::uint32_t both = 0; both + 1 < 2 * directions; ++both) {
            floats together(0.0F);
            std::uint32_t i = both < directions ? 0 : both - directions + 1, j = both - i;
            for (; i < j; ++i, --j) together = multiply_add(of[i], of[j], together);
            together = together + together;
            if (i == j) together = multiply_add(of[i], of[i], together);
            all.power = multiply_add(together, together, all.power);
        }
        return all;
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
