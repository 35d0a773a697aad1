#ifndef INSONIFY_IO_IMPLEMENTATION_OBJ_TEXT_HPP
#define INSONIFY_IO_IMPLEMENTATION_OBJ_TEXT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/io/implementation_file.hpp>
#include <algorithm>
#include <charconv>
#include <map>
#include <numeric>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Removes the first word from a line and returns it.
inline std::string_view next_word(std::string_view& line) {
    const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
    line.remove_prefix(static_cast<std::size_t>(std::find_if_not(line.begin(), line.end(), is_blank) - line.begin()));
    const std::string_view word =
        line.substr(0, static_cast<std::size_t>(std::find_if(line.begin(), line.end(), is_blank) - line.begin()));
    line.remove_prefix(word.size());
    return word;
}

/// Removes the first line from a text, which LF, CR LF or CR ends; returns it without comments and trailing blanks.
inline std::string_view next_line(std::string_view& text) {
    const auto ends = [](char c) { return c == '\r' || c == '\n'; };
    std::string_view line =
        text.substr(0, static_cast<std::size_t>(std::find_if(text.begin(), text.end(), ends) - text.begin()));
    text.remove_prefix(line.size());
    if (!text.empty()) text.remove_prefix(text.starts_with("\r\n") ? 2 : 1);
    for (std::size_t i = line.find('#'); i != std::string_view::npos; i = line.find('#', i + 1))
        if (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t') line = line.substr(0, i);
    return line.substr(0, line.find_last_not_of(" \t") + 1);
}

/// Calls body(number, keyword, rest) for every line that is not blank, counted from 1. A backslash continues a line.
template <class Body>
void for_each_line(std::string_view text, const Body& body) {
    std::string whole;
    for (std::uint32_t number = 1, lines = 1; !text.empty(); number += lines, lines = 1) {
        std::string_view line = next_line(text);
        if (line.ends_with('\\')) {
            whole.clear();
            for (; line.ends_with('\\'); ++lines, line = next_line(text))
                whole.append(line.substr(0, line.size() - 1)).push_back(' ');
            line = whole.append(line);
        }
        const std::string_view keyword = next_word(line);
        line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        if (!keyword.empty()) body(number, keyword, line);
    }
}

/// True for a word that tinyobjloader parses as a number; it reads other words, including `nan` and `inf`, as 0.
inline bool is_number(std::string_view word) {
    std::size_t i = 0;
    const auto digits = [&] {
        const std::size_t begin = i;
        while (i < word.size() && word[i] >= '0' && word[i] <= '9') ++i;
        return i - begin;
    };
    const auto skip = [&](std::string_view any) {
        const bool found = i < word.size() && any.find(word[i]) != std::string_view::npos;
        if (found) ++i;
        return found;
    };
    skip("+-");
    std::size_t mantissa = digits();
    if (skip(".")) mantissa += digits();
    if (mantissa == 0) return false;
    if (skip("eE")) {
        skip("+-");
        if (const std::size_t exponent = digits(); exponent == 0 || exponent > 4) return false;
    }
    return i == word.size();
}

/// Largest number of corners of a face: the time to triangulate a polygon is quadratic in it.
inline constexpr std::uint32_t max_corners = 10'000;

struct named_line {
    std::string name{};
    std::uint32_t line = 0;
};

/// A group of an object: the faces between `o` and the next `o` with the same `g`.
struct obj_part {
    std::string object{};     ///< after `o`
    std::string group{};      ///< after `g`
    std::uint32_t number = 0; ///< of the object: `o` lines up to there
};

/// What applies to the face on a line.
struct obj_line {
    std::uint32_t part = 0; ///< index into `parts`
    int medium = -1;        ///< index into `media`; -1: none
};

struct obj_polygon {
    std::uint32_t line = 0;
    std::uint32_t corners = 0; ///< their number
};

/// An OBJ file, checked line by line. Its vertices are rewritten for tinyobjloader, which ignores malformed numbers and
/// does not continue lines.
struct obj_text {
    std::string rewritten{};                   ///< vertices
    std::vector<obj_polygon> polygons{};       ///< faces of three corners or more
    std::vector<std::uint32_t> corners{};      ///< of all of them, one after the other
    std::vector<named_line> media{};           ///< arguments of `usemtl`, each once, with the line of its first use
    std::vector<named_line> libraries{};       ///< arguments of `mtllib`
    std::vector<std::uint32_t> vertex_lines{}; ///< line of each vertex
    std::vector<obj_part> parts{};             ///< some may have no faces
    std::vector<obj_line> lines{};             ///< from line 0
};

/// @throws io_error  naming the line, for malformed numbers and indices out of range
inline obj_text read_obj_text(const std::string& path, std::string_view text) {
    if (text.empty()) throw io_error{path, ": the file is empty"};
    obj_text obj;
    obj.parts.emplace_back();
    obj_line now;                                // what applies to the next face
    std::map<std::string, std::uint32_t> groups; // of the present object: index into `parts`
    for_each_line(text, [&](std::uint32_t line, std::string_view keyword, std::string_view rest) {
        const auto fault = [&](const std::string& sentence) { return io_error{path, ":", line, ": ", sentence}; };
        if (keyword == "v") {
            obj.rewritten.push_back('v');
            for (int axis = 0; axis < 3; ++axis) {
                const std::string_view word = next_word(rest);
                if (word.empty()) throw fault("a vertex needs three coordinates");
                if (!is_number(word))
                    throw fault("the coordinate '" + printable(word) + "' is not a finite number such as -1.5e-3");
                obj.rewritten.append(" ").append(word);
            }
            obj.rewritten.push_back('\n');
            obj.vertex_lines.push_back(line);
        } else if (keyword == "f") {
            const auto vertices = static_cast<std::int64_t>(obj.vertex_lines.size());
            std::uint32_t corners = 0;
            for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest), ++corners) {
                word = word.substr(0, word.find('/'));
                std::int64_t position = 0;
                const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), position);
                if (status == std::errc::invalid_argument || end != word.data() + word.size())
                    throw fault("'" + printable(word) + "' is not a vertex index; it must be a whole number");
                if (status == std::errc{} && position == 0)
                    throw fault("a face names vertex 0, but indices start at 1 in OBJ; add 1 to every index");
                if (status != std::errc{} || position > vertices || position < -vertices)
                    throw fault("a face names vertex " + printable(word) + ", but the file has " +
                                std::to_string(vertices) +
                                " up to this line; vertices must precede the faces that use them");
                obj.corners.push_back(static_cast<std::uint32_t>(position > 0 ? position - 1 : vertices + position));
            }
            if (corners < 3) throw fault("a face needs at least three corners; remove it");
            if (corners > max_corners)
                throw fault("this face has " + std::to_string(corners) + " corners, more than " +
                            std::to_string(max_corners) + "; triangulate the mesh before exporting it");
            obj.polygons.push_back({line, corners});
            obj.lines.resize(line);
            obj.lines.push_back(now);
        } else if (keyword == "usemtl") {
            auto known =
                std::find_if(obj.media.begin(), obj.media.end(), [&](const named_line& m) { return m.name == rest; });
            if (known == obj.media.end()) known = obj.media.insert(known, {std::string{rest}, line});
            now.medium = static_cast<int>(known - obj.media.begin());
        } else if (keyword == "mtllib") {
            obj.libraries.push_back({std::string{rest}, line});
        } else if (keyword == "o") {
            groups.clear();
            now.part = static_cast<std::uint32_t>(obj.parts.size());
            obj.parts.push_back({std::string{rest}, {}, obj.parts.back().number + 1});
        } else if (keyword == "g") {
            obj_part wanted = obj.parts.back();
            wanted.group = rest;
            const auto [known, is_new] = groups.try_emplace(wanted.group, static_cast<std::uint32_t>(obj.parts.size()));
            now.part = known->second;
            if (is_new) obj.parts.push_back(std::move(wanted));
        }
    });
    if (obj.lines.empty() && obj.vertex_lines.empty())
        throw io_error{path,
                       ": the file has no faces (lines starting with 'f') and no vertices ('v'): is it a Wavefront OBJ "
                       "file? Export it as one"};
    if (obj.lines.empty())
        throw io_error{path, ": the file has no faces (lines starting with 'f'); export it as a mesh"};
    return obj;
}

