#ifndef INSONIFY_TRACING_APERTURE_TURNED_LINES_HPP
#define INSONIFY_TRACING_APERTURE_TURNED_LINES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/tracing/emit/trace_line.hpp>
#include <insonify/tracing/find/layer_finder.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <insonify/tracing/find/slice_finder.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

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

/// Where the lines of a fan begin and how they diverge, where neighbours are equally far apart.
struct face_shape {
    enum class form {
        plane,  ///< parallel lines from a plane face, at right angles to it or steered
        circle, ///< lines that leave a circle around the apex along its radii
        point,  ///< lines that leave one point, steered by a plane face along the probe's x
    };
    enum form form = form::plane;
    float radius = 0;  ///< of the circle, metres; else 0
    float incline = 0; ///< of the face under parallel lines: change of y per x, 0 unless they are steered
    float spacing = 0; ///< from line to line: metres, or radians around the apex
    vec2 across{1, 0}; ///< along the plane face, in the coordinates of the fan
    std::uint32_t lines = 0;
    bool full_circle = false; ///< the last line is next to the first

    /// @return whether the lines are of this kind
    bool assign(const line_fan& fan, bool circle) {
        lines = fan.size();
        full_circle = circle;
        if (lines < 2) return false;
        const auto place = [&](std::uint32_t i) {
            return fan.parallel() ? fan[i].origin.x : std::atan2(fan[i].along.x, fan[i].along.y);
        };
        const std::uint32_t middle = (lines - 1) / 2;
        spacing =
            circle ? 2 * pi / static_cast<float>(lines) : (place(lines - 1) - place(0)) / static_cast<float>(lines - 1);
        radius = fan.parallel() ? 0.0F : length(fan[middle].origin);
        form = fan.parallel() ? form::plane : radius > 1e-4F ? form::circle : form::point;
        const pose upright = fan.upright();
        across = {upright.rotation[0].x, upright.rotation[2].x};
        if (!(spacing > 0) || (form == form::point && (circle || !fan.is_wedge()))) return false;
        const vec2 face_line = fan[lines - 1].origin - fan[0].origin;
        incline = fan.parallel() ? face_line.y / face_line.x : 0.0F;
        for (std::uint32_t i = 0; i < lines; ++i) {
            const vec2 along_face = fan[i].origin - fan[middle].origin;
            const float face = fan.parallel() ? along_face.y - incline * along_face.x : length(fan[i].origin) - radius;
            const float expected = place(middle) + (static_cast<float>(i) - static_cast<float>(middle)) * spacing;
            if (std::fabs(face) > 1e-6F || std::fabs(place(i) - expected) > 0.05F * spacing) return false;
        }
        if (form == form::point) radius = 0;
        return true;
    }
};

/// How a line reaches the points of other lines through the aperture. On a plane or round face it is turned about its origin in the
/// slice plane, to the right. A line from the point of a phased array is shifted along the face instead. Such a line is measured by
/// the depth that it reaches: that of the line of the probe which ends in the same point.
struct line_turn {
    float sine = 0; ///< of the angle by which it is turned; of a shifted line, of its angle with the normal of the face
    float cosine = 1;
    float radius = 0;  ///< see `face_shape`
    float incline = 0; ///< see `face_shape`
    float shift = 0;   ///< metres along the face
    bool is_shift = false;

    /// Metres along a line to a depth.
    INSONIFY_FN float length_to(float depth) const {
        if (is_shift) {
            const float end = max(depth, distance(near_face()));
            const float length = std::sqrt(max(end * end - shift * shift * cosine * cosine, 0)) - shift * sine;
            return depth < end ? near_face() * depth / end : length;
        }
        if (radius == 0) return depth / depth_per_metre();
        const float end = radius + depth;
        return std::sqrt(end * end - radius * radius * sine * sine) - radius * cosine;
    }
    /// Depth at metres along a line.
    INSONIFY_FN float depth_at(float length) const {
        if (is_shift) return length < near_face() ? distance(near_face()) * length / near_face() : distance(length);
        if (radius == 0) return length * depth_per_metre();
        return std::sqrt(radius * radius + length * (2 * radius * cosine + length)) - radius;
    }
    /// How far from the straight line through its point at this depth a line begins, metres along the face.
    INSONIFY_FN float place_on_face(float depth) const {
        if (is_shift) return shift;
        return radius == 0 ? depth * sine / depth_per_metre() : radius * around(radius + depth).x;
    }
    /// Depth that a turned line from a plane face gains per metre, above 0.
    INSONIFY_FN float depth_per_metre() const { return cosine - incline * sine; }
    /// Sine and cosine of the angle around the apex from the origin of a turned line to its point at this distance from the
    /// apex: the angle by which it was turned less asin(radius sine / distance).
    INSONIFY_FN vec2 around(float distance) const {
        const float a = clamp(radius * sine / max(distance, 1e-9F), -1, 1), b = std::sqrt(1 - a * a);
        return {sine * b - cosine * a, cosine * b + sine * a};
    }

