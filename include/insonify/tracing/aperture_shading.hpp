#ifndef INSONIFY_TRACING_APERTURE_SHADING_HPP
#define INSONIFY_TRACING_APERTURE_SHADING_HPP

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/tracing/scratch_memory.hpp>
#include <insonify/tracing/slice_finder.hpp>
#include <insonify/tracing/trace_line.hpp>
#include <insonify/tracing/turned_fan.hpp>
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <vector>

/// Sound reaches a point from the whole width of the aperture, so shadows have a penumbra: behind a needle it comes past it
/// from both sides, and beside one some of it is kept away. Here lines are traced to every point from several places of the
/// aperture, and the `aperture_gains` of its line are computed from what arrives:
///
///     surfaces   mean(a)^2 / T              a^2: amplitude there and back along one of the lines, by the model; T: the same
///     speckle    rms(a * a) / rms(1 * 1) / T     along the line that is displayed; *: convolution across the aperture
///     depth      mean(a d) / mean(a)             d: displayed depth along one of the lines
///
/// over the aperture |u| < z / 2F. For an obstacle that lets nothing pass and leaves a share A of the aperture free, surfaces
/// take A^2; speckle takes A^1.5 where the free part is in one piece, as beside a shadow's edge, and about A^2 where the
/// obstacle is in its middle. Source: sound that is focused adds by pressure, out and back; the echo power of independent
/// scatterers is the integral of the squared two-way beam, whose spectrum is a * a. Behind a strip 0.72 mm wide, F/2, 7.5 MHz,
/// 5, 10 and 20 mm: -5.7, -2.9, -1.4 dB; a sum of waves has -5.6, -3.0, -1.4 dB.
///
/// A line from the side meets surfaces at the angle at which the straight line through the same point does (`incidence_at`), and loses as
/// much by attenuation. So plane layers leave the gains at 1, and their echoes have the levels of plane waves.
namespace insonify::inline INSONIFY_ABI::detail {

/// A model from which gains can be computed: see `physical::arrivals`.
template <class Model>
concept states_arrivals = requires(const Model& model, const traced_line& line, view<vec2> out) {
    model.arrivals(line, 1.0F, out);
};

/// Computes the gains of all lines of a frame. Keeps its memory from frame to frame.
///
/// Lines that lie closer than the beam is wide share what arrives from the side: it is computed at some of them, the points,
/// and interpolated linearly in between. Only places in one and the same object are interpolated: between two of them there
/// may be a surface that one line has crossed at a depth and its neighbour has not.
class aperture_shading {
  public:
    static constexpr std::uint32_t steps = 64;          ///< of depth
    static constexpr std::uint32_t max_directions = 64; ///< to each point

    /// Takes over the lines of a probe.
    /// @return whether they can be turned: side by side at equal distances on a plane or round face
    template <transducer Probe>
    bool assign(const Probe& probe, const line_fan& fan, const beam_model& beam) {
        const bool circle = is_full_circle(probe);
        if (!shape_.assign(fan, circle)) return false;
        lines_ = fan.size();
        const float wide = beam.lateral_width(beam.focus) / line_spacing(probe, beam.focus);
        stride_ = static_cast<std::uint32_t>(clamp(wide, 1, 16));
        while (circle && lines_ % stride_ != 0) --stride_;
        first_ = circle ? 0 : (lines_ - 1) % stride_ / 2;
        points_fan_.assign(fan, first_, stride_);
        return points_fan_.size() > 1 && shape_.assign(points_fan_, circle);
    }

