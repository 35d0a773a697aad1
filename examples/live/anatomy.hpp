#ifndef INSONIFY_EXAMPLES_LIVE_ANATOMY_HPP
#define INSONIFY_EXAMPLES_LIVE_ANATOMY_HPP

#include "../anatomy_check.hpp"
#include "session.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace live {

/// Where the skin of an anatomy may be.
inline constexpr const char* sides[] = {"+x", "-x", "+y", "-y", "+z", "-z"};

/// An anatomy from a file.
struct anatomy_file {
    std::string file{};  ///< Wavefront OBJ; empty: the phantom of a nerve block
    float unit = 1_mm;   ///< length of 1 in the file, metres
    std::string side{};  ///< of its skin, one of `sides`: the body is turned and moved; empty: it stays, +z inwards
    float skin = 1.5_mm; ///< thickness of skin below the surface of an object that encloses all others; 0: none
    bool repair = false; ///< closes and orients meshes that enclose nothing
    float pennation = 0; ///< of muscles without fibres of their own: angle to their long axis, degrees
    std::string tissue = "muscle";  ///< of all faces in a file without materials
    std::string background = "air"; ///< around its objects

    friend bool operator==(const anatomy_file&, const anatomy_file&) = default;
};

/// The name of a tissue; empty for another medium.
inline std::string tissue_name(const medium& inside) {
    for (const tissue::named_medium& one : tissue::all)
        if (one.value == inside) return one.name;
    return "";
}

namespace detail {

// Turned so that the side of the skin is at the top (-z), and moved so that the body begins at the depth 0, centred below the
// probe.
inline void turn_skin_up(scene& body, const std::string& named) {
    const auto found = std::find(std::begin(sides), std::end(sides), named);
    if (found == std::end(sides))
        throw usage_error{"the skin is at '" + named + "'; it must be at +x, -x, +y, -y, +z or -z"};
    constexpr vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const auto side = found - std::begin(sides), axis = side / 2;
    const vec3 down = side % 2 == 0 ? -axes[axis] : axes[axis];
    const auto place = [&](const pose& to) {
        for (std::size_t i = 0; i < body.objects().size(); ++i) {
            const object& one = body.objects()[i];
            body.place(one.id, to * one.at);
        }
    };
    place(inverse(look_at({0, 0, 0}, down, axis == 0 ? axes[1] : axes[0])));
    const aabb box = body.box();
    place({mat3{1}, {-0.5F * (box.lower.x + box.upper.x), -0.5F * (box.lower.y + box.upper.y), -box.lower.z}});
}

} // namespace detail

/// What a session is to examine.
struct anatomy_choice {
    anatomy_file file{};                        ///< without a name: a case
    std::optional<std::uint32_t> case_number{}; ///< see `cases`; none: the first one
    std::uint32_t patient = 0;                  ///< see `examine`
    region_parameters given{};                  ///< of the region of the case
};

/// The same, and the body of the file.
struct loaded_anatomy : anatomy_choice {
    scene body{};
    std::uint64_t content = 0;        ///< `content_of` the file: the skin that is added does not count
    std::vector<std::string> notes{}; ///< of `load_obj_scene`
};

/// A hash of the meshes, media and fibres of a body as it was loaded, wherever it has been placed: the same on every
/// processor, so directions, which are computed, count to a thousandth.
inline std::uint64_t content_of(const scene& body) {
    std::uint64_t hash = hash_of(nullptr, 0);
    const auto add = [&](std::initializer_list<float> numbers) {
        hash = hash_of(numbers.begin(), numbers.size(), hash);
    };
    const auto add_medium = [&](const medium& one) {
        add({one.density, one.sound_speed, one.attenuation, one.attenuation_power, one.backscatter, one.roughness});
    };
    add_medium(body.background());
    for (const object& one : body.objects()) {
        add_medium(one.inside);
        if (const vec3 along = one.fibres.varies() ? vec3{0} : one.fibres(vec3{0}); along != vec3{0})
            add({std::round(1000 * along.x), std::round(1000 * along.y), std::round(1000 * along.z)});
        for (const vec3& point : one.surface.positions) add({point.x, point.y, point.z});
        for (const uvec3& face : one.surface.faces)
            add({static_cast<float>(face.x), static_cast<float>(face.y), static_cast<float>(face.z)});
    }
    return hash;
}

/// Loads the anatomy of a file.
/// @param unit_choice, repair_choice  see `check_anatomy`
/// @throws std::runtime_error  for a file that cannot be read, an unknown tissue or side, or a mesh that is open, naming the
///                             object and what to do
inline loaded_anatomy load_anatomy(const anatomy_file& from, const std::string& unit_choice = "--unit 1",
                                   const std::string& repair_choice = "--repair") {
    loaded_anatomy loaded{{.file = from}};
    scene& body = loaded.body;
    const obj_settings settings = reading_of(from.unit, tissue_named(from.background), from.repair, from.pennation);
    std::ifstream file{from.file};
    const std::string text{std::istreambuf_iterator<char>{file}, {}};
    body = scene{settings.background};
    if (text.empty() || text.find("usemtl") != std::string::npos)
        body = load_obj_scene(from.file, settings, loaded.notes);
    else
        body.add(load_obj(from.file, settings, loaded.notes), tissue_named(from.tissue), {.name = from.tissue});
    check_anatomy(body, from.file, from.unit, unit_choice, from.repair ? "" : repair_choice);
    loaded.content = content_of(body);
    if (from.skin != 0) add_skin(body, {.thickness = from.skin});
    body.build(exec::par);
    if (!from.side.empty()) detail::turn_skin_up(body, from.side);
    return loaded;
}

/// What a session examines: a sentence, and what the body has otherwise than the file, a line each.
inline std::string describe(const loaded_anatomy& one) {
    const anatomy_file& of = one.file;
    if (!of.file.empty()) return describe_anatomy(of.file, one.body, of.unit, one.notes);
    const std::string title = cases[one.case_number.value_or(0)].title;
    return one.patient == 0 ? title : title + ", patient " + std::to_string(one.patient);
}

/// Begins a session. @param record  takes the case that it begins with; null: none
inline session begin_session(loaded_anatomy one, recorder* record = nullptr) {
    session begun = one.file.file.empty() ? session{} : session{std::move(one.body)};
    begun.record = record;
    begun.given = std::move(one.given);
    if (one.patient != 0) begun.apply({"patient", {static_cast<float>(one.patient)}});
    if (one.case_number) begun.apply({"case", {static_cast<float>(*one.case_number)}});
    return begun;
}

} // namespace live

#endif
