#ifndef INSONIFY_EXAMPLES_ANATOMY_REGION_HPP
#define INSONIFY_EXAMPLES_ANATOMY_REGION_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/motion/press.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/scanner.hpp>
#include <insonify/scene/scene.hpp>
#include "vessel.hpp"
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

/// Regions of the body by code: what every region gives to the programs that use it. Lengths are metres.
namespace anatomy {

using namespace insonify;

/// Where a needle enters the skin, and where to.
struct needle_path {
    vec3 entry{0, 0, 0};  ///< on the skin
    vec3 target{0, 0, 0}; ///< of its tip
};

/// A standard view of a region.
struct view {
    std::string name{};  ///< such as "carotid_transverse"
    std::string title{}; ///< in words
    pose at{};           ///< the middle of the probe's face is on the skin, under a film of gel; z points into the body
    std::variant<linear_array, convex_array, phased_array> probe{}; ///< what such a view is taken with
    b_mode_settings settings{};                                     ///< the same
    std::optional<needle_path> needle{};                            ///< where the view is one for a needle
    float pressed = 2.5_mm; ///< by which an operator presses the face into the skin, along z: see `press`
};

/// A region of the body.
struct body {
    /// Not built: add tools, then call `build`. Its background is what an operator finds between the structures. An
    /// object "gel" lies on the skin, of the lowest priority. All names differ.
    scene anatomy{};
    std::vector<view> views{};                                 ///< the first is the one to begin with
    std::vector<vessel> vessels{};                             ///< in which blood flows
    std::vector<std::pair<std::string, std::string>> nested{}; ///< what lies in what: names of objects, inner and outer

    /// The velocity of the blood, for Doppler: in coordinates of the objects, so that it moves with them.
    /// @param heart_rate  beats per second; 0: as in systole, steadily
    blood_flow flow(float heart_rate = 1.2_Hz, const contact_pressure& under = {}) const {
        return flow_of(anatomy, vessels, heart_rate, under);
    }
    /// How arteries pulse, and veins collapse under the face of a probe: a map for `scene::deform`, of the body at rest.
    /// @param beat  of an artery of `beat.radius`; that of others is in proportion to their radii
    vessel_motion motion(const pulsation& beat, const contact_pressure& under = {}) const {
        return motion_of(vessels, beat, under);
    }

    /// @throws usage_error  where there is no view of that name
    const view& find_view(const std::string& name) const {
        std::string known;
        for (const view& one : views) {
            if (one.name == name) return one;
            known += (known.empty() ? "" : ", ") + one.name;
        }
        throw usage_error{"there is no view '" + name + "'; known are " + known};
    }
};

/// Whether what a medium fills does not give way to a probe: bone and cartilage. Tendon is softer, and so is lung.
inline bool is_stiff(const medium& inside) {
    const medium& softest = tissue::cartilage;
    return inside.sound_speed >= softest.sound_speed && inside.attenuation >= softest.attenuation;
}

/// Presses the probe of a view into the skin as an operator does: bone and cartilage stay, the tissue above them gives
/// way. @return  the pose of the probe
inline pose press_probe(scene& anatomy, const view& seen) {
    pose at = seen.at;
    at.translation += at.direction({0, 0, seen.pressed});
    const auto in_body = [&](object_id id) { return anatomy[id].name != "gel" && anatomy[id].name != "needle"; };
    const auto gives_no_way = [&](object_id id) { return is_stiff(anatomy[id].inside); };
    std::visit(
        [&](const auto& probe) {
            anatomy.deform(exec::par, press(anatomy, probe, at, {}, in_body, gives_no_way).deformation);
        },
        seen.probe);
    return at;
}

/// A body that is larger by a factor: shapes, views and vessels, but not the grain of its media.
inline body enlarged(body made, float size) {
    scene larger{made.anatomy.background()};
    for (const object& one : made.anatomy.objects()) {
        mesh surface = one.surface;
        for (vec3& p : surface.positions) p *= size;
        object_settings settings = one;
        if (one.fibres.varies()) settings.fibres = [of = one.fibres, size](vec3 p) { return of(p / size); };
        if (one.layer_normal.varies() && !one.layer_normal.follows_surface())
            settings.layer_normal = [of = one.layer_normal, size](vec3 p) { return of(p / size); };
        larger.add(std::move(surface), one.inside, settings);
    }
    made.anatomy = std::move(larger);
    for (view& one : made.views) {
        one.at.translation *= size;
        one.settings.depth *= size;
        if (one.needle) one.needle = needle_path{size * one.needle->entry, size * one.needle->target};
    }
    for (vessel& one : made.vessels)
        for (tube_section& place : one.line) {
            place.centre *= size;
            place.radii *= size;
        }
    return made;
}

/// A unit that values of a parameter are written in, and how much of the parameter's own it is.
struct parameter_unit {
    const char* name = "";
    float size = 1;
};

/// What varies from body to body: a size, or a choice.
struct parameter {
    const char* name = "";        ///< such as "fat"
    const char* unit = "";        ///< "m", "rad"; "" for a ratio or a choice
    const char* description = ""; ///< in words; those of a choice list the numbers
    float smallest = 0;
    float largest = 1;
    float usual = 0;        ///< the default
    bool is_choice = false; ///< a whole number