    /// @param directions  of the lines to each point of a single plane; of several planes each takes a quarter of them, in
    ///                    between those of the others
    /// @param slices      with the lines of the probe
    /// @param sliced      whether these have been cut; else everything is found by rays
    /// @param tracer_of   tracer_of(line): the `block_tracer` of the line's block
    template <exec::policy Policy, transducer Probe, states_arrivals Model, class TracerOf>
    void compute(const Policy& policy, const scene_view& scene, const frame_view<Probe>& frame, const Model& model,
                 std::uint32_t directions, const slice_finder& slices, bool sliced, const TracerOf& tracer_of,
                 view<scratch_memory> scratch) {
        const std::uint32_t points = points_fan_.size();
        planes_ = frame.planes;
        spacing_ = frame.max_depth / steps;
        along_.resize(std::size_t{planes_} * lines_);
        gains_.resize(along_.size() * steps);
        objects_.resize(std::size_t{planes_} * points);
        means_.resize(std::size_t{planes_} * steps * points);
        weighted_.resize(std::size_t{planes_} * steps);
        directions_.resize(planes_ == 1 ? directions : std::max<std::uint32_t>((directions + 3) / 4, 2));
        turn_lines(frame);

        exec::for_each_block(policy, lines_, lines_per_block, 500, [&](std::size_t begin, std::size_t end) {
            const auto tracer = tracer_of(begin);
            for (std::uint32_t plane = 0; plane < planes_; ++plane)
                for (std::size_t line = begin; line < end; ++line)
                    scratch[begin / lines_per_block].fit([&](line_scratch& room) {
                        const line_task task = task_of(frame, scene, static_cast<std::uint32_t>(line), plane);
                        if (!tracer.find(task, room.found)) return false;
                        if (line >= first_ && (line - first_) % stride_ == 0) {
                            const media_stack& inside = room.found.inside;
                            objects_[std::size_t{plane} * points + (line - first_) / stride_].assign(
                                inside.ranks.data(), inside.ranks.data() + inside.count);
                        }
                        return find_arrivals(task, task.line.frame, model, room,
                                             along_[std::size_t{plane} * lines_ + line]);
                    });
        });
        if (sliced) sort_segments(slices.segments());
        exec::for_each_block(
            policy, directions_.size(), 1, 500 * static_cast<float>(points), [&](std::size_t k, std::size_t) {
                direction& own = directions_[k];
                if (sliced) find_crossings_of(own);
                for (std::uint32_t plane = 0; plane < planes_; ++plane)
                    for (std::uint32_t point = 0; point < points; ++point)
                        own.scratch.fit([&](line_scratch& room) {
                            const line_task task = task_of(frame, scene, first_ + point * stride_, plane);
                            turned_line turned{task.line.frame, own.fans[plane].turn()};
                            turned.tilt = frame.tilt(turned.direction(), plane);
                            arrivals found;
                            if (!find(task, turned, own, std::size_t{plane} * points + point,
                                      sliced ? &slices : nullptr, room.found) ||
                                !find_arrivals(task, turned, model, room, found))
                                return false;
                            for (std::uint32_t step = 0; step < steps; ++step)
                                own.arriving[(std::size_t{plane} * steps + step) * points + point] = found[step];
                            return true;
                        });
            });
        exec::for_each_block(policy, std::size_t{planes_} * steps, 1, 3000,
                             [&](std::size_t row, std::size_t) { combine(row); });
        exec::for_each_block(policy, std::size_t{planes_} * lines_, lines_per_block, 100,
                             [&](std::size_t begin, std::size_t end) {
                                 for (std::size_t i = begin; i < end; ++i) compare(i / lines_, i % lines_);
                             });
    }

    /// The gains of all lines in flat arrays. Trivially copyable.
    struct gains_view {
        view<const aperture_gain> gains{}; ///< by plane, line and step; none: lines stand for the aperture
        std::uint32_t lines = 0;
        float spacing = 1; ///< from step to step, metres

        INSONIFY_FN aperture_gains of_line(std::uint32_t line, std::uint32_t plane) const {
            if (gains.empty()) return {};
            return {{gains.data() + (std::size_t{plane} * lines + line) * steps, steps}, spacing};
        }
    };
    gains_view view_of() const { return {gains_, lines_, spacing_}; }

  private:
    using floats = lanes<simd_width>;

    // The amplitude at a step of a line, one way, its displayed depth, and what it lies in.
    struct arrival {
        float amplitude = 0;
        float shown = 0;
        std::uint32_t place = 0; // see `layer::place`
    };
    using arrivals = std::array<arrival, steps>;

    struct deep_segment {
        float depth = 0; // the sum of its ends'
        const cut_segment* segment = nullptr;
    };
    // The lines [first, last) cross a segment.
    struct crossed_segment {
        const cut_segment* segment = nullptr;
        std::uint32_t first = 0, last = 0;
    };

    // Lines that are turned alike, in each plane by an angle of its own, and what arrives along them.
    struct direction {
        turned_fan fans[max_elevation_planes] = {};
        std::vector<crossed_segment> crossed{};
        std::vector<std::uint32_t> ends{};  // of each plane and line, in `crossings`
        std::vector<crossing> crossings{};  // at metres along the turned line
        std::vector<arrival> arriving{};    // by plane, step and line
        std::vector<float> share{};         // of the aperture, by plane and step
        std::vector<float> lines_crossed{}; // by plane and step
        scratch_memory scratch{};
    };

