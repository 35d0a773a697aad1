#ifndef INSONIFY_SCENE_DIAGNOSE_HPP
#define INSONIFY_SCENE_DIAGNOSE_HPP

#include <insonify/core/later.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/scene/field_distance.hpp>
#include <insonify/scene/line_layers.hpp>
#include <cstdio>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Why a picture may be empty, or not what was meant.
enum class problem {
    pose,         ///< of the probe: no rigid motion
    setting,      ///< of the probe or the acquisition
    no_objects,   ///< nothing was added, or nothing with faces
    not_built,    ///< `build` is due
    not_updated,  ///< `update` is due
    one_medium,   ///< all objects are filled with the background's
    unit,         ///< of the meshes or the depth: one is far too large or small for the other
    inside,       ///< the probe stands in something that lets no sound out, or in an object whose surface is too deep
    behind,       ///< the objects are behind the probe
    too_shallow,  ///< the lines end before the first surface
    beside,       ///< the objects are beside the field of view
    open_surface, ///< a mesh does not enclose anything for certain
};

/// What `diagnose` found; nothing where both are empty.
struct diagnosis {
    std::vector<problem> problems{}; ///< the most likely cause first
    std::string sentence{};          ///< for each problem what is wrong and what to do about it
};

/// Looks for what makes a picture empty, and says it in plain sentences; `explain` does so for a single mesh.
///
///     std::puts(diagnose(body, probe, at, {.depth = 40_mm}).sentence.c_str());
///     // No line meets any object: the nearest surface is 43 mm outside the field of view; move the probe or the objects.
///
/// Never throws but for lack of memory. Cost: up to some seconds for a million faces.
/// @param at  probe to world
template <transducer Probe>
diagnosis diagnose(const scene& body, const Probe& probe, const pose& at, const acquisition& scan);

/// The steps of `diagnose`.
namespace diagnosing {

/// A length as three digits and a unit: "43 mm".
INSONIFY_LAZY std::string shown(float metres) {
    const char* unit = metres < 0.9995e-3F ? " um" : metres < 0.9995F ? " mm" : " m";
    const double value = static_cast<double>(metres) * (metres < 0.9995e-3F ? 1e6 : metres < 0.9995F ? 1e3 : 1);
    char text[48];
    std::snprintf(text, sizeof text, value < 999.5 ? "%.3g" : "%.0f", value);
    return std::string{text} + unit;
}

/// An object by its name, or by its id where it has none.
INSONIFY_LAZY std::string named(const object& one) {
    return one.name.empty() ? "object " + std::to_string(static_cast<std::uint32_t>(one.id))
                            : "object '" + one.name + "'";
}

/// Calls visit(distance) for every crossing of a ray with an object, through its tree where that is up to date.
template <class Visit>
void for_each_crossing(const object& one, const ray& r, const Visit& visit) {
    const ray local = one.local(r);
    if (one.tree_follows) return one.tree_view().for_each_hit(local, [&](const hit& found) { visit(found.distance); });
    const sheared_ray sheared{local};
    const mesh_view surface{one.surface};
    for (std::size_t i = 0; i < surface.size(); ++i)
        if (const hit found = intersect(sheared, surface[i]); found && found.distance >= 0) visit(found.distance);
}

/// What the lines of a probe meet, were they endless.
struct line_survey {
    float ahead = FLT_MAX;          ///< metres to the first surface on any line
    float behind = FLT_MAX;         ///< the same, backwards
    const object* around = nullptr; ///< that gives the medium where the middle line begins
};
/// Follows every line of a probe, which stands in the world as `at` says, both ways and without end.
template <transducer Probe>
line_survey survey(const scene& body, const Probe& probe, const pose& at) {
    line_survey found;
    for (std::uint32_t i = 0; i < probe.lines; ++i) {
        const ray beam = probe.beam(static_cast<float>(i));
        const ray line{.origin = at.point(beam.origin), .direction = at.direction(beam.direction)};
        const ray back{.origin = line.origin, .direction = -line.direction};
        for (const object& one : body.objects()) {
            std::uint32_t crossed = 0;
            for_each_crossing(one, line, [&](float distance) {
                found.ahead = lesser(found.ahead, distance);
                ++crossed;
            });
            for_each_crossing(one, back, [&](float distance) { found.behind = lesser(found.behind, distance); });
            const bool gives_medium = found.around == nullptr || one.rank < found.around->rank;
            if (i == probe.lines / 2 && crossed % 2 == 1 && gives_medium) found.around = &one;
        }
    }
    return found;
}

/// Metres from the field of view to the nearest surface.
template <transducer Probe>
float distance_beside(const scene& body, const Probe& probe, const pose& at, float depth) {
    float nearest = FLT_MAX;
    for (const object& one : body.objects()) {
        const pose to_probe = inverse(at) * one.at;
        const mesh_view surface{one.surface};
        for (std::size_t i = 0; i < surface.size(); ++i) {
            const triangle t = surface[i];
            const triangle face{to_probe.point(t.a), to_probe.point(t.b), to_probe.point(t.c)};
            if (!is_finite(bounds(face))) continue;
            const float reach = greater(length(face.b - face.a), length(face.c - face.a));
            if (length(face.a - nearest_in_field(probe, depth, face.a)) - reach > nearest) continue;
            nearest = lesser(nearest, distance_to_field(probe, depth, face));
        }
    }
    return nearest;
}

/// Impedances that tissue is not near: from them to it next to no sound passes.
INSONIFY_LAZY bool keeps_sound(const medium& m) { return m.impedance() > 3e6F || m.impedance() < 3e5F; }

/// What is wrong with the unit, if anything: the scene is 30 times larger than the lines are deep, or 300 times smaller.
INSONIFY_LAZY std::string unit_fault(const aabb& box, float depth) {
    const vec3 sides = box.size();
    const float size = greater(sides.x, greater(sides.y, sides.z));
    const auto sentence = [&](const char* used, const char* meant) {
        return "The objects are " + shown(size) + " across, but the lines " + shown(depth) +
               " deep: the unit is probably " + used + " where " + meant + " was meant.";
    };
    if (size > 30 * depth && size > 1) return size > 5 ? sentence("1_m", "1_mm") : sentence("1_m", "1_cm");
    if (size > 0 && size < depth / 300) return sentence("1_mm", "1_m");
    return {};
}

/// What is wrong with the depth, if anything: it is more than a metre, and 30 times the size of the scene.
INSONIFY_LAZY std::string depth_fault(const aabb& box, float depth) {
    const vec3 sides = box.size();
    const float size = greater(sides.x, greater(sides.y, sides.z));
    if (!(size > 0 && depth > 30 * size && depth > 1)) return {};
    return "The objects are " + shown(size) + " across, but the lines " + shown(depth) +
           " deep: `depth` is in metres; write it as in 80_mm.";
}

} // namespace diagnosing

