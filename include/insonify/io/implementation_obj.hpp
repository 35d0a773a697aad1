#ifndef INSONIFY_IO_IMPLEMENTATION_OBJ_HPP
#define INSONIFY_IO_IMPLEMENTATION_OBJ_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/io/implementation_file.hpp>
#include <insonify/io/implementation_obj_text.hpp>
#include <insonify/io/implementation_packages.hpp>
#include <insonify/io/obj.hpp>
#include <algorithm>
#include <filesystem>
#include <limits>
#include <locale>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// A medium and what its objects have besides, as defined in a material library.
struct obj_medium {
    medium inside{};
    int priority = 0;
    std::optional<vec3> fibres{};     ///< their direction
    std::optional<float> pennation{}; ///< radians
};

struct obj_value {
    std::string text{};
    std::uint32_t line = 0;
};

/// An entry of a material library: its keys with their values.
struct obj_material {
    std::string source{};   ///< the file that defines it
    std::uint32_t line = 0; ///< of its name
    std::map<std::string, obj_value> values{};
};

struct obj_libraries {
    std::map<std::string, obj_material> materials{}; ///< by name; the first definition of a name is used
    std::string missing{};                           ///< text that names the libraries that were not found
    std::map<std::string, obj_value> unknown_keys{}; ///< with the file and line where each is first
};

inline constexpr std::string_view medium_keys[] = {"density",
                                                   "sound_speed",
                                                   "attenuation",
                                                   "attenuation_power",
                                                   "backscatter_db",
                                                   "roughness_um",
                                                   "scatterers_per_mm3",
                                                   "structure",
                                                   "fibres",
                                                   "pennation",
                                                   "priority"};

/// Whether a key is one of those that renderers know: of MTL and of its extension for physically based rendering.
inline bool is_key_of_renderers(std::string_view key) {
    constexpr std::string_view keys[] = {"Ka", "Kd", "Ks",        "Ke",   "Tf",   "illum", "Ns",    "Ni",
                                         "d",  "Tr", "sharpness", "bump", "disp", "decal", "refl",  "norm",
                                         "Pr", "Pm", "Ps",        "Pc",   "Pcr",  "aniso", "anisor"};
    return key.starts_with("map_") || std::find(std::begin(keys), std::end(keys), key) != std::end(keys);
}

/// True for a path that leads out of the folder: a mesh from an untrusted source must not open arbitrary files.
inline bool leaves_folder(std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    const std::filesystem::path path = path_of(name);
    return name.empty() || path.has_root_path() || name.find(':') != std::string::npos ||
           std::find(path.begin(), path.end(), "..") != path.end();
}

/// True for a path that leads out of the folder through a symbolic link.
inline bool links_out_of(const std::filesystem::path& folder, const std::string& name) {
    std::error_code fault;
    const std::filesystem::path home = std::filesystem::weakly_canonical(folder.empty() ? "." : folder, fault);
    const std::filesystem::path place = std::filesystem::weakly_canonical(home / path_of(name), fault);
    return fault || std::mismatch(home.begin(), home.end(), place.begin(), place.end()).first != home.end();
}

inline void read_library(const std::string& path, obj_libraries& libraries) {
    obj_material unused; // keys before the first name, and those of a name that is defined already
    obj_material* current = &unused;
    for_each_line(read_file(path), [&](std::uint32_t line, std::string_view keyword, std::string_view rest) {
        if (keyword == "newmtl") {
            const auto [place, is_new] = libraries.materials.try_emplace(std::string{rest}, obj_material{path, line});
            current = is_new ? &place->second : &unused;
            return;
        }
        current->values.try_emplace(std::string{keyword}, obj_value{std::string{rest}, line});
        if (!is_key_of_renderers(keyword) &&
            std::find(std::begin(medium_keys), std::end(medium_keys), keyword) == std::end(medium_keys))
            libraries.unknown_keys.try_emplace(std::string{keyword}, obj_value{path, line});
    });
}