    // The largest turn whose line is still received at some depth: the tangent on a plane face, the angle on a round one.
    template <transducer Probe>
    float widest(const frame_view<Probe>& frame) const {
        float most = 0;
        for (std::uint32_t k = 0; k < steps; ++k) {
            const float z = depth_of(k), half = half_aperture(frame, z);
            if (shape_.radius == 0) {
                most = max(most, half / z);
            } else {
                const float place = min(half / shape_.radius, 0.9F), down = std::sqrt(1 - place * place);
                most =
                    max(most, std::asin(place) + std::atan(shape_.radius * place / (z + shape_.radius * (1 - down))));
            }
        }
        return min(most, shape_.radius == 0 ? 3.0F : 1.3F);
    }
    template <transducer Probe>
    static float half_aperture(const frame_view<Probe>& frame, float depth) {
        return 0.5F * depth / frame.aperture.fnumber(depth);
    }
    float depth_of(std::uint32_t step) const { return static_cast<float>(step + 1) * spacing_; }

    template <transducer Probe>
    void turn_lines(const frame_view<Probe>& frame) {
        const float most = widest(frame);
        const auto turned_by = [&](float part) -> line_turn { // -1 to 1
            const float angle = shape_.radius == 0 ? std::atan(part * most) : part * most;
            return {std::sin(angle), std::cos(angle), shape_.radius};
        };
        const auto count = static_cast<float>(directions_.size());
        for (std::size_t k = 0; k < directions_.size(); ++k) {
            direction& own = directions_[k];
            own.arriving.resize(means_.size());
            own.share.resize(std::size_t{planes_} * steps);
            own.lines_crossed.resize(std::size_t{planes_} * steps);
            for (std::uint32_t plane = 0; plane < planes_; ++plane) {
                // Planes to both sides of the slice are shifted to both sides: 0, 1, -1, 2, -2 parts of a cell.
                const auto pair = static_cast<float>((plane + 1) / 2);
                const float shift = (plane % 2 == 0 ? -pair : pair) / static_cast<float>(planes_);
                const auto edge = [&](float i) { return 2 * (static_cast<float>(k) + shift + i) / count - 1; };
                turned_fan& fan = own.fans[plane];
                fan.assign(points_fan_, shape_, turned_by(edge(0.5F)));
                const line_turn left = turned_by(k == 0 ? -1.0F : edge(0)),
                                right = turned_by(k + 1 == directions_.size() ? 1.0F : edge(1));
                for (std::uint32_t step = 0; step < steps; ++step) {
                    const float z = depth_of(step), half = half_aperture(frame, z);
                    own.share[plane * steps + step] =
                        max(min(right.place_on_face(z), half) - max(left.place_on_face(z), -half), 0);
                    own.lines_crossed[plane * steps + step] = fan.lines_crossed(z);
                }
            }
        }
    }

    // By depth, so that the crossings of each line are nearly sorted.
    void sort_segments(const slice_cut& cut) {
        segments_.clear();
        cut.for_each_segment([&](const cut_segment& one) {
            if (!one.again) segments_.push_back({one.from.y + one.to.y, &one});
        });
        std::sort(segments_.begin(), segments_.end(),
                  [](const deep_segment& one, const deep_segment& other) { return one.depth < other.depth; });
    }

    // Where the turned lines cross the segments of the slices.
    void find_crossings_of(direction& own) const {
        constexpr int width = simd_width;
        const std::uint32_t points = points_fan_.size();
        own.ends.assign(std::size_t{planes_} * points + 1, 0);
        own.crossed.clear();
        for (const deep_segment& deep : segments_) {
            const cut_segment& one = *deep.segment;
            const turned_fan& fan = own.fans[one.slice];
            const vec2 from = fan.straightened(one.from), to = fan.straightened(one.to);
            points_fan_.for_each_crossed(
                from, points_fan_.gap(from), to, points_fan_.gap(to), [&](std::uint32_t first, std::uint32_t last) {
                    own.crossed.push_back({&one, first, last});
                    std::uint32_t* const count = own.ends.data() + std::size_t{one.slice} * points + 1;
                    for (std::uint32_t line = first; line < last; ++line) ++count[line];
                });
        }
        for (std::size_t slot = 0; slot < std::size_t{planes_} * points; ++slot) own.ends[slot + 1] += own.ends[slot];
        own.crossings.resize(own.ends.back());
        for (const crossed_segment& crossed : own.crossed) {
            const cut_segment& one = *crossed.segment;
            std::uint32_t* const end = own.ends.data() + std::size_t{one.slice} * points;
            for (std::uint32_t line = crossed.first; line < crossed.last; line += width) {
                float distance[width];
                store(line_fan::neighbours<width>::from(own.fans[one.slice].lines(), line).intersect(one.from, one.to),
                      distance);
                for (std::uint32_t i = line; i < crossed.last && i < line + width; ++i)
                    own.crossings[end[i]++] = {distance[i - line], one.object, one.primitive};
            }
        }
    }

