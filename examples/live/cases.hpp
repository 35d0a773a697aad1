#ifndef INSONIFY_EXAMPLES_LIVE_CASES_HPP
#define INSONIFY_EXAMPLES_LIVE_CASES_HPP

#include "../anatomy/regions.hpp"
#include "control.hpp"
#include "patient.hpp"
#include <array>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace live {

/// A case: a standard view of a region of the body.
struct case_entry {
    literal title{};
    const char *region = "", *view = "";
};

/// All views of all regions (`tests/cases.cpp` compares). The first is the one to begin with.
inline constexpr case_entry cases[] = {
    {"Nerve block phantom", "nerve_block", "nerve_block"},
    {"Neck: carotid, across", "neck", "carotid_transverse"},
    {"Neck: carotid, lengthwise", "neck", "carotid_lengthwise"},
    {"Neck: carotid, division", "neck", "carotid_division"},
    {"Neck: thyroid", "neck", "thyroid"},
    {"Neck: interscalene block", "neck", "interscalene"},
    {"Leg: femoral block", "leg", "femoral_block"},
    {"Leg: vastus lateralis, lengthwise", "leg", "vastus_lateralis_lengthwise"},
    {"Leg: calf, lengthwise", "leg", "calf_lengthwise"},
    {"Leg: calf, across", "leg", "calf_transverse"},
    {"Leg: thigh, across", "leg", "thigh_transverse"},
    {"Leg: calf to the bones, across", "leg", "calf_deep_transverse"},
    {"Abdomen: liver, subcostal", "right_upper_quadrant", "subcostal"},
    {"Abdomen: liver, intercostal", "right_upper_quadrant", "intercostal"},
    {"Abdomen: gallbladder", "right_upper_quadrant", "gallbladder"},
    {"Abdomen: Morison's pouch", "right_upper_quadrant", "morison"},
    {"Abdomen: emergency, phased array", "right_upper_quadrant", "trauma"},
    {"Lumbar spine: paramedian oblique", "lumbar", "paramedian_oblique"},
    {"Lumbar spine: across, between laminae", "lumbar", "transverse_interlaminar"},
    {"Lumbar spine: across, spinous process", "lumbar", "transverse_spinous"},
};

/// The number of a case. @param view  of the region; empty: its first one
/// @throws usage_error  where there is no such region or view
inline std::uint32_t find_case(const std::string& region, const std::string& view) {
    static_cast<void>(::anatomy::find_region(region));
    std::string known;
    for (std::uint32_t i = 0; i < std::size(cases); ++i) {
        if (cases[i].region != region) continue;
        if (view.empty() || cases[i].view == view) return i;
        known += std::string{known.empty() ? "" : ", "} + cases[i].view;
    }
    throw usage_error{"there is no view '" + view + "'; known are " + known};
}

/// Values of some parameters of a region, for all of its bodies.
struct region_parameters {
    std::string region{}; ///< empty: none
    ::anatomy::values values{};

    friend bool operator==(const region_parameters&, const region_parameters&) = default;
};

/// Values of parameters that a region has. @throws usage_error  for another name, or a value out of range
inline region_parameters checked(const std::string& region, const ::anatomy::values& values) {
    static_cast<void>(::anatomy::find_region(region).completed(values));
    return {region, values};
}

inline constexpr std::uint32_t max_patient = 9999; ///< see `examine`

/// What a session examines, and how it begins: the probe on the skin, the settings, and the needle.
struct examined {
    scene body{};
    std::vector<vessel> vessels{};
    array_probe probe = nerve_block::probe;
    b_mode_settings settings = nerve_block::settings;
    hand_state hand{};
    std::optional<float>
        face{}; ///< z of the middle of the face in the world; none: as far from the skin as `hand` says
    needle_state needle{};
    bool enters = false; ///< the entry of the needle is on the skin; else it is moved there along z
};

/// A body of its own: the probe begins above the middle of its skin, and its vessels are found by their names.
inline examined examine(scene body) {
    examined made{.vessels = find_vessels(body)};
    if (!body.is_built()) body.build(exec::par);
    if (const aabb whole = body.box(); !whole.empty() && !body.find("nerve")) {
        made.hand.from =
            made.hand.on_skin = {0.5F * (whole.lower.x + whole.upper.x), 0.5F * (whole.lower.y + whole.upper.y)};
        made.needle.entry = {made.hand.on_skin.x - 24_mm, made.hand.on_skin.y, 0};
    }
    made.body = std::move(body);
    return made;
}

/// The body of a case, in the world of a session: that of the view's probe. The skin is below the face, and z points into the
/// body.
/// @param patient  draws the parameters of the region; 0: the usual ones
/// @param given    values that stay; those of another region do not count
/// @throws usage_error  for a parameter that the region does not have, or a value out of range
inline examined examine(const case_entry& one, std::uint32_t patient, const region_parameters& given) {
    constexpr float between_sections = 4_mm; // of vessels, whose course is computed for each vertex
    constexpr float resolution = 0.5F;       // a quarter of the triangles, which move at each frame
    const ::anatomy::region& region = ::anatomy::find_region(one.region);
    ::anatomy::values values = patient > 0 ? region.drawn(patient) : ::anatomy::values{};
    if (!region.parameters.empty()) values["resolution"] = resolution;
    if (given.region == one.region)
        for (const auto& [name, value] : given.values) values[name] = value;
    ::anatomy::body body = region.make(values);
    const ::anatomy::view& seen = body.find_view(one.view);
    const pose to_world = inverse(seen.at);

    examined made;
    std::visit([&](const auto& array) { made.probe = array; }, seen.probe);
    made.settings = seen.settings;
    made.vessels = std::move(body.vessels);
    for (vessel& each : made.vessels)
        each.line = ::anatomy::moved(::anatomy::thinned(each.line, between_sections), to_world);
    for (std::size_t i = 0; i < body.anatomy.objects().size(); ++i) {
        const object& each = body.anatomy.objects()[i];
        body.anatomy.place(each.id, to_world * each.at);
    }
    const bool is_phantom = region.parameters.empty(); // whose probe rests on its gel, and its needle beside the probe
    if (!is_phantom) made.face = seen.pressed;
    if (seen.needle && !is_phantom) {
        made.enters = true;
        made.needle.entry = to_world.point(seen.needle->entry);
        made.needle.aim(to_world.point(seen.needle->target));
    } else
        made.needle.entry = {-0.5F * made.probe.face_width() - 5_mm, 0, 0};
    made.body = std::move(body.anatomy);
    return made;
}

} // namespace live

#endif