/// Reads the libraries that an OBJ file names: each `mtllib` line has one name with spaces, or several names.
/// @throws io_error  for a library outside the folder of the file, unless `allowed`
inline obj_libraries read_libraries(const std::string& path, const std::vector<named_line>& lines,
                                    obj_settings::library_access allowed) {
    const std::filesystem::path folder = path_of(path).parent_path();
    obj_libraries libraries;
    const auto forbidden = [&](const std::string& name) {
        return allowed == obj_settings::library_access::own_folder &&
               (leaves_folder(name) || links_out_of(folder, name));
    };
    const auto exists = [&](const std::string& name) {
        std::error_code ignored;
        return !forbidden(name) && std::filesystem::exists(folder / path_of(name), ignored);
    };
    for (const named_line& line : lines) {
        std::vector<std::string> names;
        std::string_view rest = line.name;
        for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) names.emplace_back(word);
        const bool is_one = exists(line.name) || (std::none_of(names.begin(), names.end(), exists) &&
                                                  std::none_of(names.begin(), names.end(), forbidden));
        if (names.size() > 1 && is_one) names = {line.name};
        for (const std::string& name : names) {
            if (forbidden(name))
                throw io_error{path,
                               ":",
                               line.line,
                               ": the material library '",
                               printable(name),
                               "' is outside the folder of the file and is not opened; move it there, or allow it: ",
                               "{.libraries = obj_settings::library_access::anywhere}"};
            const std::u8string library = (folder / path_of(name)).u8string();
            if (exists(name))
                read_library({library.begin(), library.end()}, libraries);
            else
                libraries.missing += " (" + printable(name) + " was not found)";
        }
    }
    return libraries;
}

