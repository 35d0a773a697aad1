#ifndef INSONIFY_TRACING_APERTURE_TURNED_LINE_HPP
#define INSONIFY_TRACING_APERTURE_TURNED_LINE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <insonify/tracing/find/slice_finder.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// What the lines of a fan leave.
enum class face_form {
    plane,  ///< parallel lines, at right angles to a plane face or steered
    circle, ///< lines along the radii of a circle around the apex
    point,  ///< lines from one point, steered by a plane face along the probe's x
};

/// Where the lines of a fan begin and how they diverge, where neighbours are equally far apart.
struct face_shape {
    face_form form = face_form::plane;
    float radius = 0;         ///< of the circle, metres; else 0
    float incline = 0;        ///< of a plane face under steered lines: change of y per x
    float spacing = 0;        ///< from line to line: metres, or radians around the apex
    vec2 across{1, 0};        ///< along the plane face, in the coordinates of the fan
    bool full_circle = false; ///< the last line is next to the first

    /// @return whether the lines are of this kind
    bool assign(const line_fan& fan, bool circle) {
        const std::uint32_t lines = fan.size();
        full_circle = circle;
        if (lines < 2) return false;
        const auto place = [&](std::uint32_t i) {
            return fan.parallel() ? fan[i].origin.x : std::atan2(fan[i].along.x, fan[i].along.y);
        };
        const std::uint32_t middle = (lines - 1) / 2;
        spacing =
            circle ? 2 * pi / static_cast<float>(lines) : (place(lines - 1) - place(0)) / static_cast<float>(lines - 1);
        radius = fan.parallel() ? 0.0F : length(fan[middle].origin);
        form = fan.parallel() ? face_form::plane : radius > 1e-4F ? face_form::circle : face_form::point;
        const pose upright = fan.upright();
        across = {upright.rotation[0].x, upright.rotation[2].x};
        if (!(spacing > 0) || (form == face_form::point && (circle || !fan.is_wedge()))) return false;
        const vec2 face_line = fan[lines - 1].origin - fan[0].origin;
        incline = fan.parallel() ? face_line.y / face_line.x : 0.0F;
        for (std::uint32_t i = 0; i < lines; ++i) {
            const vec2 along_face = fan[i].origin - fan[middle].origin;
            const float face = fan.parallel() ? along_face.y - incline * along_face.x : length(fan[i].origin) - radius;
            const float expected = place(middle) + (static_cast<float>(i) - static_cast<float>(middle)) * spacing;
            if (std::fabs(face) > 1e-6F || std::fabs(place(i) - expected) > 0.05F * spacing) return false;
        }
        if (form == face_form::point) radius = 0;
        return true;
    }
};

/// How a line reaches the points of other lines through the aperture. On a plane or round face it is turned about its
/// origin in the slice plane, to the right. A line from the point of a phased array is shifted along the face instead.
/// Such a line is measured by the depth that it reaches: that of the line of the probe which ends in the same point.
struct line_turn {
    face_shape face{};
    float sine = 0; ///< of the angle by which it is turned; of a shifted line, of its angle with the normal of the face
    float cosine = 1;
    float shift = 0; ///< metres along the face, of a line from a point

    INSONIFY_FN bool is_shift() const { return face.form == face_form::point; }

    /// Metres along a line to a depth.
    INSONIFY_FN float length_to(float depth) const {
        if (face.form == face_form::plane) return depth / depth_per_metre();
        const float nearest = distance(near_face()), end = face.radius + depth;
        if (end < nearest) return near_face() * depth / nearest;
        const float missed = face.radius * face.radius * sine * sine + shift * shift * cosine * cosine;
        return std::sqrt(max(end * end - missed, 0)) - from_apex();
    }
    /// Depth at metres along a line.
    INSONIFY_FN float depth_at(float length) const {
        if (face.form == face_form::plane) return length * depth_per_metre();
        if (length < near_face()) return distance(near_face()) * length / near_face();
        return distance(length) - face.radius;
    }
    /// How far from the straight line through its point at this depth a line begins, metres along the face.
    INSONIFY_FN float place_on_face(float depth) const {
        if (face.form == face_form::plane) return depth * sine / depth_per_metre();
        return face.form == face_form::circle ? face.radius * around(face.radius + depth).x : shift;
    }
    /// How many straight lines the line that ends in one of them has crossed on its way to a depth.
    INSONIFY_FN float lines_crossed(float depth) const {
        if (face.form == face_form::plane) return place_on_face(depth) / face.spacing;
        const vec2 by =
            face.form == face_form::circle ? around(face.radius + depth) : vec2{shift * cosine, depth - shift * sine};
        return std::atan2(by.x, by.y) / face.spacing;
    }
    /// Depth that a line from a plane face gains per metre, above 0.
    INSONIFY_FN float depth_per_metre() const { return cosine - face.incline * sine; }
    /// Sine and cosine of the angle around the apex from the origin of a line from a round face to its point at this
    /// distance from the apex: the angle by which it was turned less asin(radius sine / distance).
    INSONIFY_FN vec2 around(float distance) const {
        const float a = clamp(face.radius * sine / max(distance, 1e-9F), -1, 1), b = std::sqrt(1 - a * a);
        return {sine * b - cosine * a, cosine * b + sine * a};
    }

