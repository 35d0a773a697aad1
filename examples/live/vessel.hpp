#ifndef INSONIFY_EXAMPLES_LIVE_VESSEL_HPP
#define INSONIFY_EXAMPLES_LIVE_VESSEL_HPP

#include <insonify/insonify.hpp>
#include "../anatomy/vessel.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace live {

using namespace insonify;

using ::anatomy::blood_flow, ::anatomy::vessel, ::anatomy::vessel_motion;

/// The course of a vessel that runs mainly in one direction, from the vertices of its mesh: at up to 13 places the ellipse of
/// the same variance. None where it is no tube.
inline std::optional<std::vector<tube_section>> find_course(const object& blood) {
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
    std::vector<tube_section> course;
    for (const place& one : found) {
        const auto variance = [&](float x, float y) {
            return x * x * one.spread.x + 2 * x * y * one.spread.y + y * y * one.spread.z;
        };
        const vec2 radii{std::sqrt(max(2 * variance(c, s), 0)), std::sqrt(max(2 * variance(-s, c), 0))}; // of outlines
        if (one.count > 2 && radii.x > 1_um && radii.y > 1_um) course.push_back({one.centre, radii});
    }
    try {
        if (course.size() < 2) return std::nullopt;
        return ::anatomy::sections_of(::anatomy::places_of(course, c * right + s * up));
    } catch (const geometry_error&) {
        return std::nullopt; // it turns back
    }
}

/// The vessels of a body that says no more than names: the objects `artery` and `vein`.
inline std::vector<vessel> find_vessels(const scene& body) {
    std::vector<vessel> all;
    const auto add = [&](const char* name, vessel::kind type, float velocity) {
        const std::optional<object_id> found = body.find(name);
        if (!found) return;
        if (auto course = find_course(body[*found]))
            all.push_back({.name = name, .type = type, .line = std::move(*course), .peak_velocity = velocity});
    };
    add("artery", vessel::kind::artery, 0.6F);
    add("vein", vessel::kind::vein, -0.12F);
    return all;
}

/// How the tissue moves, from rest: arteries pulse, veins collapse, the face of the probe presses, and the needle drags. A map for
/// `scene::deform`, which brings its inverse: none of them folds over, whatever the events. What is outside of `seen`, and so not
/// in the picture, stays at rest.
struct tissue_motion {
    aabb seen{};
    vessel_motion vessels{};
    bool pressed = false, dragged = false;
    pressed_face face{};
    needle_drag drag{};

    vec3 operator()(vec3 rest) const {
        if (!seen.contains(rest)) return rest;
        vec3 now = vessels(rest);
        if (pressed) now = face(now);
        return dragged ? drag(now) : now;
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        if (!seen.contains(now)) return now;
        vec3 rest = dragged ? drag.rest_of(now) : now;
        if (pressed) rest = face.rest_of(rest);
        return vessels.rest_of(rest);
    }

    friend bool operator==(const tissue_motion& a, const tissue_motion& b) {
        return a.seen.lower == b.seen.lower && a.seen.upper == b.seen.upper && a.vessels == b.vessels &&
               a.pressed == b.pressed && a.dragged == b.dragged && a.face == b.face && a.drag == b.drag;
    }
};

} // namespace live

#endif