struct obj_face {
    uvec3 corners{0, 0, 0};
    std::uint32_t line = 0;
};

/// The content of an OBJ file, in its order.
struct obj_content {
    obj_text text{};
    std::vector<vec3> positions{}; ///< metres
    std::vector<obj_face> faces{};
};

/// Cuts a plane polygon into triangles: one ear after the other, which is a corner with the two beside it, in whose
/// triangle no other corner lies. Of a quadrilateral the shorter diagonal is cut, where both lie inside.
/// @return  false for a polygon that intersects itself
inline bool triangulate(const std::vector<vec3>& positions, view<const std::uint32_t> corners, std::uint32_t line,
                        std::vector<obj_face>& faces) {
    const auto fan = [&] {
        for (std::size_t i = 1; i + 1 < corners.size(); ++i)
            faces.push_back({{corners[0], corners[i], corners[i + 1]}, line});
        return true;
    };
    if (corners.size() == 3) return fan();
    const auto at = [&](std::size_t corner) { return dvec3{positions[corners[corner]]}; };
    dvec3 normal{0, 0, 0}; // by Newell's method
    double largest = 0, extent = 0;
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        const dvec3 of_triangle = cross(at(i) - at(0), at(i + 1) - at(0));
        normal += of_triangle;
        largest = std::max(largest, length(of_triangle));
        extent = std::max({extent, length(at(i) - at(0)), length(at(i + 1) - at(0))});
    }
    constexpr double rounding = 1e-6;                        // of coordinates, of the extent
    if (largest <= rounding * extent * extent) return fan(); // corners on a line have no inside
    const dvec3 size = abs(normal);
    if (!(std::max({size.x, size.y, size.z}) > rounding * largest)) return false;
    // The polygon as seen along the axis that its normal is nearest to, counter-clockwise.
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const double facing = normal[axis] > 0 ? 1 : -1;
    const auto area = [&](std::size_t a, std::size_t b, std::size_t c) {
        return facing * cross(at(b) - at(a), at(c) - at(a))[axis];
    };
    std::vector<std::size_t> left(corners.size()); // corners that are not cut off yet
    std::iota(left.begin(), left.end(), std::size_t{0});
    const auto is_ear = [&](std::size_t a, std::size_t b, std::size_t c, bool flat) {
        const double own = area(a, b, c);
        if (!(flat ? own >= 0 : own > 0)) return false;
        return std::none_of(left.begin(), left.end(), [&](std::size_t p) {
            const auto is_at = [&](std::size_t corner) { return positions[corners[p]] == positions[corners[corner]]; };
            return area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0 && !is_at(a) && !is_at(b) &&
                   !is_at(c);
        });
    };
    std::size_t next = corners.size() == 4 && length(at(0) - at(2)) < length(at(1) - at(3)) ? 1 : 0;
    for (std::size_t tried = 0; left.size() > 3;) {
        if (tried == 2 * left.size()) return false;
        const bool flat = tried++ >= left.size(); // where no other ear is left
        next %= left.size();
        const std::size_t a = left[(next + left.size() - 1) % left.size()], b = left[next],
                          c = left[(next + 1) % left.size()];
        if (!is_ear(a, b, c, flat)) {
            ++next;
            continue;
        }
        const bool begins = b < a; // the first corner of the polygon is also that of its triangle
        faces.push_back(
            {begins ? uvec3{corners[b], corners[c], corners[a]} : uvec3{corners[a], corners[b], corners[c]}, line});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(next));
        tried = 0;
    }
    faces.push_back({{corners[left[0]], corners[left[1]], corners[left[2]]}, line});
    return area(left[0], left[1], left[2]) >= 0;
}

