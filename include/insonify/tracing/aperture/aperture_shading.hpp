#ifndef INSONIFY_TRACING_APERTURE_APERTURE_SHADING_HPP
#define INSONIFY_TRACING_APERTURE_APERTURE_SHADING_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/tracing/aperture/turned_lines.hpp>
#include <insonify/tracing/emit/trace_line.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Interpolates linearly between two values, either of which may be unusable.
struct blend_of_two {
    bool first = true, second = true;
    float fraction = 0;

    bool any() const { return first || second; }
    template <class Value>
    Value operator()(const Value& a, const Value& b) const {
        return first && second ? a + fraction * (b - a) : first ? a : b;
    }
};

/// What arrives at a point through the whole aperture.
struct aperture_mean {
    float surfaces = 0; ///< square of the mean amplitude, one way
    float speckle = 0;  ///< rms of the amplitude's convolution with itself, over that of 1
    float shown = 0;    ///< displayed depth, metres
    bool any = false;   ///< some line arrives
};

/// Combines what arrives along the turned lines at all points of one step of one plane. Keeps its memory.
class aperture_average {
  public:
    static constexpr std::uint32_t max_directions = 64;

    /// @param row      number of the step in all planes
    /// @param place    place(point): what the point lies in; only sound that arrives in the same counts
    /// @param means    one for each point
    template <class Place>
    void compute(const shading_points& points, view<const turned_lines> directions, std::size_t row, const Place& place,
                 view<aperture_mean> means) {
        const std::size_t count = directions.size();
        const std::size_t padded = (std::size_t{points.size()} + simd_width - 1) / simd_width * simd_width;
        // What arrives along each direction, then the share of the last, then what arrives times its displayed depth.
        weighted_.assign((2 * count + 1) * padded, 0);
        float *const weights = weighted_.data() + count * padded, *const depths = weights + count * padded;
        for (std::size_t k = 0; k < count; ++k)
            weigh(points, directions[k], row, place, weighted_.data() + k * padded, weights + k * padded, depths);
        for (std::uint32_t first = 0; first < points.size(); first += simd_width) {
            const received sound = receive(weighted_.data() + first, padded, count),
                           all = receive(weights + first, padded, count);
            const floats smallest(FLT_MIN); // divides where there is no line at all
            float mean[simd_width], rms[simd_width], depth[simd_width], whole[simd_width];
            store(load<simd_width>(depths + first) / max(sound.sum, smallest), depth);
            store(sound.sum / max(all.sum, smallest), mean);
            store(sqrt(sound.power / max(all.power, smallest)), rms);
            store(all.sum, whole);
            for (std::uint32_t i = 0; i < simd_width && first + i < points.size(); ++i)
                means[first + i] = {mean[i] * mean[i], rms[i], depth[i], whole[i] > 0};
        }
    }

  private:
    using floats = lanes<simd_width>;

    // What arrives along one direction at each point, times the share of the direction. The line that ends in a point lies
    // between those of two points, neither of which is used where it has left the fan: slices end there.
    template <class Place>
    static void weigh(const shading_points& points, const turned_lines& one, std::size_t row, const Place& place,
                      float* weighted, float* weights, float* depths) {
        const float weight = one.weight(row);
        if (!(weight > 0)) return;
        const auto count = static_cast<std::int64_t>(points.size()), beyond = static_cast<std::int64_t>(points.beyond);
        const sound_at_depth* const sound = one.sound(row);
        const bool same_crossings = points.shape.form != face_shape::form::point; // all cross as many lines
        float back = -one.lines_crossed(row, 0);
        for (std::int64_t point = 0; point < count; ++point) {
            if (!same_crossings) back = -one.lines_crossed(row, static_cast<std::uint32_t>(point + beyond));
            const float whole = std::floor(back), fraction = back - whole;
            std::int64_t from = point + beyond + static_cast<std::int64_t>(whole), next = from + 1;
            bool from_within = true, next_within = true;
            if (points.shape.full_circle) {
                from = (from % count + count) % count;
                next = (from + 1) % count;
            } else {
                const std::int64_t all = count + 2 * beyond;
                from_within = from >= 0 && from < all && (!same_crossings || point > 0 || fraction == 0);
                next_within = next >= 0 && next < all && (!same_crossings || point + 1 < count);
                if (!from_within) from = next;
                if (!next_within) next = from;
                if (!from_within && !next_within) continue;
            }
            const std::uint32_t here = place(static_cast<std::uint32_t>(point));
            const blend_of_two between{from_within && sound[from].place == here,
                                       next_within && sound[next].place == here, fraction};
            if (!between.any()) continue;
            weighted[point] = weight * between(sound[from].amplitude, sound[next].amplitude);
            weights[point] = weight;
            depths[point] += weighted[point] * between(sound[from].shown, sound[next].shown);
        }
    }

