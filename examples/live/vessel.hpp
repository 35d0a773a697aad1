#ifndef INSONIFY_EXAMPLES_LIVE_VESSEL_HPP
#define INSONIFY_EXAMPLES_LIVE_VESSEL_HPP

#include <insonify/insonify.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace live {

using namespace insonify;

/// Sections of a tube whose first axes are those of another pose: what a `centre_line` takes.
struct tube_course {
    std::vector<tube_section> sections{};
    vec3 across{0, 0, 0}; ///< first axis of the first section; 0: any

    centre_line line() const { return {sections, across}; }
    /// The same with fewer sections, at least so far apart but for the last. @param apart  metres
    tube_course thinned(float apart) const {
        tube_course fewer{{sections.front()}, across};
        for (std::size_t i = 1; i < sections.size(); ++i) {
            const bool is_last = i + 1 == sections.size();
            if (is_last && fewer.sections.size() > 1 &&
                length(sections[i].centre - fewer.sections.back().centre) < apart)
                fewer.sections.pop_back();
            if (is_last || length(sections[i].centre - fewer.sections.back().centre) >= apart)
                fewer.sections.push_back(sections[i]);
        }
        return fewer;
    }
    /// The same course in other coordinates. @param to  from the present ones
    tube_course moved(const pose& to) const {
        // `across` is that of a section without a turn.
        tube_course there{sections, to.direction(line().first().first_axis)};
        for (tube_section& one : there.sections) {
            one.centre = to.point(one.centre);
            one.turn -= sections.front().turn;
        }
        return there;
    }
};

/// A vessel of a body at rest: blood flows in it, and it pulses, or collapses under pressure.
struct vessel {
    object_id blood{};
    bool is_artery = true;
    tube_course course{};    ///< of its lumen in the world, in the direction of flow
    float peak_velocity = 0; ///< on the axis at the first section, of an artery in systole, m/s; below 0: towards it

    /// Mean radius of the lumen, metres.
    float radius() const {
        float sum = 0;
        for (const tube_section& one : course.sections) sum += std::sqrt(one.radii.x * one.radii.y);
        return sum / static_cast<float>(course.sections.size());
    }
    /// Distance of a point from its line, metres.
    float distance(vec3 from) const {
        float nearest = FLT_MAX;
        for (std::size_t i = 1; i < course.sections.size(); ++i) {
            const vec3 a = course.sections[i - 1].centre, along = course.sections[i].centre - a;
            const float part = clamp(dot(from - a, along) / dot(along, along), 0, 1);
            nearest = min(nearest, length(a + part * along - from));
        }
        return nearest;
    }
};

/// The course of a vessel that runs mainly in one direction, from the vertices of its mesh: at up to 13 places the ellipse of
/// the same variance. None where it is no tube.
inline std::optional<tube_course> find_course(const object& blood) {
    constexpr std::size_t places = 13;
    std::vector<vec3> points = blood.surface.positions;
    if (points.size() < 8) return std::nullopt;
    vec3 mean{0, 0, 0}, along{0.3F, 1, 0.2F}; // the direction of the largest variance, by power iteration
    for (vec3& point : points) mean += (point = blood.at.point(point)) / static_cast<float>(points.size());
    for (int i = 0; i < 24; ++i) {
        vec3 next{0, 0, 0};
        for (const vec3& point : points) next += dot(point - mean, along) * (point - mean);
        if (!(length(next) > 0)) return std::nullopt;
        along = normalize(next);
    }
    if (along.x + along.y + along.z < 0) along = -along;
    float first = FLT_MAX, last = -FLT_MAX;
    for (const vec3& point : points) {
        first = min(first, dot(point - mean, along));
        last = max(last, dot(point - mean, along));
    }
    const auto place_of = [&](vec3 point) {
        return static_cast<std::size_t>(
            std::lround((dot(point - mean, along) - first) / (last - first) * static_cast<float>(places - 1)));
    };
    struct place {
        float count = 0;
        vec3 centre{0, 0, 0};
        vec3 spread{0, 0, 0}; // variance along `right`, covariance, variance along `up`
    };
    std::array<place, places> found{};
    for (const vec3& point : points) {
        place& one = found[place_of(point)];
        one.centre += point;
        ++one.count;
    }
    const vec3 right = normalize(cross(along, std::fabs(along.z) < 0.8F ? vec3{0, 0, 1} : vec3{1, 0, 0})),
               up = cross(along, right);
    for (place& one : found) one.centre /= max(one.count, 1);
    vec3 spread{0, 0, 0};
    for (const vec3& point : points) {
        place& one = found[place_of(point)];
        const vec2 away{dot(point - one.centre, right), dot(point - one.centre, up)};
        one.spread += vec3{away.x * away.x, away.x * away.y, away.y * away.y} / one.count;
        spread += vec3{away.x * away.x, away.x * away.y, away.y * away.y};
    }
    // All ellipses have the same axes: those of the mean one.
    const float turn = 0.5F * std::atan2(2 * spread.y, spread.x - spread.z), c = std::cos(turn), s = std::sin(turn);
    tube_course course{{}, c * right + s * up};
    for (const place& one : found) {
        const auto variance = [&](float x, float y) {
            return x * x * one.spread.x + 2 * x * y * one.spread.y + y * y * one.spread.z;
        };
        const vec2 radii{std::sqrt(max(2 * variance(c, s), 0)), std::sqrt(max(2 * variance(-s, c), 0))}; // of outlines
        if (one.count > 2 && radii.x > 1_um && radii.y > 1_um) course.sections.push_back({one.centre, radii});
    }
    try {
        if (course.sections.size() < 2) return std::nullopt;
        static_cast<void>(course.line());
    } catch (const geometry_error&) {
        return std::nullopt; // it turns back
    }
    return course;
}