/// A mesh of some faces and the vertices that they use, whose order is kept.
inline mesh select_faces(const std::vector<vec3>& positions, std::vector<uvec3> faces) {
    mesh selected;
    if (faces.empty()) return selected;
    uvec3 lowest = faces[0], highest = faces[0];
    for (const uvec3& f : faces) {
        lowest = min(lowest, f);
        highest = max(highest, f);
    }
    const std::uint32_t first = std::min({lowest.x, lowest.y, lowest.z}),
                        last = std::max({highest.x, highest.y, highest.z});
    std::vector<std::uint32_t> number(last - first + 1); // in the mesh, plus 1; 0: not used
    for (const uvec3& f : faces) number[f.x - first] = number[f.y - first] = number[f.z - first] = 1;
    for (std::uint32_t i = 0; i < number.size(); ++i) {
        if (number[i] == 0) continue;
        selected.positions.push_back(positions[first + i]);
        number[i] = static_cast<std::uint32_t>(selected.positions.size());
    }
    for (uvec3& f : faces)
        for (int i = 0; i < 3; ++i) f[i] = number[f[i] - first] - 1;
    selected.faces = std::move(faces);
    return selected;
}

/// The faces of one group of an object with one medium, which become an object of the scene.
struct obj_object {
    std::string name{};
    std::uint32_t part = 0; ///< index into `obj_text::parts`
    int medium = -1;        ///< index into `obj_text::media`
    std::uint32_t line = 0; ///< of the first face
    std::vector<uvec3> faces{};