    // The crossings of one turned line, at the depths of their points.
    // @param slot    number of the line in all planes
    // @param slices  null where everything is found by rays
    bool find(const line_task& task, const turned_line& turned, const direction& own, std::size_t slot,
              const slice_finder* slices, line_crossings& found) const {
        found.clear();
        const line_turn& turn = turned.turn;
        const auto add = [&](crossing one) {
            one.distance = turn.depth_at(one.distance);
            if (one.distance <= task.max_depth) found.add(one);
        };
        for (const std::uint32_t rank : objects_[slot]) found.inside.toggle(rank);
        if (slices != nullptr)
            for (std::size_t i = slot == 0 ? 0 : own.ends[slot - 1]; i < own.ends[slot]; ++i)
                if (own.crossings[i].distance >= 0) add(own.crossings[i]);
        if (slices == nullptr || slices->leaves_rays()) {
            const ray line{turned.straight.origin, turned.frame().path(), 0, turn.length_to(task.max_depth)};
            task.scene.boxes.for_each_hit(line, [&](const hit& at) {
                if (slices != nullptr && slices->chosen()[at.primitive] != 0) return;
                const object_view& one = task.scene.objects[at.primitive];
                one.tree.for_each_hit(one.local(line), [&](const hit& h) {
                    add({h.distance, at.primitive, h.primitive});
                });
            });
        }
        found.sort();
        return found.complete();
    }

    // What arrives along one line at each step, one way.
    template <class Line, class Model>
    static bool find_arrivals(const line_task& task, const Line& line, const Model& model, line_scratch& room,
                              arrivals& found) {
        traced_line traced = task.line;
        traced.layers =
            stack_layers(task.scene, line, task.max_depth, room.found, room.layers, !takes_normal_incidence<Model>());
        if (traced.layers.empty()) return false;
        vec2 both_ways[steps];
        const float spacing = task.max_depth / steps;
        model.arrivals(traced, spacing, view<vec2>{both_ways, steps});
        std::size_t i = 0;
        for (std::uint32_t k = 0; k < steps; ++k) {
            while (i + 1 < traced.layers.size() && traced.layers[i].end <= static_cast<float>(k + 1) * spacing) ++i;
            found[k] = {std::sqrt(max(both_ways[k].x, aperture_gains::least)), both_ways[k].y, traced.layers[i].place};
        }
        return true;
    }

    // What arrives at all points of one step of one plane through the whole aperture.
    void combine(std::size_t row) {
        const std::uint32_t points = points_fan_.size();
        const std::size_t count = directions_.size();
        const std::size_t padded = (std::size_t{points} + simd_width - 1) / simd_width * simd_width;
        // What arrives, then the share itself where there is a line, then what arrives times its displayed depth.
        std::vector<float>& weighted = weighted_[row];
        weighted.assign((2 * count + 1) * padded, 0);
        float *const shares = weighted.data() + count * padded, *const depths = shares + count * padded;
        for (std::size_t k = 0; k < count; ++k)
            weigh(directions_[k], row, weighted.data() + k * padded, shares + k * padded, depths);
        for (std::uint32_t first = 0; first < points; first += simd_width) {
            const received sound = receive(weighted.data() + first, padded), all = receive(shares + first, padded);
            const floats least(FLT_MIN); // divides where there is no line at all
            float mean[simd_width], rms[simd_width], depth[simd_width];
            store(load<simd_width>(depths + first) / max(sound.sum, least), depth);
            store(select(all.sum <= floats(0.0F), floats(-1.0F), sound.sum / max(all.sum, least)), mean);
            store(sqrt(sound.power / max(all.power, least)), rms);
            for (std::uint32_t i = 0; i < simd_width && first + i < points; ++i)
                means_[row * points + first + i] = {mean[i] * std::fabs(mean[i]), rms[i], depth[i]};
        }
    }