  private:
    // Near the face a shifted line may approach the apex; there its depth grows evenly from 0. At F-numbers from 1.25 on, the
    // points that it reaches lie further away.
    INSONIFY_FN float near_face() const { return 1.5F * std::fabs(shift); }
    // Of a point of a shifted line from the apex.
    INSONIFY_FN float distance(float length) const {
        return std::sqrt(max(shift * shift + length * (2 * shift * sine + length), 0));
    }
};

/// A turned line in the world.
struct turned_line {
    line_frame straight{}; ///< the line before
    line_turn turn{};
    float tilt = 0; ///< see `line_frame`

    INSONIFY_FN vec3 origin() const {
        return straight.origin + turn.shift * (turn.cosine * right() + turn.sine * straight.along);
    }
    INSONIFY_FN vec3 direction() const {
        return turn.is_shift ? straight.along : turn.cosine * straight.along + turn.sine * right();
    }
    /// The line itself.
    INSONIFY_FN line_frame frame() const { return {origin(), direction(), straight.elevation, tilt}; }
    /// Direction of the straight line through the point at this depth.
    INSONIFY_FN vec3 straight_at(float depth) const {
        if (turn.radius == 0 && !turn.is_shift) return straight.along;
        const vec3 before = turn.is_shift ? origin() - straight.origin : turn.radius * straight.along;
        const vec3 from_apex = before + turn.length_to(depth) * direction();
        return from_apex / max(length(from_apex), 1e-12F);
    }

  private:
    INSONIFY_FN vec3 right() const { return cross(straight.elevation, straight.along); }
};

/// A turned line meets surfaces as the straight line through the same point does; steep ones, which that line would hardly
/// meet, at its own angle.
INSONIFY_FN inline surface_incidence incidence_at(const turned_line& line, float depth, const object_view& one,
                                                  std::uint32_t face) {
    const line_frame turned = line.frame();
    const float length = line.turn.length_to(depth);
    const surface_incidence met = incidence_on(
        one, face, {line.straight.origin, line.straight_at(depth), line.straight.elevation}, turned.at(length));
    return met.cosine > steep_cosine ? met : incidence_at(turned, length, one, face);
}

/// Points in the coordinates of a fan, one in each lane.
struct point_lanes {
    using floats = lanes<simd_width>;
    floats x, y;
};

/// The lines of a fan, all turned or shifted alike.
class turned_fan {
  public:
    void assign(const line_fan& fan, const face_shape& shape, const line_turn& turn) {
        shape_ = shape;
        turn_ = turn;
        const std::uint32_t padded = fan.size() + simd_width;
        for (std::vector<float>& each : lines_) each.resize(padded);
        for (std::uint32_t i = 0; i < padded; ++i) {
            const line_fan::line& straight = fan[std::min(i, fan.size() - 1)];
            const vec2 along = straight.along;
            const line_fan::line turned = turn.is_shift
                                              ? line_fan::line{straight.origin + turn.shift * shape.across, along}
                                              : line_fan::line{straight.origin,
                                                               {along.x * turn.cosine + along.y * turn.sine,
                                                                along.y * turn.cosine - along.x * turn.sine}};
            lines_[0][i] = turned.origin.x, lines_[1][i] = turned.origin.y;
            lines_[2][i] = turned.along.x, lines_[3][i] = turned.along.y;
        }
    }

    /// Of one of the lines.
    line_turn turn(std::uint32_t line) const {
        line_turn own = turn_;
        if (!own.is_shift) return own;
        const vec2 along{lines_[2][line], lines_[3][line]};
        own.sine = dot(shape_.across, along);
        own.cosine = shape_.across.x * along.y - shape_.across.y * along.x;
        return own;
    }
    /// The lines from `first` on; the last line fills the lanes beyond it.
    line_fan::neighbours<simd_width> from(std::uint32_t first) const {
        const auto at = [&](int k) { return load<simd_width>(lines_[k].data() + first); };
        return {at(0), at(1), at(2), at(3)};
    }

    /// Moves points across the lines so that the turned line through each becomes the straight one: what a turned line
    /// crosses is what the straight one crosses after points were moved.
    INSONIFY_INLINE point_lanes straightened(const point_lanes& p) const {
        using floats = point_lanes::floats;
        if (turn_.is_shift) {
            const vec2 shift = turn_.shift * shape_.across;
            return {p.x - floats(shift.x), p.y - floats(shift.y)};
        }
        const floats sine(turn_.sine), cosine(turn_.cosine);
        if (shape_.radius == 0) {
            const floats depth = p.y - floats(turn_.incline) * p.x;
            return {p.x - depth * (sine / floats(turn_.depth_per_metre())), p.y};
        }
        // By the angle of `line_turn::around`.
        const floats one(1.0F), distance = sqrt(p.x * p.x + p.y * p.y);
        const floats a = max(min(floats(turn_.radius * turn_.sine) / max(distance, floats(1e-9F)), one), -one),
                     b = sqrt(one - a * a);
        const floats by_x = sine * b - cosine * a, by_y = cosine * b + sine * a;
        return {p.x * by_y - p.y * by_x, p.x * by_x + p.y * by_y};
    }
    vec2 straightened(vec2 p) const {
        const point_lanes moved = straightened(point_lanes{point_lanes::floats(p.x), point_lanes::floats(p.y)});
        float x[simd_width], y[simd_width];
        store(moved.x, x);
        store(moved.y, y);
        return {x[0], y[0]};
    }

