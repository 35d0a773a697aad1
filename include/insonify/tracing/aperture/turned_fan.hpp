#ifndef INSONIFY_TRACING_APERTURE_TURNED_FAN_HPP
#define INSONIFY_TRACING_APERTURE_TURNED_FAN_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/layers.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

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

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
