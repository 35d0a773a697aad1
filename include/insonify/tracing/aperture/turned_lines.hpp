#ifndef INSONIFY_TRACING_APERTURE_TURNED_LINES_HPP
#define INSONIFY_TRACING_APERTURE_TURNED_LINES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/aperture/slice_segments.hpp>
#include <insonify/tracing/aperture/sound_profile.hpp>
#include <insonify/tracing/aperture/turned_fan.hpp>
#include <insonify/tracing/emit/trace_line.hpp>
#include <insonify/tracing/find/line_memory.hpp>
#include <insonify/tracing/find/slice_finder.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The points of an aperture shading: lines of the probe, equally far apart, in each plane of the frame. They are reached by the
/// lines of a fan, turned or shifted: those of the points, and of a phased array, whose aperture is as wide at the edges of its
/// sector, also some beyond.
struct shading_points {
    line_fan fan{};
    face_shape shape{};
    std::uint32_t beyond = 0; ///< lines of the fan on either side of those of the points
    std::uint32_t first = 0;  ///< line of the probe
    std::uint32_t stride = 1;
    std::uint32_t planes = 1;

    std::uint32_t size() const { return fan.size() - 2 * beyond; }
    std::uint32_t line_of(std::uint32_t point) const { return first + point * stride; }
};

/// The lines of all points turned or shifted alike, in each plane by an amount of its own, and what arrives along them. Keeps
/// its memory from frame to frame.
class turned_lines {
  public:
    static constexpr std::uint32_t steps = sound_profile::steps;

    /// @param turn     of the lines in each plane
    /// @param spacing  from step to step, metres
    void assign(const shading_points& points, const line_turn (&turn)[max_elevation_planes], float spacing) {
        lines_ = points.fan.size();
        spacing_ = spacing;
        sound_.resize(std::size_t{points.planes} * steps * lines_);
        share_.resize(std::size_t{points.planes} * steps);
        for (std::uint32_t plane = 0; plane < points.planes; ++plane)
            fans_[plane].assign(points.fan, points.shape, turn[plane]);
    }

    /// Share of the aperture that the lines stand for, at one step of one plane.
    float& share(std::size_t row) { return share_[row]; }
    float share(std::size_t row) const { return share_[row]; }
    /// How many lines the one that ends in a line of the fan has crossed on its way to one step of one plane.
    float lines_crossed(std::size_t row, std::uint32_t line) const {
        return fans_[row / steps].lines_crossed(static_cast<float>(row % steps + 1) * spacing_, line);
    }
    /// What arrives at one step of one plane, by line.
    const sound_at_depth* sound(std::size_t row) const { return sound_.data() + row * lines_; }

    /// Finds where the lines cross the segments of the slices.
    /// @param slices  of each plane, sorted, so that the crossings of each line nearly are
    void find_crossings(const shading_points& points, view<const slice_segments> slices) {
        constexpr int width = simd_width;
        ends_.assign(std::size_t{points.planes} * lines_ + 1, 0);
        crossed_.clear();
        for (std::uint32_t plane = 0; plane < points.planes; ++plane)
            find_crossed(points.fan, fans_[plane], slices[plane], ends_.data() + std::size_t{plane} * lines_ + 1);
        for (std::size_t slot = 0; slot + 1 < ends_.size(); ++slot) ends_[slot + 1] += ends_[slot];
        crossings_.resize(ends_.back());
        // The end of each line's predecessor is where its own crossings begin; it moves on to its own end as they come in.
        for (const crossed_segment& crossed : crossed_) {
            const cut_segment& one = *crossed.segment;
            std::uint32_t* const end = ends_.data() + std::size_t{one.slice} * lines_;
            for (std::uint32_t line = crossed.first; line < crossed.last; line += width) {
                float distance[width];
                store(fans_[one.slice].from(line).intersect(one.from, one.to), distance);
                for (std::uint32_t i = line; i < crossed.last && i < line + width; ++i)
                    crossings_[end[i]++] = {distance[i - line], one.object, one.primitive};
            }
        }
    }

    /// Whether a line of the fan reaches any point: those beyond the points on the right do not where it is shifted to the right.
    bool reaches_points(const shading_points& points, std::uint32_t line, std::uint32_t plane) const {
        return fans_[plane].turn(line).shift > 0 ? line < points.beyond + points.size() : line >= points.beyond;
    }

