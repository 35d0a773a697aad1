#ifndef INSONIFY_DIAGNOSE_HPP
#define INSONIFY_DIAGNOSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/validate.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/queries.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <insonify/tracing/read/automatic_tgc.hpp>
#include <cmath>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What `diagnose` found; nothing where both members are empty.
struct diagnosis {
    /// Why a picture may be empty, or not what was meant.
    enum class problem {
        pose,         ///< of the probe: not a rigid transform
        setting,      ///< of the probe or the acquisition is out of range
        no_objects,   ///< nothing was added, or nothing with faces
        not_built,    ///< `build` must be called
        not_updated,  ///< `update` must be called
        one_medium,   ///< all objects are filled with the background's
        unit,         ///< of the meshes or the depth: one is far too large or small for the other
        inside,       ///< the probe is in a medium that lets no sound out, or in an object whose surface is too deep
        behind,       ///< the objects are behind the probe
        too_shallow,  ///< the lines end before the first surface
        beside,       ///< the objects are beside the field of view
        open_surface, ///< a mesh does not enclose a volume
        inside_out,   ///< an object has been turned inside out since it was added
        attenuation,  ///< takes more than automatic gain restores: most of the picture is dark
    };
    std::vector<problem> problems{}; ///< the most likely cause first
    std::string sentence{};          ///< for each problem what is wrong and what to do about it
};

namespace detail {

/// A length as three digits and a unit: "43 mm".
inline std::string shown(float metres) {
    if (metres < 0.9995e-3F) return number_text(1e6F * metres, 3) + " um";
    if (metres < 0.9995F) return number_text(1e3F * metres, 3) + " mm";
    return metres < 999.5F ? number_text(metres, 3) + " m" : number_text(std::round(metres), 9) + " m";
}

/// Distance from the field of view to the nearest surface, metres, by alternating projections from three places of the
/// field. Never an underestimate; within one percent where the field spans less than half a circle, of convex objects.
template <transducer Probe>
float distance_beside(const scene& body, const Probe& probe, const pose& at, float depth) {
    const float end = static_cast<float>(probe.lines) - 0.5F;
    float nearest = FLT_MAX;
    for (const object& one : body.objects())
        for (const float line : {-0.5F, 0.5F * end, end}) {
            vec3 in_field = probe.beam(line).at(0.5F * depth);
            for (int i = 0; i < 32; ++i) {
                const auto surface = nearest_surface(body, one.id, at.point(in_field));
                if (!surface) break;
                nearest = min(nearest, surface->distance);
                const vec3 p = at.local_point(surface->point);
                const ray beam = probe.beam(clamp(probe.locate({p.x, p.z}).x, -0.5F, end));
                in_field = beam.at(clamp(dot(p - beam.origin, beam.direction), 0, depth));
            }
        }
    return nearest;
}

/// The sentence about a scene that is 30 times larger than the lines are deep, or 300 times smaller; empty for others.
/// The unit that was given is not known, so every mistake is named that leaves objects of 2 cm to 2.5 m.
inline std::string unit_fault(float size, float depth) {
    const bool too_large = size > 30 * depth && size > 1, too_small = size > 0 && size < depth / 300;
    if (!too_large && !too_small) return {};
    struct mistake {
        float factor;
        const char* given;
        const char* meant;
    };
    constexpr mistake large[] = {{10, "1_cm", "1_mm"}, {100, "1_m", "1_cm"}, {1000, "1_m", "1_mm"}};
    constexpr mistake small[] = {{0.1F, "1_mm", "1_cm"}, {0.01F, "1_cm", "1_m"}, {0.001F, "1_mm", "1_m"}};
    std::string likely;
    for (const mistake& one : too_large ? large : small)
        if (const float meant = size / one.factor; 0.02F <= meant && meant <= 2.5F)
            likely += (likely.empty() ? "" : ", or ") + std::string{one.given} + " where " + one.meant +
                      " was meant (" + shown(meant) + ")";
    return "The objects are " + shown(size) + " across, but the lines " + shown(depth) +
           " deep: check the unit of the mesh" + (likely.empty() ? "" : "; it is probably " + likely) + ".";
}

} // namespace detail