    // What arrives along one direction at each point, times the share of the direction.
    void weigh(const direction& one, std::size_t row, float* weighted, float* shares, float* depths) const {
        const std::size_t plane = row / steps, step = row % steps;
        const float share = one.share[row];
        if (!(share > 0)) return;
        const auto count = static_cast<std::int64_t>(points_fan_.size());
        const arrival* const arriving = one.arriving.data() + row * points_fan_.size();
        const float back = -one.lines_crossed[row], whole = std::floor(back), fraction = back - whole;
        const auto offset = static_cast<std::int64_t>(whole);
        for (std::int64_t point = 0; point < count; ++point) {
            std::int64_t from = point + offset, next = from + 1;
            if (shape_.full_circle) {
                from = (from % count + count) % count;
                next = (from + 1) % count;
            } else if (from < 0 || next >= count) {
                continue;
            }
            const std::uint32_t place = along_of(plane, first_ + static_cast<std::size_t>(point) * stride_)[step].place;
            const blend between{arriving[from].place == place, arriving[next].place == place, fraction};
            if (!between.any()) continue;
            weighted[point] = share * between(arriving[from].amplitude, arriving[next].amplitude);
            shares[point] = share;
            depths[point] += weighted[point] * between(arriving[from].shown, arriving[next].shown);
        }
    }

    // Interpolates linearly between two values, either of which may be unusable.
    struct blend {
        bool first = true, second = true;
        float fraction = 0;

        bool any() const { return first || second; }
        template <class Value>
        Value operator()(const Value& a, const Value& b) const {
            return first && second ? a + fraction * (b - a) : first ? a : b;
        }
    };

    const arrivals& along_of(std::size_t plane, std::size_t line) const { return along_[plane * lines_ + line]; }

    // Sum over the directions, and the sum of the squares of their convolution with themselves.
    struct received {
        floats sum{0.0F}, power{0.0F};
    };
    received receive(const float* of_first, std::size_t padded) const {
        const std::size_t count = directions_.size();
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

    // The gains of one line: what arrives at the nearest points through the aperture over what arrives along the line.
    void compare(std::size_t plane, std::size_t line) {
        const std::uint32_t points = points_fan_.size();
        const float apart = (static_cast<float>(line) - static_cast<float>(first_)) / static_cast<float>(stride_);
        const float within = shape_.full_circle ? apart : clamp(apart, 0, static_cast<float>(points - 1));
        const auto before = static_cast<std::uint32_t>(within), next = before + 1;
        const std::uint32_t after = next < points ? next : shape_.full_circle ? 0 : before;
        const float fraction = within - static_cast<float>(before);
        const arrivals &own = along_of(plane, line), &left = along_of(plane, first_ + before * stride_),
                       &right = along_of(plane, first_ + after * stride_);
        aperture_gain gain{}; // where no point is of use, that of the step above holds
        for (std::uint32_t step = 0; step < steps; ++step) {
            const vec3* const row = means_.data() + (plane * steps + step) * points;
            const std::uint32_t place = own[step].place;
            const blend between{row[before].x >= 0 && left[step].place == place,
                                row[after].x >= 0 && right[step].place == place, fraction};
            if (between.any()) {
                const vec3 mean = between(row[before], row[after]);
                const float here = own[step].amplitude * own[step].amplitude;
                gain = {mean.x / here, mean.y / here, mean.z - own[step].shown};
            }
            gains_[(plane * lines_ + line) * steps + step] = gain;
        }
    }

    face_shape shape_{}; // of the points
    line_fan points_fan_{};
    std::uint32_t lines_ = 0, first_ = 0, stride_ = 1;
    std::uint32_t planes_ = 1;
    float spacing_ = 1;
    std::vector<std::vector<std::uint32_t>> objects_{}; // that contain the origins, by plane and point
    std::vector<arrivals> along_{};                     // each line by itself, by plane and line
    std::vector<deep_segment> segments_{};
    std::vector<direction> directions_{};
    std::vector<std::vector<float>> weighted_{};
    std::vector<vec3> means_{}; // for surfaces, for speckle, and displayed depth, by plane, step and point; x < 0: none
    std::vector<aperture_gain> gains_{}; // by plane, line and step
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