    /// The unit that users of programs write and read: millimetres and degrees.
    parameter_unit written_unit() const {
        const std::string own = unit;
        if (own == "m") return {"mm", 1_mm};
        if (own == "rad") return {"deg", 1_deg};
        return {unit, 1};
    }
};

/// A value of a parameter. One beyond a limit by no more than that is rounded in text, or in another unit, is the limit.
/// @param in     the unit of the message
/// @param whose  begins the message, such as "neck: "
/// @throws usage_error  for a value out of range
inline float checked(const parameter& one, float value, const parameter_unit& in, const std::string& whose = "") {
    constexpr float rounding = 5e-4F; // of `number_text`
    const float nearest = clamp(value, one.smallest, one.largest);
    const float tolerance = one.is_choice ? 0 : rounding * std::fabs(nearest);
    if (std::fabs(value - nearest) <= tolerance && (!one.is_choice || value == std::round(value))) return nearest;
    const auto text = [&](float number) {
        return insonify::detail::number_text(number / in.size) + (*in.name ? std::string{" "} + in.name : "");
    };
    throw usage_error{whose + "`" + one.name + "` is " + text(value) + "; it must be " +
                      (one.is_choice ? "a whole number " : "") + "from " + text(one.smallest) + " to " +
                      text(one.largest) + ": " + one.description};
}

/// Values by the names of their parameters. What is missing has its default.
using values = std::map<std::string, float>;

/// A region that can be made.
struct region {
    const char* name = "";  ///< such as "neck"
    const char* title = ""; ///< in words
    std::vector<parameter> parameters{};
    body (*make_checked)(const values&) = nullptr; ///< of all values

    /// @throws usage_error  for a name that is not a parameter's
    const parameter& find_parameter(const std::string& named) const {
        std::string known;
        for (const parameter& one : parameters) {
            if (one.name == named) return one;
            known += std::string{known.empty() ? "" : ", "} + one.name;
        }
        throw usage_error{std::string{name} + ": there is no parameter '" + named + "'; " +
                          (known.empty() ? "it has none: it is always the same" : "known are " + known)};
    }

    /// A value of one of them. @param in  the unit of the message  @throws usage_error  for a value out of range
    float checked(const parameter& one, float value, const parameter_unit& in) const {
        return anatomy::checked(one, value, in, std::string{name} + ": ");
    }

    /// All values: those that are given, and the defaults of the others.
    /// @throws usage_error  for a name that is not a parameter's, and a value out of range
    values completed(const values& given) const {
        values all;
        for (const parameter& one : parameters) all[one.name] = one.usual;
        for (const auto& [named, value] : given) {
            const parameter& one = find_parameter(named);
            all[named] = checked(one, value, {one.unit});
        }
        return all;
    }

    /// The region with values for some of its parameters.
    /// @throws usage_error  for a name that is not a parameter's, and a value out of range
    body make(const values& given = {}) const { return make_checked(completed(given)); }

    /// Random values of all parameters but `resolution`. A size is the mean of two uniform numbers: extremes are rare.
    values drawn(std::uint64_t seed) const {
        values all;
        for (std::size_t i = 0; i < parameters.size(); ++i) {
            const parameter& one = parameters[i];
            if (std::string{one.name} == "resolution") continue;
            const float first = hash_uniform(seed, 2 * i), second = hash_uniform(seed, 2 * i + 1);
            const float part = one.is_choice ? first : 0.5F * (first + second);
            all[one.name] = one.is_choice ? one.smallest + std::floor(part * (one.largest - one.smallest + 1))
                                          : one.smallest + part * (one.largest - one.smallest);
        }
        return all;
    }
};

/// A parameter as a member of a region's own struct.
template <class Parameters>
struct member {
    const char *name = "", *unit = "", *description = "";
    float Parameters::*of = nullptr;
    float smallest = 0, largest = 1;
    bool is_choice = false;
};

/// The body of some parameters, one of which is its `size`. Lengths that are parameters are what they say in a body of any size.
/// @param make_usual  body(const Parameters&): the body of the usual size
/// @throws usage_error  for a value out of range
template <class Parameters, class MakeUsual>
body make_in_size(const Parameters& of, const MakeUsual& make_usual) {
    Parameters usual = of;
    for (const member<Parameters>& one : Parameters::members()) {
        float& value = usual.*one.of;
        value = checked({one.name, one.unit, one.description, one.smallest, one.largest, 0, one.is_choice}, value,
                        {one.unit});
        if (std::string{one.unit} == "m") value /= of.size;
    }
    usual.resolution *= min(of.size, 1); // as many cells in a small body
    usual.size = 1;
    return of.size == 1 ? make_usual(usual) : enlarged(make_usual(usual), of.size);
}

/// The region whose parameters a struct holds: `Parameters::members()` lists them, `make` makes its body.
template <class Parameters>
region region_of(const char* name, const char* title) {
    region made{name, title, {}, [](const values& all) {
                    Parameters own;
                    for (const member<Parameters>& one : Parameters::members()) own.*one.of = all.at(one.name);
                    return make(own);
                }};
    const Parameters usual;
    for (const member<Parameters>& one : Parameters::members())
        made.parameters.push_back(
            {one.name, one.unit, one.description, one.smallest, one.largest, usual.*one.of, one.is_choice});
    return made;
}

} // namespace anatomy

#endif