    /// Finds what arrives along one line of the fan in one plane.
    /// @param task     of that line, neither turned nor shifted
    /// @param tilt_of  tilt_of(direction): that of a line in the task's plane, see `line_frame::tilt`
    /// @param objects  that contain the origin of the point's line, behind the face
    /// @param slices   whose crossings were found; null where everything is found by rays
    template <class Model, class TiltOf>
    void find_sound(const line_task& task, view<const std::uint32_t> objects, std::uint32_t line, const Model& model,
                    float spacing, const TiltOf& tilt_of, const slice_finder* slices) {
        const line_turn turn = fans_[task.plane].turn(line);
        const turned_line turned{task.line.frame, turn, tilt_of(turned_line{task.line.frame, turn}.direction())};
        traced_line heard = task.line;
        for (;; memory_.grow()) {
            line_crossings found = memory_.found();
            if (!find_line(task, turned, objects, line, slices, found)) continue;
            heard.layers = stack_layers(task.scene, turned, task.max_depth, found, view<layer>{memory_.layers},
                                        !takes_normal_incidence<Model>());
            if (!heard.layers.empty()) break;
        }
        sound_profile profile;
        profile.compute(heard, model, spacing);
        for (std::uint32_t step = 0; step < steps; ++step)
            sound_[(std::size_t{task.plane} * steps + step) * lines_ + line] = profile.at[step];
    }

  private:
    // The lines [first, last) cross a segment.
    struct crossed_segment {
        const cut_segment* segment = nullptr;
        std::uint32_t first = 0, last = 0;
    };

    // Adds the lines that cross each segment to `crossed_`, and to the number of crossings of each line.
    void find_crossed(const line_fan& straight, const turned_fan& turned, const slice_segments& segments,
                      std::uint32_t* counts) {
        constexpr int width = simd_width;
        for (std::size_t begin = 0; begin < segments.size(); begin += width) {
            const point_lanes from = segments.from(begin), to = segments.to(begin);
            const point_lanes first = turned.straightened(from), last = turned.straightened(to);
            const auto places_first = straight.places_of<width>(first.x, first.y),
                       places_last = straight.places_of<width>(last.x, last.y);
            const std::uint32_t divided = turned.divided(from, to);
            float ends[4][width];
            store(first.x, ends[0]), store(first.y, ends[1]), store(last.x, ends[2]), store(last.y, ends[3]);
            const std::size_t end = std::min<std::size_t>(width, segments.size() - begin);
            for (std::uint32_t i = 0; i < end; ++i) {
                const cut_segment& one = segments[begin + i];
                const vec2 p{ends[0][i], ends[1][i]}, q{ends[2][i], ends[3][i]};
                const std::uint32_t gap_p = straight.gap(places_first, i), gap_q = straight.gap(places_last, i);
                const auto add = [&](std::uint32_t from_line, std::uint32_t to_line) {
                    crossed_.push_back({&one, from_line, to_line});
                    for (std::uint32_t line = from_line; line < to_line; ++line) ++counts[line];
                };
                if ((divided >> i & 1U) == 0) {
                    straight.for_each_crossed(p, gap_p, q, gap_q, add);
                    continue;
                }
                turned.for_each_outer_part(one.from, one.to, [&](vec2 a, vec2 b) {
                    const vec2 a_moved = a == one.from ? p : turned.straightened(a),
                               b_moved = b == one.to ? q : turned.straightened(b);
                    straight.for_each_crossed(a_moved, a == one.from ? gap_p : straight.gap(a_moved), b_moved,
                                              b == one.to ? gap_q : straight.gap(b_moved), add);
                });
            }
        }
    }

    // The crossings of one line, at the depths of their points. A turned line begins where that of the point does, in the same
    // objects; a shifted one begins in the objects whose surfaces it crosses an odd number of times.
    bool find_line(const line_task& task, const turned_line& turned, view<const std::uint32_t> objects,
                   std::uint32_t number, const slice_finder* slices, line_crossings& found) const {
        const bool shifted = turned.turn.is_shift;
        const crossing_collector collector{
            task.scene,
            {turned.origin(), turned.frame().path(), 0, turned.turn.length_to(task.max_depth)},
            task.max_depth,
            found};
        if (!shifted)
            for (const std::uint32_t rank : objects) found.inside.toggle(rank);
        const auto add = [&](crossing one) {
            one.distance = turned.turn.depth_at(one.distance);
            if (shifted)
                collector.add(one);
            else if (one.distance > touching_distance && one.distance <= task.max_depth)
                found.add(one);
        };
        const std::size_t slot = std::size_t{task.plane} * lines_ + number;
        if (slices != nullptr)
            for (std::size_t i = slot == 0 ? 0 : ends_[slot - 1]; i < ends_[slot]; ++i)
                if (crossings_[i].distance >= 0) add(crossings_[i]);
        if (slices == nullptr || slices->leaves_rays())
            collector.trace(slices != nullptr ? slices->chosen() : view<const std::uint8_t>{}, add);
        found.sort();
        return found.complete();
    }

    std::uint32_t lines_ = 0; // of the fan
    float spacing_ = 1;       // from step to step, metres
    turned_fan fans_[max_elevation_planes] = {};
    std::vector<crossed_segment> crossed_{};
    std::vector<std::uint32_t> ends_{};   // of each plane and line, in `crossings_`
    std::vector<crossing> crossings_{};   // at metres along the turned line
    std::vector<sound_at_depth> sound_{}; // by plane, step and line
    std::vector<float> share_{};          // by plane and step
    line_memory memory_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