    /// Calls visit(from, to) for the parts of a segment that `straightened` keeps in order: those outside the circle around the
    /// apex that the turned lines, prolonged backwards, touch. They run outside it; inside, a segment would pass the apex on
    /// the other side.
    template <class Visit>
    void for_each_outer_part(vec2 from, vec2 to, const Visit& visit) const {
        const float radius = shape_.radius * std::fabs(turn_.sine);
        const vec2 along = to - from;
        const float a = dot(along, along), b = dot(from, along), c = dot(from, from) - radius * radius;
        const float root = b * b - a * c;
        if (radius == 0 || !(root > 0)) return visit(from, to);
        const float half = std::sqrt(root), enters = (-b - half) / a, leaves = (-b + half) / a;
        if (enters >= 1 || leaves <= 0) return visit(from, to);
        if (enters > 0) visit(from, from + enters * along);
        if (leaves < 1) visit(from + leaves * along, to);
    }

    /// Bit i: whether `for_each_outer_part` may divide segment i.
    INSONIFY_INLINE std::uint32_t divided(const point_lanes& from, const point_lanes& to) const {
        using floats = point_lanes::floats;
        const float radius = shape_.radius * std::fabs(turn_.sine);
        if (radius == 0) return 0;
        const floats x = to.x - from.x, y = to.y - from.y, a = x * x + y * y, b = from.x * x + from.y * y,
                     c = from.x * from.x + from.y * from.y - floats(radius * radius);
        return bits_of(floats(0.0F) <= b * b - a * c);
    }

    /// How many straight lines the turned line that ends in one of them has crossed on its way to a depth.
    float lines_crossed(float depth, std::uint32_t line) const {
        if (turn_.is_shift) {
            const line_turn end = turn(line);
            return std::atan2(end.shift * end.cosine, depth - end.shift * end.sine) / shape_.spacing;
        }
        if (shape_.radius == 0) return turn_.place_on_face(depth) / shape_.spacing;
        const vec2 by = turn_.around(shape_.radius + depth);
        return std::atan2(by.x, by.y) / shape_.spacing;
    }

  private:
    face_shape shape_{};
    line_turn turn_{};
    std::vector<float> lines_[4] = {}; // x, y of origins; x, y of directions; the last line is repeated at the end
};

/// The segments of one slice by the sum of the depths of their ends, which lie in flat arrays so that a register takes several.
/// Keeps its memory from frame to frame.
class slice_segments {
  public:
    static constexpr int width = simd_width;

    void clear() { order_.clear(); }
    void add(const cut_segment& one) { order_.push_back({one.from.y + one.to.y, &one}); }
    /// Sorts the segments, after the last was added.
    void sort() {
        std::sort(order_.begin(), order_.end(), [](const deep& a, const deep& b) { return a.depth < b.depth; });
        const std::size_t padded = (order_.size() + width - 1) / width * width;
        for (std::vector<float>& ends : ends_) ends.assign(padded, 0);
        for (std::size_t i = 0; i < order_.size(); ++i) {
            const cut_segment& one = *order_[i].segment;
            ends_[0][i] = one.from.x, ends_[1][i] = one.from.y, ends_[2][i] = one.to.x, ends_[3][i] = one.to.y;
        }
    }

    std::size_t size() const { return order_.size(); }
    const cut_segment& operator[](std::size_t i) const { return *order_[i].segment; }

    /// The ends of `width` segments from the i-th on; behind the last, 0.
    point_lanes from(std::size_t i) const { return {load<width>(&ends_[0][i]), load<width>(&ends_[1][i])}; }
    point_lanes to(std::size_t i) const { return {load<width>(&ends_[2][i]), load<width>(&ends_[3][i])}; }

  private:
    struct deep {
        float depth = 0;
        const cut_segment* segment = nullptr;
    };
    std::vector<deep> order_{};
    std::vector<float> ends_[4] = {};
};

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
        weight_.resize(std::size_t{points.planes} * steps);
        for (std::uint32_t plane = 0; plane < points.planes; ++plane)
            fans_[plane].assign(points.fan, points.shape, turn[plane]);
    }

    /// Fraction of the aperture that the lines stand for, at one step of one plane.
    float& weight(std::size_t row) { return weight_[row]; }
    float weight(std::size_t row) const { return weight_[row]; }
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
    std::vector<float> weight_{};         // by plane and step
    line_memory memory_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