  private:
    // Near the face a shifted line may approach the apex; there its depth grows evenly from 0. 0 for other lines.
    INSONIFY_FN float near_face() const { return 1.5F * std::fabs(shift); }
    // How far along a line its origin lies from the apex: it is on the round face, or was shifted away from it.
    INSONIFY_FN float from_apex() const { return face.radius * cosine + shift * sine; }
    // Of a point of a line from the apex.
    INSONIFY_FN float distance(float length) const {
        return std::sqrt(max(face.radius * face.radius + shift * shift + length * (2 * from_apex() + length), 0));
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
        return turn.is_shift() ? straight.along : turn.cosine * straight.along + turn.sine * right();
    }
    /// The line itself.
    INSONIFY_FN line_frame frame() const { return {origin(), direction(), straight.elevation, tilt}; }
    /// Direction of the straight line through the point at this depth.
    INSONIFY_FN vec3 straight_at(float depth) const {
        if (turn.face.form == face_form::plane) return straight.along;
        const vec3 before = turn.is_shift() ? origin() - straight.origin : turn.face.radius * straight.along;
        const vec3 from_apex = before + turn.length_to(depth) * direction();
        return from_apex / max(length(from_apex), 1e-12F);
    }

  private:
    INSONIFY_FN vec3 right() const { return cross(straight.elevation, straight.along); }
};

/// A turned line meets surfaces as the straight line through the same point does; steep ones, which that line would
/// hardly meet, at its own angle.
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

/// The segments of one slice by the sum of the depths of their ends, which lie in flat arrays so that a register takes
/// several. Keeps its memory from frame to frame.
class slice_segments {
  public:
    static constexpr int width = simd_width;

    void clear() { order_.clear(); }
    void add(const cut_segment& one) { order_.emplace_back(one); }
    /// Sorts the segments, after the last was added.
    void sort() {
        std::sort(order_.begin(), order_.end());
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
    std::vector<deep_segment> order_{};
    std::vector<float> ends_[4] = {};
};

/// The lines of a fan, all turned or shifted alike, and the segments of slices that they cross.
class turned_fan {
  public:
    void assign(const line_fan& fan, const line_turn& turn) {
        turn_ = turn;
        const std::uint32_t padded = fan.size() + simd_width;
        for (std::vector<float>& each : lines_) each.resize(padded);
        const vec2 shift = turn.shift * turn.face.across;
        for (std::uint32_t i = 0; i < padded; ++i) {
            const line_fan::line& line = fan[std::min(i, fan.size() - 1)];
            const vec2 turned{line.along.x * turn.cosine + line.along.y * turn.sine,
                              line.along.y * turn.cosine - line.along.x * turn.sine};
            const vec2 origin = line.origin + shift, along = turn.is_shift() ? line.along : turned;
            lines_[0][i] = origin.x, lines_[1][i] = origin.y, lines_[2][i] = along.x, lines_[3][i] = along.y;
        }
    }

    /// The lines from `first` on; the last line fills the lanes beyond it.
    line_fan::neighbours from(std::uint32_t first) const {
        const auto at = [&](int k) { return load<simd_width>(lines_[k].data() + first); };
        return {at(0), at(1), at(2), at(3)};
    }

    /// Calls visit(segment, first, last): the lines [first, last) cross the segment, in the order of the segments.
    template <class Visit>
    void for_each_crossed(const line_fan& straight, const slice_segments& segments, const Visit& visit) const {
        constexpr int width = simd_width;
        for (std::size_t begin = 0; begin < segments.size(); begin += width) {
            const point_lanes from = segments.from(begin), to = segments.to(begin);
            const point_lanes first = straightened(from), last = straightened(to);
            const auto places_first = straight.places_of(first.x, first.y),
                       places_last = straight.places_of(last.x, last.y);
            float ends[4][width];
            store(first.x, ends[0]), store(first.y, ends[1]), store(last.x, ends[2]), store(last.y, ends[3]);
            const std::size_t end = std::min<std::size_t>(width, segments.size() - begin);
            for (std::uint32_t i = 0; i < end; ++i) {
                const cut_segment& one = segments[begin + i];
                const vec2 p{ends[0][i], ends[1][i]}, q{ends[2][i], ends[3][i]};
                const std::uint32_t gap_p = straight.gap(places_first, i), gap_q = straight.gap(places_last, i);
                for_each_outer_part(one.from, one.to, [&](vec2 a, vec2 b) {
                    const vec2 a_moved = a == one.from ? p : straightened(a),
                               b_moved = b == one.to ? q : straightened(b);
                    straight.for_each_crossed(
                        a_moved, a == one.from ? gap_p : straight.gap(a_moved), b_moved,
                        b == one.to ? gap_q : straight.gap(b_moved),
                        [&](std::uint32_t first_line, std::uint32_t line_end) { visit(one, first_line, line_end); });
                });
            }
        }
    }