    // Sum over the directions, and the sum of the squares of their convolution with themselves.
    struct received {
        floats sum{0.0F}, power{0.0F};
    };
    static received receive(const float* of_first, std::size_t padded, std::size_t count) {
        floats of[max_directions];
        received all;
        for (std::size_t k = 0; k < count; ++k) {
            of[k] = load<simd_width>(of_first + k * padded);
            all.sum = all.sum + of[k];
        }
        for (std::size_t both = 0; both + 1 < 2 * count; ++both) {
            floats together(0.0F);
            std::size_t i = both < count ? 0 : both - count + 1, j = both - i;
            for (; i < j; ++i, --j) together = multiply_add(of[i], of[j], together);
            together = together + together;
            if (i == j) together = multiply_add(of[i], of[i], together);
            all.power = multiply_add(together, together, all.power);
        }
        return all;
    }

    std::vector<float> weighted_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

/// Sound reaches a point from the whole width of the aperture, so shadows have a penumbra: behind a needle it comes past it
/// from both sides, and beside a needle part of it is blocked. Here lines are traced to every point from several places of the
/// aperture, and the `aperture_gains` of its line are computed from what arrives:
///
///     surfaces   mean(a)^2 / T               a^2: amplitude there and back along one of the lines, by the model
///     speckle    rms(a * a) / rms(1 * 1) / T      *: convolution across the aperture
///     depth      mean(a d) / mean(a)         d: displayed depth along one of the lines
///
/// over the aperture |u| < z / 2F; T is the amplitude there and back along the line that is displayed. For an obstacle that
/// lets nothing pass and leaves a fraction A of the aperture free, surfaces take A^2; speckle takes A^1.5 where the free part
/// is in one piece, as beside a shadow's edge, and about A^2 where the obstacle is in its middle. Source: sound that is
/// focused adds by pressure, out and back; the echo power of independent scatterers is the integral of the squared two-way
/// beam, whose spectrum is a * a. Behind a strip 0.72 mm wide, F/2, 7.5 MHz, 5, 10 and 20 mm: -5.7, -2.9, -1.4 dB; a sum of
/// waves has -5.6, -3.0, -1.4 dB.
///
/// A line from the side is given the angle of incidence and the attenuation of the straight line through the same point
/// (`incidence_at`). So plane layers leave the gains at 1, and their echoes have the levels of plane waves.
namespace insonify::inline INSONIFY_ABI::detail {

/// Computes the gains of all lines of a frame. Keeps its memory from frame to frame.
///
/// Lines that lie closer than the beam is wide share what arrives from the side: it is computed at some of them, the points,
/// about as far apart as the beam is wide, and interpolated linearly in between. Only places in one and the same object are
/// interpolated: between two of them there may be a surface that one line has crossed at a depth and its neighbour has not.
/// Two places of one object on either side of a thin tilted sheet pass for the same; the error reaches one step of depth.
class aperture_shading {
  public:
    static constexpr std::uint32_t steps = sound_profile::steps;                      ///< of depth
    static constexpr std::uint32_t max_directions = aperture_average::max_directions; ///< to each point