/// Finds why a picture is empty, and explains it in plain sentences; `explain` does so for a single mesh.
///
/// Throws only for lack of memory. Cost: up to some seconds for a million faces.
/// @param at  probe to world
template <transducer Probe>
diagnosis diagnose(const scene& body, const Probe& probe, const pose& at, const acquisition& scan) {
    using namespace detail;
    using problem = diagnosis::problem;
    diagnosis found;
    const auto report = [&](problem what, const std::string& sentence) -> diagnosis& {
        found.problems.push_back(what);
        found.sentence += (found.sentence.empty() ? "" : " ") + sentence;
        return found;
    };
    if (!is_rigid(at))
        return report(problem::pose, "The pose of the probe is not a rigid transform, or not finite; make it with "
                                     "look_at, or mend it with orthonormalised.");
    try {
        probe.check();
        check_depth(scan.depth, "acquisition");
        check_planes(scan.planes, "acquisition");
        checked_samples(probe.lines, scan.samples, "acquisition");
    } catch (const usage_error& refused) {
        const std::string sentence = refused.what();
        return report(problem::setting, sentence + (sentence.ends_with('?') ? "" : "."));
    }
    bool has_faces = false;
    for (const object& one : body.objects()) has_faces = has_faces || !one.surface.faces.empty();
    if (!has_faces)
        return report(problem::no_objects,
                      "The scene has no object with faces; add one, or check the file it came from.");
    if (!body.is_built())
        return report(problem::not_built, "The scene is not built; call build(policy) after the last add or remove.");
    for (const object& one : body.objects())
        if (body.awaits_update(one.id))
            return report(problem::not_updated, "The positions of " + named(one.name, one.id) +
                                                    " were handed out since the last update; call update(policy).");
    if (body.media().size() == 1)
        report(problem::one_medium, "Every object has the medium of the background, so no surface echoes; give the "
                                    "objects, or the background, another one.");

    const scene_view flat = body.view_for_rays(exec::par);
    float ahead = FLT_MAX, behind = FLT_MAX; // metres to the first surface on any line, and backwards
    const auto line_of = [&](std::uint32_t number) {
        const ray beam = probe.beam(static_cast<float>(number));
        return ray{.origin = at.point(beam.origin), .direction = at.direction(beam.direction)};
    };
    for (std::uint32_t i = 0; i < probe.lines; ++i) {
        const ray line = line_of(i);
        const auto first = [&](vec3 direction, float from) {
            const auto surface =
                first_surface(body, {.origin = line.origin, .direction = direction, .min_distance = from});
            return surface ? surface->distance : FLT_MAX;
        };
        ahead = min(ahead, first(line.direction, touching_distance)); // nearer: of the face of the probe
        behind = min(behind, first(-line.direction, 0));
    }
    const vec3 face = line_of(probe.lines / 2).at(touching_distance);
    const object_view* const starts_in = top_at(flat, face); // null: the background
    const object_id start_id{starts_in == nullptr ? ~0U : starts_in->id};
    const std::string start = starts_in == nullptr ? "the background" : named(body[start_id].name, start_id);
    if (blocks_sound(flat.media[starts_in == nullptr ? 0 : starts_in->medium]))
        report(problem::inside,
               "The probe is in " + start +
                   ", whose medium lets almost no sound out; put the face of the probe on tissue, gel or "
                   "water.");
    const vec3 sides = body.box().size();
    const float size = max(sides.x, max(sides.y, sides.z));
    const bool too_deep = size > 0 && scan.depth > 30 * size && scan.depth > 1;
    if (too_deep)
        report(problem::unit, "The objects are " + shown(size) + " across, but the lines " + shown(scan.depth) +
                                  " deep: `depth` is in metres; write it as in 80_mm.");
    if (ahead > scan.depth) {
        const std::string wrong_unit = too_deep ? std::string{} : unit_fault(size, scan.depth);
        if (!wrong_unit.empty())
            report(problem::unit, wrong_unit);
        else if (starts_in != nullptr && ahead < FLT_MAX)
            report(problem::inside, "The probe is inside " + start + ", whose surface is " + shown(ahead) +
                                        " away along the lines, deeper than the " + shown(scan.depth) +
                                        " shown; raise `depth`.");
        else if (ahead < FLT_MAX)
            report(problem::too_shallow, "No line meets any object: the nearest surface on a line is " + shown(ahead) +
                                             " deep, the lines end at " + shown(scan.depth) + "; raise `depth`.");
        else if (behind < FLT_MAX)
            report(problem::behind, "No line meets any object: they are behind the probe, which looks away from them; "
                                    "turn it round (look_at(from, towards, lateral)).");
        else
            report(problem::beside, "No line meets any object: the nearest surface is " +
                                        shown(distance_beside(body, probe, at, scan.depth)) +
                                        " outside the field of view; move the probe or the objects.");
    }
    for (const object& one : body.objects())
        if (const mesh_report mesh = validate(one.surface); !mesh.closed())
            report(problem::open_surface,
                   "The surface of " + named(one.name, one.id) + " is not closed: " + explain(mesh));
        else if (body.is_inside_out(one.id))
            report(problem::inside_out, "The vertices of " + named(one.name, one.id) +
                                            " were moved so that it is inside out: its faces point the other way than "
                                            "when it was added; check the simulation, or the formula, that moves it.");
    if (found.problems.empty()) {
        constexpr float dark_db = 20; // a third of the usual dynamic range
        const float half_depth = scan.depth / 2;
        const path_survey half =
            survey_paths(layer_search{}(exec::par, body, probe, at, {.depth = scan.depth}, half_depth, false),
                         probe.frequency, half_depth);
        const float bandwidth = fractional_bandwidth(probe),
                    lost = attenuated(half.loss_db, probe.frequency, bandwidth).loss_db,
                    gain =
                        tgc_settings{.attenuation = clamp(half.attenuation, 50, 100), .bandwidth = bandwidth}.gain_db(
                            half.length, scan.depth, probe.frequency);
        if (lost > gain + dark_db)
            report(problem::attenuation, "Echoes from half the depth lose " + number_text(std::round(lost)) +
                                             " dB, and automatic gain restores " + number_text(std::round(gain)) +
                                             " dB: the picture is dark below; lower the frequency or `depth`.");
    }
    return found;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