  private:
    // Moves points across the lines so that the turned line through each becomes the straight one.
    INSONIFY_INLINE point_lanes straightened(const point_lanes& p) const {
        using floats = point_lanes::floats;
        const face_shape& face = turn_.face;
        if (turn_.is_shift()) {
            const vec2 shift = turn_.shift * face.across;
            return {p.x - floats(shift.x), p.y - floats(shift.y)};
        }
        const floats sine(turn_.sine), cosine(turn_.cosine);
        if (face.form == face_form::plane) {
            const floats depth = p.y - floats(face.incline) * p.x;
            return {p.x - depth * (sine / floats(turn_.depth_per_metre())), p.y};
        }
        // By the angle of `line_turn::around`.
        const floats one(1.0F), distance = sqrt(p.x * p.x + p.y * p.y);
        const floats a = max(min(floats(face.radius * turn_.sine) / max(distance, floats(1e-9F)), one), -one),
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

    // Of the circle around the apex that lines from a round face, prolonged backwards, touch: they run outside it.
    float inner_radius() const { return turn_.face.radius * std::fabs(turn_.sine); }

    // Calls visit(from, to) for the parts of a segment that `straightened` keeps in order: those outside that circle;
    // inside, a segment would pass the apex on the other side.
    template <class Visit>
    void for_each_outer_part(vec2 from, vec2 to, const Visit& visit) const {
        const float radius = inner_radius();
        if (radius == 0) return visit(from, to);
        const vec2 along = to - from;
        const float a = dot(along, along), b = dot(from, along), c = dot(from, from) - radius * radius;
        const float root = b * b - a * c;
        if (!(root > 0)) return visit(from, to);
        const float half = std::sqrt(root), enters = (-b - half) / a, leaves = (-b + half) / a;
        if (enters >= 1 || leaves <= 0) return visit(from, to);
        if (enters > 0) visit(from, from + enters * along);
        if (leaves < 1) visit(from + leaves * along, to);
    }

    line_turn turn_{};
    std::vector<float> lines_[4] = {}; // x, y of origins; x, y of directions; the last line is repeated at the end
};

/// The crossings of the turned lines of one direction with the segments of the slices, by plane and line, at metres
/// along the lines. Keeps its memory from frame to frame.
class turned_crossings {
  public:
    /// @param fan     before its lines are turned
    /// @param turns   of the lines in each plane
    /// @param slices  of each plane, sorted, so that the crossings of each line nearly are
    void find(const line_fan& fan, view<const line_turn> turns, view<const slice_segments> slices) {
        constexpr int width = simd_width;
        lines_ = fan.size();
        crossed_.clear();
        lists_.clear(turns.size() * lines_);
        for (std::uint32_t plane = 0; plane < turns.size(); ++plane) {
            fans_[plane].assign(fan, turns[plane]);
            const std::size_t first_list = std::size_t{plane} * lines_;
            fans_[plane].for_each_crossed(fan, slices[plane],
                                          [&](const cut_segment& one, std::uint32_t first, std::uint32_t last) {
                                              crossed_.push_back({&one, first, last});
                                              for (std::uint32_t line = first; line < last; ++line)
                                                  lists_.count(first_list + line);
                                          });
        }
        lists_.make_room();
        for (const crossed_segment& crossed : crossed_) {
            const cut_segment& one = *crossed.segment;
            const std::size_t first_list = std::size_t{one.slice} * lines_;
            for (std::uint32_t line = crossed.first; line < crossed.last; line += width) {
                float distance[width];
                store(fans_[one.slice].from(line).intersect(one.from, one.to), distance);
                for (std::uint32_t i = line; i < crossed.last && i < line + width; ++i)
                    lists_.add(first_list + i, {distance[i - line], one.object, one.primitive});
            }
        }
    }

    view<const crossing> of_line(std::uint32_t line, std::uint32_t plane) const {
        return lists_[std::size_t{plane} * lines_ + line];
    }

  private:
    // The lines [first, last) cross a segment.
    struct crossed_segment {
        const cut_segment* segment = nullptr;
        std::uint32_t first = 0, last = 0;
    };

    std::uint32_t lines_ = 0;
    turned_fan fans_[max_elevation_planes] = {};
    std::vector<crossed_segment> crossed_{};
    crossing_lists lists_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
