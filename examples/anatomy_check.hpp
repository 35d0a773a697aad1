#ifndef INSONIFY_EXAMPLES_ANATOMY_CHECK_HPP
#define INSONIFY_EXAMPLES_ANATOMY_CHECK_HPP

#include <insonify/insonify.hpp>
#include <cstdio>
#include <string>
#include <vector>

/// A tissue of the library, as options name it.
/// @throws insonify::usage_error  for an unknown name, with those that there are
inline const insonify::medium& tissue_named(const std::string& name) {
    std::string known;
    for (const insonify::tissue::named_medium& one : insonify::tissue::all) {
        if (one.name == name) return one.value;
        known += std::string{known.empty() ? "" : ", "} + one.name;
    }
    throw insonify::usage_error{"there is no tissue '" + name + "'; known are " + known};
}

/// How an OBJ file is read. @param unit  length of 1 in it, metres  @param pennation  degrees: see `obj_settings`
inline insonify::obj_settings reading_of(float unit, const insonify::medium& background, bool repair, float pennation) {
    using namespace insonify;
    obj_settings settings{.unit = unit, .background = background, .pennation = pennation * 1_deg};
    if (repair) settings.repair = repair_settings{};
    return settings;
}

/// The size of a body, built or not.
inline insonify::vec3 size_of(const insonify::scene& body) {
    insonify::aabb box;
    for (const insonify::object& one : body.objects())
        for (const insonify::vec3 p : one.surface.positions) box = merged(box, one.at.point(p));
    return box.size();
}

/// Refuses what cannot be an anatomy: open surfaces, and a body smaller than 2 mm or larger than 3 m, which was read in the
/// wrong unit.
/// @param unit    that the file was read in, metres
/// @param choice  how the user chooses a unit, before its symbol
/// @param repair  how the user has open surfaces closed; empty: that has been tried
/// @throws insonify::geometry_error  naming the object and what to do, or the likely unit
inline void check_anatomy(const insonify::scene& body, const std::string& file, float unit,
                          const std::string& choice = "--unit 1", const std::string& repair = "--repair") {
    using namespace insonify;
    for (const object& one : body.objects())
        if (const mesh_report report = validate(one.surface); !report.closed())
            throw geometry_error{file + ": object '" + one.name + "': " + explain(report) +
                                 (repair.empty() ? "" : " Or " + repair + " may close it.")};
    const vec3 size = size_of(body);
    const float largest = max(size.x, max(size.y, size.z));
    if (largest >= 2_mm && largest <= 3) return;
    struct known {
        const char *name, *symbol;
        float length;
    };
    std::string advice = "; give the unit of the file, such as " + choice + "mm";
    for (const known& other : {known{"centimetres", "cm", 1_cm}, known{"millimetres", "mm", 1_mm},
                               known{"metres", "m", 1_m}}) // the last that fits is the most common one
        if (const float meant = largest / unit * other.length; meant >= 20_mm && meant <= 2.5F)
            advice = std::string{"; is the file in "} + other.name + "? " + choice + other.symbol;
    throw geometry_error{file + ": the body is " + detail::number_text(1e3F * largest) + " mm large" + advice};
}

/// What was read and in which unit: "limb.obj: 3 objects, 90 x 120 x 80 mm, where 1 in the file is 1 mm (--unit)".
/// @param notes  of `load_obj_scene`: a line each follows
inline std::string describe_anatomy(const std::string& file, const insonify::scene& body, float unit,
                                    const std::vector<std::string>& notes) {
    using namespace insonify;
    const vec3 size = size_of(body) / 1_mm;
    char text[160];
    std::snprintf(text, sizeof text, ": %zu object%s, %.4g x %.4g x %.4g mm, where 1 in the file is %g mm (--unit)",
                  body.objects().size(), body.objects().size() == 1 ? "" : "s", static_cast<double>(size.x),
                  static_cast<double>(size.y), static_cast<double>(size.z), static_cast<double>(unit / 1_mm));
    std::string lines = file + text;
    for (const std::string& note : notes) lines += '\n' + note;
    return lines;
}

#endif