    /// Takes over the lines of a probe.
    /// @return whether they can be turned or shifted: at equal distances on a plane or round face, or from one point of a
    ///         plane face; lines that are steered from a round one cannot
    template <transducer Probe>
    bool assign(const Probe& probe, const line_fan& fan, const beam_model& beam) {
        const bool circle = is_full_circle(probe);
        if (!points_.shape.assign(fan, circle)) return false;
        lines_ = fan.size();
        const float wide = beam.lateral_width(beam.focus) / line_spacing(probe, beam.focus);
        std::uint32_t stride = static_cast<std::uint32_t>(clamp(wide + 0.5F, 1, 16));
        while (circle && lines_ % stride != 0) --stride; // of a prime number of lines, each is a point
        points_.stride = stride;
        points_.first = circle ? 0 : (lines_ - 1) % stride / 2;
        points_.fan.assign(fan, points_.first, stride);
        points_.beyond = 0;
        if (points_.size() < 2 || !points_.shape.assign(points_.fan, circle)) return false;
        if (is_point()) { // those that reach the edges of the sector from the ends of the aperture
            const float angle = std::asin(min(0.5F / beam.min_fnumber, 0.95F)), spacing = points_.shape.spacing;
            points_.beyond = points_.fan.extend(static_cast<std::uint32_t>(std::ceil(angle / spacing)), spacing);
        }
        return true;
    }

    /// @param directions  in which lines are traced to each point of a single plane; with several planes, each uses a quarter
    ///                    as many, at least 2, interleaved with the others'
    /// @param found   the layers of the lines of the probe, in `scene`
    /// @param slices  that they were found by; null: by rays, as everything else then is
    template <exec::policy Policy, transducer Probe, states_arrivals Model>
    void compute(const Policy& policy, const scene_view& scene, const detail::frame_view<Probe>& frame,
                 const Model& model, std::uint32_t directions, const line_layers& found, const slice_finder* slices) {
        const std::uint32_t points = points_.size();
        points_.planes = frame.planes;
        // To the depth of the picture as if all sound had the display's speed; deeper, the last gain holds.
        spacing_ = frame.depth / steps;
        profiles_.resize(std::size_t{frame.planes} * lines_);
        gains_.resize(profiles_.size() * steps);
        means_.resize(std::size_t{frame.planes} * steps * points);
        if (averages_.size() < std::size_t{frame.planes} * steps) averages_.resize(std::size_t{frame.planes} * steps);
        const std::uint32_t count = frame.planes == 1 ? directions : std::max<std::uint32_t>((directions + 3) / 4, 2);
        if (turned_.size() < count) turned_.resize(count);
        turn_lines(frame, count);
        const view<const turned_lines> turned{turned_.data(), count};

        exec::for_each_block(policy, lines_, lines_per_block, 500, [&](std::size_t begin, std::size_t end) {
            for (auto line = static_cast<std::uint32_t>(begin); line < end; ++line)
                for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
                    traced_line traced = task_of(frame, scene, line, plane).line;
                    traced.layers = found(line, plane);
                    profiles_[std::size_t{plane} * lines_ + line].compute(traced, model, spacing_);
                }
        });
        if (slices != nullptr) sort_segments(slices->segments());
        exec::for_each_block(policy, count, 1, 500 * static_cast<float>(points), [&](std::size_t k, std::size_t) {
            if (slices != nullptr) turned_[k].find_crossings(points_, {segments_, max_elevation_planes});
            for (std::uint32_t plane = 0; plane < frame.planes; ++plane)
                for (std::uint32_t line = 0; line < points_.fan.size(); ++line)
                    if (turned_[k].reaches_points(points_, line, plane))
                        turned_[k].find_sound(
                            task_along(frame, scene, line, plane),
                            found.objects_behind_face(points_.line_of(nearest_point(line)), plane), line, model,
                            spacing_, [&](vec3 direction) { return frame.tilt(direction, plane); }, slices);
        });
        exec::for_each_block(policy, std::size_t{frame.planes} * steps, 1, 3000, [&](std::size_t row, std::size_t) {
            const auto place = [&](std::uint32_t point) {
                return profiles_[row / steps * lines_ + points_.line_of(point)].at[row % steps].place;
            };
            averages_[row].compute(points_, turned, row, place, {means_.data() + row * points, points});
        });
        exec::for_each_block(policy, std::size_t{frame.planes} * lines_, lines_per_block, 100,
                             [&](std::size_t begin, std::size_t end) {
                                 for (std::size_t i = begin; i < end; ++i) compare(i / lines_, i % lines_);
                             });
    }

