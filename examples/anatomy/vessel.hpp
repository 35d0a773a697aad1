#ifndef INSONIFY_EXAMPLES_ANATOMY_VESSEL_HPP
#define INSONIFY_EXAMPLES_ANATOMY_VESSEL_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/centre_line.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>
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

/// A vessel of a body at rest: blood flows in it, and it pulses, or collapses under pressure.
struct vessel {
    /// An artery pulses, a vein collapses.
    enum class kind { artery, vein };
    std::string name{}; ///< of the object that is its blood; that of branches may be one
    kind type = kind::artery;
    std::vector<tube_section> line{}; ///< of its lumen, in the body; blood flows from the first section to the last
    float peak_velocity = 0.5F; ///< on the axis at the first section, of an artery in systole, m/s; below 0: towards it
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
    /// How it closes. @param outside  pressure of the tissue around it, Pa
    collapse collapsed(float outside) const { return {.radius = radius(), .outside = outside, .inside = pressure}; }
};

/// The velocity of the blood in all vessels of a body: a `velocity_field`.
struct blood_flow {
    std::vector<tube_flow> tubes{}; ///< one for each vessel, in this order

    /// See `velocity_field`. Where branches meet, that of the first vessel in which the point lies.
    vec3 operator()(object_id object, vec3 point, float time) const {
        for (const tube_flow& one : tubes)
            if (one.object == object)
                if (const vec3 velocity = one(object, point, time); velocity != vec3{0, 0, 0}) return velocity;
        return {0, 0, 0};
    }
};

/// @param heart_rate  beats per second, such as 1.2_Hz; 0: systole that lasts
/// @throws usage_error  for a vessel whose blood is not in the body
inline blood_flow flow_of(const scene& body, const std::vector<vessel>& vessels, float heart_rate) {
    blood_flow all;
    for (const vessel& one : vessels) {
        const std::optional<object_id> blood = body.find(one.name);
        if (!blood)
            throw usage_error{"flow_of: there is no object '" + one.name + "', which a vessel names as its blood"};
        pulsatile waveform{.resistive_index = one.resistive_index};
        if (one.type == vessel::kind::artery) waveform.heart_rate = heart_rate;
        all.tubes.push_back({*blood, moved(one.line, inverse(body[*blood].at)), one.peak_velocity, waveform});
        all.tubes.back().check();
    }
    return all;
}

/// How vessels move, and the tissue around them: a map for `scene::deform`, which brings its inverse.
struct vessel_motion {
    std::vector<bent<pulsation>> arteries{};
    std::vector<bent<collapse>> veins{}; ///< those that are not quite open

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

/// @param beat     of an artery of `beat.radius`; that of others is in proportion to their radii
/// @param outside  pressure of the tissue around the veins, Pa
inline vessel_motion motion_of(const std::vector<vessel>& vessels, const pulsation& beat, float outside) {
    vessel_motion all;
    for (const vessel& one : vessels) {
        if (one.type == vessel::kind::artery && beat.amplitude != 0) all.arteries.push_back({one.line, beat});
        const collapse wall = one.collapsed(outside);
        if (one.type == vessel::kind::vein && wall.opening() < 1) all.veins.push_back({one.line, wall});
    }
    return all;
}

} // namespace anatomy

#endif
