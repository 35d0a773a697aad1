#ifndef INSONIFY_EXAMPLES_ANATOMY_VESSEL_HPP
#define INSONIFY_EXAMPLES_ANATOMY_VESSEL_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/centre_line.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/scene/scene.hpp>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace anatomy {

using namespace insonify;

/// The places of the sections of a tube: where they are and their axes.
/// @param across  first axis of the first section, as far as it is across; 0: any
inline std::vector<line_place> places_of(const std::vector<tube_section>& sections, vec3 across = {0, 0, 0}) {
    return insonify::detail::places_along(sections, across, "places_of");
}

/// The sections that a `centre_line` takes for these places, with `across` left out.
inline std::vector<tube_section> sections_of(const std::vector<line_place>& places) {
    std::vector<tube_section> sections;
    for (const line_place& one : places) sections.push_back({one.centre, one.radii});
    const std::vector<line_place> unturned = places_of(sections);
    float before = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const vec3 axis = places[i].first_axis;
        const float turn = std::atan2(dot(axis, unturned[i].second_axis), dot(axis, unturned[i].first_axis));
        sections[i].turn = before = turn + pi * std::round((before - turn) / pi); // half a turn is the same ellipse
    }
    return sections;
}

/// Sections of a tube in other coordinates. @param to  from the present ones
inline std::vector<tube_section> moved(const std::vector<tube_section>& sections, const pose& to) {
    std::vector<line_place> places = places_of(sections);
    for (line_place& one : places) one = {to.point(one.centre), {}, to.direction(one.first_axis), {}, one.radii};
    return sections_of(places);
}

/// Some of the sections of a tube, the last one among them. @param apart  the smallest distance between two, metres
inline std::vector<tube_section> thinned(const std::vector<tube_section>& sections, float apart) {
    const std::vector<line_place> places = places_of(sections);
    std::vector<line_place> fewer{places.front()};
    for (const line_place& one : places)
        if (length(one.centre - fewer.back().centre) >= apart) fewer.push_back(one);
    if (fewer.back() != places.back()) {
        if (fewer.size() > 1) fewer.pop_back();
        fewer.push_back(places.back());
    }
    return sections_of(fewer);
}

/// Pressure in tissue that the face of a probe presses: that of the contact, and less where it lies deeper than `decay`.
struct contact_pressure {
    std::vector<vec3> face{}; ///< points along it, in the body; none: nothing presses
    float pressure = 0;       ///< Pa, such as 12_mmHg
    float decay = 24_mm;      ///< by convention, as the displacement: see `indentation`

    /// At a distance from the nearest point of the face, metres.
    float at(float distance) const { return pressure * std::exp(-max(distance - decay, 0) / decay); }
    /// @throws usage_error  for a setting out of range
    void check() const {
        constexpr float max_pressure = 1e6F; // Pa
        if (!(std::fabs(pressure) <= max_pressure) || !(decay > 0) || !is_finite(decay))
            throw usage_error{"contact_pressure: `pressure` is " + insonify::detail::number_text(pressure) +
                              " Pa; it must be at most 1000000, such as 12_mmHg, and `decay` above 0 and finite"};
    }
};

/// A vessel of a body at rest: blood flows in it, and it pulses, or collapses under pressure.
struct vessel {
    /// An artery pulses, a vein collapses.
    enum class kind { artery, vein };
    std::string
        name{}; ///< of the object that is its blood; that of branches may be one, of which the first is the trunk
    kind type = kind::artery;
    std::vector<tube_section> line{}; ///< of its lumen, in the body; blood flows from the first section to the last
    float peak_velocity =
        0.5F; ///< on the axis, of an artery in systole, m/s; below 0: from the last section to the first
    float resistive_index = 0.75F; ///< of an artery: see `pulsatile`. The flow of veins is steady
    float pressure = 8_mmHg;       ///< of the blood of a vein: see `collapse`