template <transducer Probe>
diagnosis diagnose(const scene& body, const Probe& probe, const pose& at, const acquisition& scan) {
    using namespace diagnosing;
    later_t<Probe, diagnosis> found;
    const auto tell = [&](problem what, const std::string& sentence) -> diagnosis& {
        found.problems.push_back(what);
        found.sentence += (found.sentence.empty() ? "" : " ") + sentence;
        return found;
    };
    if (!is_rigid(at))
        return tell(problem::pose, "The pose of the probe is no rigid motion, or not finite; make it with look_at.");
    try {
        probe.check();
    } catch (const usage_error& refused) {
        return tell(problem::setting, std::string{refused.what()} + ".");
    }
    if (!is_depth(scan.depth))
        return tell(problem::setting, "The depth is no number of metres above 0; write it as in 80_mm.");
    bool has_faces = false;
    for (const object& one : body.objects()) has_faces = has_faces || !one.surface.faces.empty();
    if (!has_faces)
        return tell(problem::no_objects,
                    "The scene holds no object with faces; add one, or check the file it came from.");
    if (!body.is_built())
        return tell(problem::not_built, "The scene is not built; call build(policy) after the last add or remove.");
    for (const object& one : body.objects())
        if (one.moved)
            return tell(problem::not_updated, "The positions of " + named(one) +
                                                  " were handed out since the last update; call update(policy).");
    if (body.media().size() == 1)
        tell(problem::one_medium,
             "Every object has the medium of the background, so no surface echoes; give the objects, "
             "or the background, another one.");

    const line_survey lines = survey(body, probe, at);
    if (lines.around != nullptr && keeps_sound(lines.around->inside))
        tell(problem::inside, "The probe stands inside " + named(*lines.around) +
                                  ", whose medium lets next to no sound out; move the probe out of it.");
    const std::string too_deep = depth_fault(body.box(), scan.depth);
    if (!too_deep.empty()) tell(problem::unit, too_deep);
    if (lines.ahead > scan.depth) {
        if (const std::string wrong = unit_fault(body.box(), scan.depth); too_deep.empty() && !wrong.empty())
            tell(problem::unit, wrong);
        else if (lines.around != nullptr && lines.ahead < FLT_MAX)
            tell(problem::inside, "The probe stands inside " + named(*lines.around) + ", whose surface is " +
                                      shown(lines.ahead) + " away along the lines, deeper than the " +
                                      shown(scan.depth) + " shown; raise `depth`.");
        else if (lines.ahead < FLT_MAX)
            tell(problem::too_shallow, "No line meets any object: the nearest surface on a line is " +
                                           shown(lines.ahead) + " deep, the lines end at " + shown(scan.depth) +
                                           "; raise `depth`.");
        else if (lines.behind < FLT_MAX)
            tell(problem::behind,
                 "No line meets any object: they are behind the probe, which looks away from them; turn "
                 "it round (look_at(from, towards, lateral)).");
        else
            tell(problem::beside, "No line meets any object: the nearest surface is " +
                                      shown(distance_beside(body, probe, at, scan.depth)) +
                                      " outside the field of view; move the probe or the objects.");
    }
    for (const object& one : body.objects())
        if (const mesh_report report = validate(one.surface); !report.closed())
            tell(problem::open_surface, "The surface of " + named(one) + " is not closed: " + explain(report));
    return found;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