    /// The lines beyond those of the probe for which slices must be cut: those of a phased array; none for others.
    template <transducer Probe>
    outer_lines beyond(const detail::frame_view<Probe>& frame) const {
        if (!is_point()) return {};
        return {&points_.fan, max_shift(frame)};
    }

    /// The gains of all lines in flat arrays. Trivially copyable.
    struct gains_view {
        view<const aperture_gain> gains{}; ///< by plane, line and step; none: the line alone counts
        std::uint32_t lines = 0;
        float spacing = 1; ///< from step to step, metres

        INSONIFY_FN aperture_gains of_line(std::uint32_t line, std::uint32_t plane) const {
            if (gains.empty()) return {};
            return {{gains.data() + (std::size_t{plane} * lines + line) * steps, steps}, spacing};
        }
    };
    gains_view view_of() const { return {gains_, lines_, spacing_}; }

  private:
    // The largest turn whose line is still received at some depth, within the angles for which depths and places of turned
    // lines are accurate: the tangent on a plane face, at most 0.9 of that of a line along the face, the angle on a round one,
    // the shift along the face of a phased array.
    template <transducer Probe>
    float widest(const detail::frame_view<Probe>& frame) const {
        const float radius = points_.shape.radius, incline = std::fabs(points_.shape.incline);
        if (is_point()) return max_shift(frame);
        float max_turn = 0;
        for (std::uint32_t k = 0; k < steps; ++k) {
            const float z = depth_of(k), half = half_aperture(frame, z);
            if (radius == 0) {
                max_turn = max(max_turn, half / (z - min(incline * half, 0.9F * z)));
            } else {
                const float place = min(half / radius, 0.9F), down = std::sqrt(1 - place * place);
                max_turn = max(max_turn, std::asin(place) + std::atan(radius * place / (z + radius * (1 - down))));
            }
        }
        return min(max_turn, radius == 0 ? min(3, 0.9F / max(incline, 0.1F)) : 1.3F);
    }
    template <transducer Probe>
    static float max_shift(const detail::frame_view<Probe>& frame) {
        return half_aperture(frame, frame.depth);
    }
    std::uint32_t nearest_point(std::uint32_t line) const {
        return line < points_.beyond ? 0 : std::min(line - points_.beyond, points_.size() - 1);
    }
    // A line of the fan in one plane. Those beyond the lines of the probe are like the nearest of these, but for their
    // direction.
    template <transducer Probe>
    line_task task_along(const detail::frame_view<Probe>& frame, const scene_view& scene, std::uint32_t line,
                         std::uint32_t plane) const {
        const std::uint32_t point = nearest_point(line);
        line_task task = task_of(frame, scene, points_.line_of(point), plane);
        if (line == point + points_.beyond) return task;
        const vec2 along = points_.fan[line].along;
        task.line.frame.along = frame.at.direction(points_.fan.upright().direction({along.x, 0, along.y}));
        task.line.frame.tilt = frame.tilt(task.line.frame.along, plane);
        return task;
    }
    template <transducer Probe>
    static float half_aperture(const detail::frame_view<Probe>& frame, float depth) {
        return 0.5F * depth / frame.aperture.fnumber(depth);
    }
    bool is_point() const { return points_.shape.form == face_shape::form::point; }
    float depth_of(std::uint32_t step) const { return static_cast<float>(step + 1) * spacing_; }