    const named_line& medium_of(const obj_content& content) const {
        return content.text.media[static_cast<std::size_t>(medium)];
    }
};

/// What a part is called, as long as no other has this name.
inline const std::string& name_of(const obj_part& part) { return part.object.empty() ? part.group : part.object; }

/// The objects in the order of their first faces: those of one `o` lie together.
/// @throws io_error  for a face without a medium
inline std::vector<obj_object> divide_into_objects(const std::string& path, const obj_content& content) {
    std::vector<obj_object> objects;
    std::map<std::pair<std::uint32_t, int>, std::size_t> known;
    for (const obj_face& face : content.faces) {
        const obj_line& its = content.text.lines[face.line];
        if (its.medium < 0)
            throw io_error{path,
                           ":",
                           face.line,
                           ": the face of object '",
                           printable(name_of(content.text.parts[its.part])),
                           "' has no medium; add a line such as 'usemtl muscle' before it"};
        const auto [place, is_new] = known.try_emplace({its.part, its.medium}, objects.size());
        if (is_new) objects.push_back({.part = its.part, .medium = its.medium, .line = face.line});
        objects[place->second].faces.push_back(face.corners);
    }
    return objects;
}

/// How many edges of some faces do not have two of them: none of a closed surface.
inline std::uint32_t open_edges(const obj_content& content, const std::vector<uvec3>& faces) {
    const mesh_report found = validate(select_faces(content.positions, faces));
    return found.boundary_edges + found.non_manifold_edges;
}

/// The end of the objects that one `o` has become.
inline std::size_t end_of_number(const obj_content& content, const std::vector<obj_object>& objects,
                                 std::size_t begin) {
    const auto number = [&](std::size_t i) { return content.text.parts[objects[i].part].number; };
    std::size_t end = begin + 1;
    while (end < objects.size() && number(end) == number(begin)) ++end;
    return end;
}