/// The vessels of a body that says no more than names: the objects `artery` and `vein`.
inline std::vector<vessel> find_vessels(const scene& body) {
    std::vector<vessel> all;
    const auto add = [&](const char* name, bool is_artery, float velocity) {
        const std::optional<object_id> found = body.find(name);
        if (!found) return;
        if (std::optional<tube_course> course = find_course(body[*found]))
            all.push_back({*found, is_artery, std::move(*course), velocity});
    };
    add("artery", true, 0.6F);
    add("vein", false, -0.12F);
    return all;
}

/// Blood in arteries, which pulses, and in veins, which does not: a `velocity_field`. Deformed vessels keep its volume flow;
/// but a vein that closes lets less through.
class blood_flow {
  public:
    pulsatile beat{.heart_rate = 1.2F, .resistive_index = 0.75F}; ///< of the arteries

    blood_flow() = default;
    /// @param body  has the vessels
    blood_flow(const scene& body, const std::vector<vessel>& vessels) {
        for (const vessel& one : vessels)
            tubes_.push_back({{one.blood, one.course.moved(inverse(body[one.blood].at)).line(), one.peak_velocity},
                              one.is_artery,
                              1});
    }

    /// Sets how far a vein is open, see `collapse::opening`. @param vessel  its place among the vessels
    void open(std::size_t vessel, float opening) { tubes_[vessel].let_through = through(opening); }

    vec3 operator()(object_id object, vec3 point, float time) const {
        for (const tube& one : tubes_) {
            if (one.flow.object != object) continue;
            const vec3 velocity = one.flow(object, point, time);
            return one.is_artery ? beat(time) * velocity : one.let_through * velocity;
        }
        return {0, 0, 0};
    }

  private:
    struct tube {
        tube_flow flow{}; // steady
        bool is_artery = true;
        float let_through = 1;
    };

    // Laminar flow through an ellipse, of the pressure gradient that gives 1 through a circle of its width.
    static float through(float opening) { return 2 * opening * opening * opening / (1 + opening * opening); }

    std::vector<tube> tubes_{};
};

/// How the tissue moves, from rest: arteries pulse, veins collapse, the face of the probe presses, and the needle drags. A map for
/// `scene::deform`, which brings its inverse: none of them folds over, whatever the events. What is outside of `seen`, and so not
/// in the picture, stays at rest.
struct tissue_motion {
    aabb seen{};
    std::vector<bent<pulsation>> arteries{};
    std::vector<bent<collapse>> veins{}; ///< those that are not quite open
    bool pressed = false, dragged = false;
    pressed_face face{};
    needle_drag drag{};

    vec3 operator()(vec3 rest) const {
        if (!seen.contains(rest)) return rest;
        vec3 now = rest;
        for (const bent<pulsation>& one : arteries) now = one(now);
        for (const bent<collapse>& one : veins) now = one(now);
        if (pressed) now = face(now);
        return dragged ? drag(now) : now;
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        if (!seen.contains(now)) return now;
        vec3 rest = dragged ? drag.rest_of(now) : now;
        if (pressed) rest = face.rest_of(rest);
        for (auto one = veins.rbegin(); one != veins.rend(); ++one) rest = one->rest_of(rest);
        for (auto one = arteries.rbegin(); one != arteries.rend(); ++one) rest = one->rest_of(rest);
        return rest;
    }

    friend bool operator==(const tissue_motion& a, const tissue_motion& b) {
        return a.seen.lower == b.seen.lower && a.seen.upper == b.seen.upper && a.arteries == b.arteries &&
               a.veins == b.veins && a.pressed == b.pressed && a.dragged == b.dragged && a.face == b.face &&
               a.drag == b.drag;
    }
};

} // namespace live

#endif
