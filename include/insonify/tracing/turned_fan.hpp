#ifndef INSONIFY_TRACING_TURNED_FAN_HPP
#define INSONIFY_TRACING_TURNED_FAN_HPP

#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/layers.hpp>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Where the lines of a fan begin and how they diverge, where neighbours are equally far apart: parallel lines from a plane
/// face, at right angles to it or steered, or lines that leave a circle around the apex along its radii.
struct face_shape {
    float radius = 0;  ///< of the circle, metres; 0: a plane
    float incline = 0; ///< of a plane: change of y per x, 0 unless lines are steered
    float spacing = 0; ///< from line to line: metres, or radians around the apex
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
        if (!(spacing > 0) || (!fan.parallel() && !(radius > 1e-4F))) return false;
        const vec2 across = fan[lines - 1].origin - fan[0].origin;
        incline = fan.parallel() ? across.y / across.x : 0.0F;
        for (std::uint32_t i = 0; i < lines; ++i) {
            const vec2 along_face = fan[i].origin - fan[middle].origin;
            const float face = fan.parallel() ? along_face.y - incline * along_face.x : length(fan[i].origin) - radius;
            const float expected = place(middle) + (static_cast<float>(i) - static_cast<float>(middle)) * spacing;
            if (std::fabs(face) > 1e-6F || std::fabs(place(i) - expected) > 0.05F * spacing) return false;
        }
        return true;
    }
};

/// By how much lines are turned about their origins in the slice plane, to the right. A turned line is measured by the depth
/// that it reaches.
struct line_turn {
    float sine = 0;
    float cosine = 1;
    float radius = 0;  ///< see `face_shape`
    float incline = 0; ///< see `face_shape`

    /// Metres along a turned line to a depth.
    float length_to(float depth) const {
        if (radius == 0) return depth / depth_per_metre();
        const float end = radius + depth;
        return std::sqrt(end * end - radius * radius * sine * sine) - radius * cosine;
    }
    /// Depth at metres along a turned line.
    float depth_at(float length) const {
        if (radius == 0) return length * depth_per_metre();
        return std::sqrt(radius * radius + length * (2 * radius * cosine + length)) - radius;
    }
    /// How far from the straight line through its point at this depth a turned line begins, metres along the face.
    float place_on_face(float depth) const {
        return radius == 0 ? depth * sine / depth_per_metre() : radius * around(radius + depth).x;
    }
    /// Depth that a turned line from a plane face gains per metre, above 0.
    float depth_per_metre() const { return cosine - incline * sine; }
    /// Sine and cosine of the angle around the apex from the origin of a turned line to its point at this distance from the
    /// apex: the angle by which it was turned less asin(radius sine / distance).
    vec2 around(float distance) const {
        const float a = clamp(radius * sine / max(distance, 1e-9F), -1, 1), b = std::sqrt(1 - a * a);
        return {sine * b - cosine * a, cosine * b + sine * a};
    }
};

/// A turned line in the world.
struct turned_line {
    line_frame straight{}; ///< the line before
    line_turn turn{};
    float tilt = 0; ///< see `line_frame`

    vec3 direction() const {
        return turn.cosine * straight.along + turn.sine * cross(straight.elevation, straight.along);
    }
    /// The line itself.
    line_frame frame() const { return {straight.origin, direction(), straight.elevation, tilt}; }
    /// Direction of the straight line through the point at this depth.
    vec3 straight_at(float depth) const {
        if (turn.radius == 0) return straight.along;
        const vec3 from_apex = turn.radius * straight.along + turn.length_to(depth) * direction();
        return from_apex / length(from_apex);
    }
};

/// A turned line meets surfaces as the straight line through the same point does; steep ones, which that line would hardly
/// meet, at its own angle.
inline surface_incidence incidence_at(const turned_line& line, float depth, const object_view& one,
                                      std::uint32_t face) {
    const surface_incidence met =
        incidence_on(one, face, {line.straight.origin, line.straight_at(depth), line.straight.elevation});
    return met.cosine > steep_cosine ? met : incidence_at(line.frame(), depth, one, face);
}

/// The lines of a fan, all turned alike.
class turned_fan {
  public:
    void assign(const line_fan& fan, const face_shape& shape, const line_turn& turn) {
        shape_ = shape;
        turn_ = turn;
        lines_.resize(fan.size());
        for (std::uint32_t i = 0; i < fan.size(); ++i) {
            const vec2 along = fan[i].along;
            lines_[i] = {fan[i].origin,
                         {along.x * turn.cosine + along.y * turn.sine, along.y * turn.cosine - along.x * turn.sine}};
        }
    }

    const line_turn& turn() const { return turn_; }
    const std::vector<line_fan::line>& lines() const { return lines_; }

    /// Moves a point across the lines so that the turned line through it becomes the straight one: what a turned line
    /// crosses is what the straight one crosses after points were moved.
    vec2 straightened(vec2 p) const {
        if (shape_.radius == 0) return {p.x - (p.y - turn_.incline * p.x) * turn_.sine / turn_.depth_per_metre(), p.y};
        const vec2 by = turn_.around(length(p));
        return {p.x * by.y - p.y * by.x, p.x * by.x + p.y * by.y};
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

    /// How many straight lines a turned line has crossed on its way to a depth.
    float lines_crossed(float depth) const {
        if (shape_.radius == 0) return turn_.place_on_face(depth) / shape_.spacing;
        const vec2 by = turn_.around(shape_.radius + depth);
        return std::atan2(by.x, by.y) / shape_.spacing;
    }

  private:
    face_shape shape_{};
    line_turn turn_{};
    std::vector<line_fan::line> lines_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