    /// Mean radius of the lumen, metres.
    float radius() const {
        float sum = 0;
        for (const tube_section& one : line) sum += std::sqrt(one.radii.x * one.radii.y);
        return sum / static_cast<float>(line.size());
    }
    /// Distance of a point from its line, metres.
    float distance(vec3 from) const {
        float nearest = FLT_MAX;
        for (std::size_t i = 1; i < line.size(); ++i) {
            const vec3 a = line[i - 1].centre, along = line[i].centre - a;
            const float part = clamp(dot(from - a, along) / dot(along, along), 0, 1);
            nearest = min(nearest, length(a + part * along - from));
        }
        return nearest;
    }
    /// How a face closes it; an artery stays open.
    collapse collapsed(const contact_pressure& under) const {
        float below = FLT_MAX;
        for (const vec3 point : under.face) below = min(below, distance(point));
        const bool presses = type == kind::vein && below < FLT_MAX;
        return {.radius = radius(), .outside = presses ? under.at(below) : 0, .inside = pressure};
    }
    /// The flow that is left where it closes, over that at rest: laminar, through an ellipse, of the pressure gradient that gives
    /// 1 through the circle of its width.
    static float left_by(const collapse& closed) {
        const float opening = closed.opening();
        return 2 * opening * opening * opening / (1 + opening * opening);
    }
};

/// The velocity of the blood in all vessels of a body: a `velocity_field`.
struct blood_flow {
    std::vector<tube_flow> tubes{}; ///< one for each vessel, in this order

    /// Sets how fast the heart beats, and which face presses.
    void set(const std::vector<vessel>& vessels, float heart_rate, const contact_pressure& under) {
        for (std::size_t i = 0; i < vessels.size(); ++i) {
            const vessel& one = vessels[i];
            tubes[i].peak_velocity = vessel::left_by(one.collapsed(under)) * one.peak_velocity;
            if (one.type == vessel::kind::artery) tubes[i].waveform.heart_rate = heart_rate;
        }
    }

    /// See `velocity_field`. Where branches meet, that of the first vessel in which the point lies.
    vec3 operator()(object_id object, vec3 point, float time) const {
        for (const tube_flow& one : tubes)
            if (one.object == object)
                if (const vec3 velocity = one(object, point, time); velocity != vec3{0, 0, 0}) return velocity;
        return {0, 0, 0};
    }
};

/// Where a vessel tapers, branches take the rest of its flow, so that its velocity stays.
/// @param heart_rate  beats per second, such as 1.2_Hz; 0: as in systole, steadily
/// @throws usage_error  for a vessel whose blood is not in the body, and a setting out of range
inline blood_flow flow_of(const scene& body, const std::vector<vessel>& vessels, float heart_rate,
                          const contact_pressure& under = {}) {
    under.check();
    blood_flow all;
    for (const vessel& one : vessels) {
        const std::optional<object_id> blood = body.find(one.name);
        if (!blood)
            throw usage_error{"flow_of: there is no object '" + one.name + "', which a vessel names as its blood"};
        all.tubes.push_back({.object = *blood,
                             .line = moved(one.line, inverse(body[*blood].at)),
                             .waveform = {.resistive_index = one.resistive_index},
                             .side_branches = 1});
    }
    all.set(vessels, heart_rate, under);
    for (const tube_flow& one : all.tubes) one.check();
    return all;
}

/// How vessels move, and the tissue around them: a map for `scene::deform`, which brings its inverse. Beyond the ends of its line
/// each goes on straight.
struct vessel_motion {
    std::vector<bent<pulsation>> arteries{};
    std::vector<bent<collapse>> veins{}; ///< those that are partly closed

    vec3 operator()(vec3 rest) const {
        vec3 now = rest;
        for (const bent<pulsation>& one : arteries) now = one(now);
        for (const bent<collapse>& one : veins) now = one(now);
        return now;
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        vec3 rest = now;
        for (auto one = veins.rbegin(); one != veins.rend(); ++one) rest = one->rest_of(rest);
        for (auto one = arteries.rbegin(); one != arteries.rend(); ++one) rest = one->rest_of(rest);
        return rest;
    }

    friend bool operator==(const vessel_motion&, const vessel_motion&) = default;
};

/// Of trees, the trunk moves alone: two that overlap would fold tissue over where they meet.
/// @param beat   of an artery of `beat.radius`; that of others is in proportion to their radii
/// @param under  the face that presses on veins
/// @throws usage_error  for a setting out of range
inline vessel_motion motion_of(const std::vector<vessel>& vessels, const pulsation& beat,
                               const contact_pressure& under) {
    beat.check();
    under.check();
    vessel_motion all;
    const std::string* trunk = nullptr;
    for (const vessel& one : vessels) {
        if (trunk != nullptr && *trunk == one.name) continue;
        trunk = &one.name;
        if (one.type == vessel::kind::artery && beat.amplitude != 0) all.arteries.push_back({one.line, beat});
        if (const collapse wall = one.collapsed(under); wall.opening() < 1) all.veins.push_back({one.line, wall});
    }
    return all;
}

} // namespace anatomy

#endif