/// Number of letters to insert, remove or replace to make one word of another. Source: Levenshtein 1966.
inline std::size_t edits_between(std::string_view one, std::string_view other) {
    std::vector<std::size_t> row(other.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 0; i < one.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < other.size(); ++j) {
            const std::size_t replaced = diagonal + (one[i] == other[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

/// The medium whose name is like one that is unknown: in another case, with a number at its end as editors append it,
/// or misspelt. @return  "; did you mean bone?", or nothing
inline std::string suggest_medium(const std::string& unknown, const obj_libraries& libraries) {
    const auto plain = [](std::string_view name) { // bone for Bone.001
        std::string text{name.substr(0, name.find_last_not_of("0123456789._- ") + 1)};
        for (char& c : text)
            c = 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c == ' ' || c == '-' ? '_' : c;
        return text;
    };
    const std::string wanted = plain(unknown);
    std::string best;
    std::size_t fewest = wanted.size() < 5 ? 1 : 2;
    const auto consider = [&](std::string_view name) {
        const std::size_t edits = edits_between(wanted, plain(name));
        if (name == unknown || edits > fewest || (edits == fewest && !best.empty())) return;
        best = name;
        fewest = edits;
    };
    for (const tissue::named_medium& one : tissue::all) consider(one.name);
    for (const auto& [name, material] : libraries.materials)
        if (material.values.contains("density")) consider(name);
    return best.empty() ? best : "; did you mean " + best + "?";
}

/// Unknown keys are ignored, but not those that look like a misspelt one of `load_obj_scene`.
/// @throws io_error  with the key that is meant
inline void check_spelling(const obj_material& entry, const std::string& name) {
    for (const auto& [written, value] : entry.values)
        if (!is_key_of_renderers(written) &&
            std::find(std::begin(medium_keys), std::end(medium_keys), written) == std::end(medium_keys))
            for (const std::string_view key : medium_keys)
                if (edits_between(written, key) <= 2)
                    throw io_error{entry.source,
                                   ":",
                                   value.line,
                                   ": newmtl ",
                                   name,
                                   ": there is no key '",
                                   printable(written),
                                   "'; did you mean ",
                                   key,
                                   "?"};
}

/// @throws io_error  for values that are those of a medium in other units
inline void check_units(const medium& m, const std::string& source) {
    if (m.sound_speed > 0 && m.sound_speed < 20)
        throw io_error{source, "sound_speed is ", m.sound_speed, " m/s; did you mean ", 1000 * m.sound_speed, "?"};
    if (m.density > 0.5F && m.density < 30 && m.sound_speed > 700) // no gas
        throw io_error{source, "density is ", m.density, " kg/m^3; did you mean ", 1000 * m.density, "?"};
}

/// The medium with a name that `usemtl` refers to.
/// @throws io_error  naming the line or library, for an unknown medium or values out of range
inline obj_medium find_medium(const std::string& path, const named_line& wanted, const obj_libraries& libraries) {
    const std::string name = printable(wanted.name);
    const auto entry = libraries.materials.find(wanted.name);
    const bool is_listed = entry != libraries.materials.end();
    const auto written = [&](const char* key) -> const obj_value* {
        if (!is_listed) return nullptr;
        const auto found = entry->second.values.find(key);
        return found != entry->second.values.end() ? &found->second : nullptr;
    };
    const auto place = [&](std::uint32_t line) {
        return joined({entry->second.source, ":", line, ": newmtl ", name, ": "});
    };
    // The numbers of a text, if there are `count` and nothing else.
    const auto numbers = [](const obj_value& value, std::size_t count) {
        std::istringstream stream{value.text};
        stream.imbue(std::locale::classic());
        std::vector<float> all(count);
        for (float& number : all)
            if (!(stream >> number) || !is_finite(number)) return std::vector<float>{};
        return (stream >> std::ws).eof() ? all : std::vector<float>{};
    };
    const auto value = [&](const char* key) -> std::optional<float> {
        const obj_value* const text = written(key);
        if (!text) return {};
        const std::vector<float> number = numbers(*text, 1);
        if (number.empty())
            throw io_error{place(text->line), key, " is '", printable(text->text),
                           "', which is not a number; give the number without a unit"};
        return number[0];
    };
    if (is_listed) check_spelling(entry->second, name);
    const std::optional<medium> known = tissue::find(wanted.name);
    const std::optional<float> density = value("density"), sound_speed = value("sound_speed");
    if (!known && !(density && sound_speed))
        throw io_error{path,
                       ":",
                       wanted.line,
                       ": the medium '",
                       name,
                       "' is unknown: use the name of a tissue (`tissue::all` lists them), or give density and ",
                       "sound_speed under 'newmtl ",
                       name,
                       "' in the material library",
                       libraries.missing,
                       suggest_medium(wanted.name, libraries)};

    obj_medium found{.inside = density && sound_speed ? medium{} : *known};
    medium& m = found.inside;
    if (known) m.structure = known->structure;
    m.density = density.value_or(m.density);
    m.sound_speed = sound_speed.value_or(m.sound_speed);
    if (const auto decibels_per_cm = value("attenuation")) m.attenuation = 100 * *decibels_per_cm;
    m.attenuation_power = value("attenuation_power").value_or(m.attenuation_power);
    if (const auto decibels = value("backscatter_db")) m.backscatter = amplitude_of_decibels(*decibels);
    if (const auto micrometres = value("roughness_um")) m.roughness = 1e-6F * *micrometres;
    if (const auto per_cubic_mm = value("scatterers_per_mm3")) m.scatterer_density = 1e9F * *per_cubic_mm;
    if (const obj_value* const like = written("structure")) {
        const std::optional<medium> other = tissue::find(like->text);
        if (!other && like->text != "none")
            throw io_error{place(like->line), "structure is '", printable(like->text),
                           "'; give the name of a tissue whose structure it has (`tissue::all` lists them), or none",
                           suggest_medium(like->text, {})};
        m.structure = other ? other->structure : structure{};
    }
    if (!is_listed) return found;
    if (!is_valid(m))
        throw io_error{place(entry->second.line),
                       "density and sound_speed must be above 0, the other values not negative, and all in range"};
    check_units(m, place(entry->second.line));
    const float priority = value("priority").value_or(0);
    if (priority != std::round(priority) || std::fabs(priority) > 1e6F)
        throw io_error{place(written("priority")->line), "priority must be a whole number from -1000000 to 1000000"};
    found.priority = static_cast<int>(priority);
    if (const obj_value* const direction = written("fibres")) {
        const std::vector<float> along = numbers(*direction, 3);
        if (along.empty() || (along[0] == 0 && along[1] == 0 && along[2] == 0))
            throw io_error{place(direction->line), "fibres is '", printable(direction->text),
                           "'; give three numbers that are not all 0, the direction in the coordinates of the file, "
                           "such as 0 0 1"};
        found.fibres = vec3{along[0], along[1], along[2]};
    }
    if (const auto degrees = value("pennation")) {
        if (std::fabs(*degrees) > 90)
            throw io_error{place(written("pennation")->line), "pennation must be from -90 to 90 degrees"};
        if (found.fibres)
            throw io_error{place(written("pennation")->line),
                           "it has fibres and pennation; keep the one that is known"};
        found.pennation = *degrees * 1_deg;
    }
    return found;
}

/// The long axis of a mesh, turned by an angle towards its flattest direction. Both point to where their largest
/// component is positive.
inline vec3 turned_axis(const mesh& surface, float angle) {
    aabb box;
    for (const vec3& p : surface.positions) box = merged(box, p);
    const mat3 axes = axes_of(surface, box);
    const auto upright = [](vec3 axis) {
        const vec3 size = abs(axis);
        const int largest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        return axis[largest] < 0 ? -axis : axis;
    };
    return std::cos(angle) * upright(axes[0]) + std::sin(angle) * upright(axes[2]);
}

/// Mends a mesh where that is asked for.
/// @param whose  begins each note
inline mesh repaired(mesh surface, const obj_settings& settings, const std::string& whose,
                     std::vector<std::string>& notes) {
    if (!settings.repair) return surface;
    repaired_mesh mended = settings.repair(surface);
    for (const std::string& note : mended.notes) notes.push_back(joined({whose, ": ", note}));
    return std::move(mended.surface);
}

inline obj_content read_obj(const std::string& path, float unit) {
    if (unit == 0) throw usage_error{path, ": OBJ files have no unit of length; give it: {.unit = 1_mm}"};
    if (!is_finite(unit) || !(unit > 0))
        throw usage_error{path, ": the unit must be finite and above 0, as in {.unit = 1_mm}"};

    obj_content content{.text = read_obj_text(path, read_file(path))};
    std::istringstream stream{std::exchange(content.text.rewritten, {})};
    loader::callback_t vertices;
    vertices.vertex_cb = [](void* positions, float x, float y, float z, float) {
        static_cast<std::vector<vec3>*>(positions)->push_back({x, y, z});
    };
    std::string warnings, errors;
    if (!loader::LoadObjWithCallback(stream, vertices, &content.positions, nullptr, &warnings, &errors))
        throw io_error{path, ": tinyobjloader cannot read the file: ", errors};
    for (std::size_t i = 0; i < content.positions.size(); ++i) {
        content.positions[i] *= unit;
        if (!is_finite(content.positions[i]))
            throw io_error{path, ":", content.text.vertex_lines[i],
                           ": a coordinate of this vertex is too large; check the file and its unit"};
    }
    const std::uint32_t* corners = content.text.corners.data();
    for (const obj_polygon& one : content.text.polygons) {
        if (!triangulate(content.positions, {corners, one.corners}, one.line, content.faces))
            throw io_error{path, ":", one.line,
                           ": this polygon cannot be triangulated; triangulate the mesh before exporting it"};
        corners += one.corners;
    }
    return content;
}

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

mesh load_obj(const std::string& path, const obj_settings& settings, std::vector<std::string>& notes) {
    const detail::obj_content content = detail::read_obj(path, settings.unit);
    std::vector<uvec3> faces;
    faces.reserve(content.faces.size());
    for (const detail::obj_face& face : content.faces) faces.push_back(face.corners);
    notes.clear();
    return detail::repaired(detail::select_faces(content.positions, std::move(faces)), settings, path, notes);
}

mesh load_obj(const std::string& path, const obj_settings& settings) {
    std::vector<std::string> notes;
    return load_obj(path, settings, notes);
}

scene load_obj_scene(const std::string& path, const obj_settings& settings, std::vector<std::string>& notes) {
    if (!(std::fabs(settings.pennation) <= pi / 2 + 1e-6F))
        throw usage_error{path, ": `pennation` is ", settings.pennation,
                          " radians; it must be from -pi/2 to pi/2; write it as in 20_deg"};
    scene loaded{settings.background};
    const detail::obj_content content = detail::read_obj(path, settings.unit);
    const detail::obj_libraries libraries = detail::read_libraries(path, content.text.libraries, settings.libraries);
    std::vector<detail::obj_object> objects = detail::divide_into_objects(path, content);
    notes.clear();
    for (const auto& [key, place] : libraries.unknown_keys)
        notes.push_back(detail::joined(
            {place.text, ":", place.line, ": the key '", detail::printable(key), "' is unknown and is ignored"}));
    detail::join_split_bodies(path, content, objects, static_cast<bool>(settings.repair), notes);
    detail::name_objects(path, content, objects, notes);
    bool is_turned = false;
    for (detail::obj_object& one : objects) {
        const detail::obj_medium found = detail::find_medium(path, one.medium_of(content), libraries);
        const std::string whose = detail::joined({path, ":", one.line, ": object '", detail::printable(one.name), "'"});
        mesh surface =
            detail::repaired(detail::select_faces(content.positions, std::move(one.faces)), settings, whose, notes);
        if (surface.faces.empty()) {
            notes.push_back(whose + ": Left out: no face remains.");
            continue;
        }
        const bool is_muscle = found.inside.structure.sheath.thickness > 0;
        const bool is_asked = settings.pennation != 0 && is_muscle && !found.fibres;
        const float angle = found.pennation.value_or(is_asked ? settings.pennation : 0.0F);
        is_turned = is_turned || (is_asked && !found.pennation);
        const vec3 fibres = found.fibres.value_or(angle != 0 ? detail::turned_axis(surface, angle) : vec3{0, 0, 0});
        loaded.add(std::move(surface), found.inside,
                   {.priority = found.priority, .name = std::move(one.name), .fibres = fibres});
    }
    if (settings.pennation != 0 && !is_turned)
        notes.push_back(path + ": `pennation` has turned nothing: there is no muscle, whose structure has a sheath, "
                               "without `fibres` or `pennation` of its own");
    return loaded;
}

scene load_obj_scene(const std::string& path, const obj_settings& settings) {
    std::vector<std::string> notes;
    return load_obj_scene(path, settings, notes);
}

void write_drawing(const std::string& path, const std::vector<drawn_object>& objects) {
    for (const drawn_object& one : objects) {
        const std::size_t vertices = one.positions.size();
        bool valid = std::accumulate(one.polylines.begin(), one.polylines.end(), std::uint64_t{0}) <= vertices;
        for (const uvec3& f : one.faces) valid = valid && std::max({f.x, f.y, f.z}) < vertices;
        if (!valid)
            throw usage_error{"write_drawing: object '", one.name,
                              "' has a face or polyline with a vertex index out of range"};
    }
    std::ofstream file = detail::create_file(path);
    file.imbue(std::locale::classic());
    file.precision(std::numeric_limits<float>::max_digits10);
    file << "# drawn by insonify, in metres\n";

    std::size_t first = 1; // OBJ indices start at 1 and count the vertices of the whole file
    for (const drawn_object& one : objects) {
        std::string name = one.name.empty() ? "object_" + std::to_string(&one - objects.data()) : one.name;
        for (char& c : name)
            if (c == '\n' || c == '\r') c = ' ';
        file << "o " << name << '\n';
        for (const vec3& p : one.positions) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
        for (const uvec3& f : one.faces)
            file << "f " << first + f.x << ' ' << first + f.y << ' ' << first + f.z << '\n';
        std::size_t vertex = first;
        for (const std::uint32_t length : one.polylines) {
            file << 'l';
            for (const std::size_t end = vertex + length; vertex < end; ++vertex) file << ' ' << vertex;
            file << '\n';
        }
        first += one.positions.size();
    }
    detail::close_file(file, path);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