    template <transducer Probe>
    void turn_lines(const detail::frame_view<Probe>& frame, std::uint32_t count) {
        const float radius = points_.shape.radius, max_turn = widest(frame);
        const auto turned_by = [&](float part) -> line_turn { // -1 to 1
            if (is_point()) return {.shift = part * max_turn, .is_shift = true};
            const float angle = radius == 0 ? std::atan(part * max_turn) : part * max_turn;
            return {std::sin(angle), std::cos(angle), radius, points_.shape.incline};
        };
        for (std::uint32_t k = 0; k < count; ++k) {
            // Planes to both sides of the slice are shifted to both sides: 0, 1, -1, 2, -2 parts of a cell.
            const auto edge = [&](float i, std::uint32_t plane) {
                const auto pair = static_cast<float>((plane + 1) / 2);
                const float shift = (plane % 2 == 0 ? -pair : pair) / static_cast<float>(frame.planes);
                return 2 * (static_cast<float>(k) + shift + i) / static_cast<float>(count) - 1;
            };
            line_turn turn[max_elevation_planes];
            for (std::uint32_t plane = 0; plane < frame.planes; ++plane) turn[plane] = turned_by(edge(0.5F, plane));
            turned_[k].assign(points_, turn, spacing_);
            for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
                const line_turn left = turned_by(k == 0 ? -1.0F : edge(0, plane)),
                                right = turned_by(k + 1 == count ? 1.0F : edge(1, plane));
                for (std::uint32_t step = 0; step < steps; ++step) {
                    const float z = depth_of(step), half = half_aperture(frame, z);
                    turned_[k].weight(std::size_t{plane} * steps + step) =
                        max(min(right.place_on_face(z), half) - max(left.place_on_face(z), -half), 0);
                }
            }
        }
    }

    void sort_segments(const slice_cut& cut) {
        for (slice_segments& slice : segments_) slice.clear();
        cut.for_each_segment([&](const cut_segment& one) {
            if (!one.again) segments_[one.slice].add(one);
        });
        for (slice_segments& slice : segments_) slice.sort();
    }

    // The gains of one line: what arrives at the nearest points through the aperture, divided by what arrives along the line.
    void compare(std::size_t plane, std::size_t line) {
        const std::uint32_t points = points_.size();
        const float apart =
            (static_cast<float>(line) - static_cast<float>(points_.first)) / static_cast<float>(points_.stride);
        const bool circle = points_.shape.full_circle;
        const float within = circle ? apart : clamp(apart, 0, static_cast<float>(points - 1));
        const auto before = static_cast<std::uint32_t>(within), next = before + 1;
        const std::uint32_t after = next < points ? next : circle ? 0 : before;
        const float fraction = within - static_cast<float>(before);
        const auto profile_of = [&](std::size_t number) -> const sound_profile& {
            return profiles_[plane * lines_ + number];
        };
        const sound_profile &own = profile_of(line), &left = profile_of(points_.line_of(before)),
                            &right = profile_of(points_.line_of(after));
        aperture_gain gain{}; // where no point is of use, that of the step above holds
        float here = 1;       // amplitude along the line alone, there and back
        for (std::uint32_t step = 0; step < steps; ++step) {
            const aperture_mean* const row = means_.data() + (plane * steps + step) * points;
            const std::uint32_t place = own.at[step].place;
            const aperture_mean &a = row[before], &b = row[after];
            const blend_of_two between{a.any && left.at[step].place == place, b.any && right.at[step].place == place,
                                       fraction};
            const float above = here;
            here = own.at[step].amplitude * own.at[step].amplitude;
            if (between.any())
                gain = {between(a.surfaces, b.surfaces) / here, between(a.speckle, b.speckle) / here,
                        between(a.shown, b.shown) - own.at[step].shown};
            else
                gain = limited(gain, above / here);
            gains_[(plane * lines_ + line) * steps + step] = gain;
        }
    }

    // The gain of the step above, where that has `more` times the amplitude along the line alone: no more sound arrives than
    // there, unless the line itself brings it.
    static aperture_gain limited(const aperture_gain& above, float more) {
        return {min(above.surfaces, max(above.surfaces * more, 1)), min(above.speckle, max(above.speckle * more, 1)),
                above.deeper};
    }

    std::uint32_t lines_ = 0;
    float spacing_ = 1;
    shading_points points_{};
    std::vector<sound_profile> profiles_{}; // each line by itself, by plane and line
    slice_segments segments_[max_elevation_planes] = {};
    std::vector<turned_lines> turned_{};
    std::vector<aperture_average> averages_{}; // one for each plane and step
    std::vector<aperture_mean> means_{};       // by plane, step and point
    std::vector<aperture_gain> gains_{};       // by plane, line and step
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
