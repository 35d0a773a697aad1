#ifndef INSONIFY_TRACING_APERTURE_TURNED_LINE_HPP
#define INSONIFY_TRACING_APERTURE_TURNED_LINE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/line_fan.hpp>
#include <insonify/scene/layers.hpp>
#include <cmath>

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
        if (face.form == face_form::circle) {
            const float end = face.radius + depth;
            return std::sqrt(end * end - face.radius * face.radius * sine * sine) - face.radius * cosine;
        }
        const float end = max(depth, distance(near_face()));
        const float length = std::sqrt(max(end * end - shift * shift * cosine * cosine, 0)) - shift * sine;
        return depth < end ? near_face() * depth / end : length;
    }
    /// Depth at metres along a line.
    INSONIFY_FN float depth_at(float length) const {
        if (face.form == face_form::plane) return length * depth_per_metre();
        if (face.form == face_form::circle)
            return std::sqrt(face.radius * face.radius + length * (2 * face.radius * cosine + length)) - face.radius;
        return length < near_face() ? distance(near_face()) * length / near_face() : distance(length);
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
    // Near the face a shifted line may approach the apex; there its depth grows evenly from 0. At F-numbers from 1.25
    // on, the points that it reaches lie further away.
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

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