/// Joins open surfaces of one object and one medium that are closed together: a surface that `g` lines divide.
/// @param repaired  whether holes are closed afterwards: then surfaces are joined where most open edges become whole
/// @throws io_error  where the open surfaces of an object are closed together, but have different media
inline void join_split_bodies(const std::string& path, const obj_content& content, std::vector<obj_object>& objects,
                              bool repaired, std::vector<std::string>& notes) {
    struct open_surfaces {
        std::vector<std::size_t> parts{};
        std::uint32_t edges = 0; // open ones, of each part alone
    };
    for (std::size_t begin = 0, end = 0; begin < objects.size(); begin = end) {
        end = end_of_number(content, objects, begin);
        std::map<int, open_surfaces> open; // by medium
        for (std::size_t i = begin; i < end && end - begin > 1; ++i)
            if (const std::uint32_t edges = open_edges(content, objects[i].faces); edges > 0) {
                open[objects[i].medium].parts.push_back(i);
                open[objects[i].medium].edges += edges;
            }
        std::vector<uvec3> rest; // of more than one medium
        std::vector<std::size_t> first_of_rest;
        for (const auto& [medium, one] : open) {
            const std::vector<std::size_t>& parts = one.parts;
            std::vector<uvec3> together;
            for (const std::size_t i : parts)
                together.insert(together.end(), objects[i].faces.begin(), objects[i].faces.end());
            if (parts.size() < 2 || open_edges(content, together) > (repaired ? one.edges / 2 : 0)) {
                rest.insert(rest.end(), together.begin(), together.end());
                first_of_rest.push_back(parts[0]);
                continue;
            }
            notes.push_back(joined({path, ":", objects[parts[1]].line, ": the groups '",
                                    printable(content.text.parts[objects[parts[0]].part].group), "' and '",
                                    printable(content.text.parts[objects[parts[1]].part].group),
                                    "' belong to one surface, and are joined"}));
            objects[parts[0]].faces = std::move(together);
            for (std::size_t k = 1; k < parts.size(); ++k) objects[parts[k]].faces.clear();
        }
        if (first_of_rest.size() < 2 || open_edges(content, rest) > 0) continue;
        const obj_object &one = objects[first_of_rest[0]], &other = objects[first_of_rest[1]];
        throw io_error{
            path,
            ":",
            std::max(one.line, other.line),
            ": the closed surface of object '",
            printable(name_of(content.text.parts[one.part])),
            "' has faces in two media, '",
            printable(one.medium_of(content).name),
            "' and '",
            printable(other.medium_of(content).name),
            "', but a body has one; give all its faces the same medium, or export a closed surface for each"};
    }
    std::erase_if(objects, [](const obj_object& one) { return one.faces.empty(); });
}

/// Names objects after their `o`, and `g` where one `o` has several; each name once.
inline void name_objects(const std::string& path, const obj_content& content, std::vector<obj_object>& objects,
                         std::vector<std::string>& notes) {
    std::map<std::string, std::uint32_t> last_number; // by name; 0: no object has it yet
    for (std::size_t begin = 0, end = 0; begin < objects.size(); begin = end) {
        end = end_of_number(content, objects, begin);
        const bool divided = std::any_of(objects.begin() + static_cast<std::ptrdiff_t>(begin),
                                         objects.begin() + static_cast<std::ptrdiff_t>(end),
                                         [&](const obj_object& one) { return one.part != objects[begin].part; });
        for (std::size_t i = begin; i < end; ++i) {
            const obj_part& part = content.text.parts[objects[i].part];
            std::string& name = objects[i].name = name_of(part);
            if (divided && !part.object.empty() && !part.group.empty()) name += "/" + part.group;
            if (name.empty()) name = objects[i].medium_of(content).name;
            last_number[name] = 0;
        }
    }
    for (obj_object& one : objects) {
        std::uint32_t& number = last_number[one.name];
        if (++number == 1) continue;
        std::string name = one.name + "." + std::to_string(number);
        while (last_number.contains(name)) name = one.name + "." + std::to_string(++number);
        last_number[name] = 1;
        notes.push_back(joined({path, ":", one.line, ": there are several objects of the name '", printable(one.name),
                                "'; this one is called '", printable(name), "'"}));
        one.name = std::move(name);
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
