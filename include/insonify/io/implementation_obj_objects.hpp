#ifndef INSONIFY_IO_IMPLEMENTATION_OBJ_OBJECTS_HPP
#define INSONIFY_IO_IMPLEMENTATION_OBJ_OBJECTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/io/implementation_obj_text.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// One triangle of an OBJ file.
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

/// A mesh of some faces and the vertices that they use, whose order is kept.
inline mesh select_faces(const std::vector<vec3>& positions, std::vector<uvec3> faces) {
    std::vector<std::uint32_t> used;
    used.reserve(3 * faces.size());
    for (const uvec3& f : faces) used.insert(used.end(), {f.x, f.y, f.z});
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());

    mesh selected;
    selected.positions.reserve(used.size());
    for (const std::uint32_t vertex : used) selected.positions.push_back(positions[vertex]);
    for (uvec3& f : faces)
        for (int i = 0; i < 3; ++i)
            f[i] = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), f[i]) - used.begin());
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

/// The objects in the order of their first faces. @throws io_error  for a face without a medium
inline std::vector<obj_object> divide_into_objects(const std::string& path, const obj_content& content) {
    std::vector<obj_object> objects;
    std::map<std::pair<std::uint32_t, int>, std::size_t> known;
    for (const obj_face& face : content.faces) {
        const obj_line& its = content.text.lines[face.line];
        if (its.medium < 0)
            throw io_error{path + ":" + std::to_string(face.line) + ": the face of object '" +
                           printable(name_of(content.text.parts[its.part])) +
                           "' has no medium; add a line such as 'usemtl muscle' before it"};
        const auto [place, is_new] = known.try_emplace({its.part, its.medium}, objects.size());
        if (is_new) objects.push_back({.part = its.part, .medium = its.medium, .line = face.line});
        objects[place->second].faces.push_back(face.corners);
    }
    return objects;
}

/// Whether each edge of some faces has two of them.
inline bool is_closed(const obj_content& content, const std::vector<uvec3>& faces) {
    const mesh_report found = validate(select_faces(content.positions, faces));
    return found.boundary_edges == 0 && found.non_manifold_edges == 0;
}

/// Joins open surfaces of one object and one medium that are closed together: a closed surface that `g` lines divide.
/// @throws io_error  where the open surfaces of an object are closed together, but have different media
inline void join_split_bodies(const std::string& path, const obj_content& content, std::vector<obj_object>& objects,
                              std::vector<std::string>& notes) {
    std::map<std::uint32_t, std::vector<std::size_t>> of_number; // the objects that one `o` has become
    for (std::size_t i = 0; i < objects.size(); ++i) of_number[content.text.parts[objects[i].part].number].push_back(i);
    for (auto& [number, members] : of_number) {
        if (members.size() < 2) continue;
        std::map<int, std::vector<std::size_t>> open; // by medium
        for (const std::size_t i : members)
            if (!is_closed(content, objects[i].faces)) open[objects[i].medium].push_back(i);
        std::vector<uvec3> rest; // of more than one medium
        std::vector<std::size_t> first_of_rest;
        for (const auto& [medium, parts] : open) {
            std::vector<uvec3> together;
            for (const std::size_t i : parts)
                together.insert(together.end(), objects[i].faces.begin(), objects[i].faces.end());
            if (!is_closed(content, together)) {
                rest.insert(rest.end(), together.begin(), together.end());
                first_of_rest.push_back(parts[0]);
                continue;
            }
            notes.push_back(joined({path, ":", std::to_string(objects[parts[1]].line), ": the groups '",
                                    printable(content.text.parts[objects[parts[0]].part].group), "' and '",
                                    printable(content.text.parts[objects[parts[1]].part].group),
                                    "' are one closed surface, and are joined"}));
            objects[parts[0]].faces = std::move(together);
            for (std::size_t k = 1; k < parts.size(); ++k) objects[parts[k]].faces.clear();
        }
        if (first_of_rest.size() < 2 || !is_closed(content, rest)) continue;
        const obj_object &one = objects[first_of_rest[0]], &other = objects[first_of_rest[1]];
        throw io_error{
            path + ":" + std::to_string(std::max(one.line, other.line)) + ": the closed surface of object '" +
            printable(name_of(content.text.parts[one.part])) + "' has faces in two media, '" +
            printable(one.medium_of(content).name) + "' and '" + printable(other.medium_of(content).name) +
            "', but a body has one; give all its faces the same medium, or export a closed surface for each"};
    }
    std::erase_if(objects, [](const obj_object& one) { return one.faces.empty(); });
}

/// Names objects after their `o`, and `g` where one `o` has several; each name once.
inline void name_objects(const std::string& path, const obj_content& content, std::vector<obj_object>& objects,
                         std::vector<std::string>& notes) {
    std::map<std::uint32_t, std::set<std::uint32_t>> parts_of; // number of an object to its parts with faces
    for (const obj_object& one : objects) parts_of[content.text.parts[one.part].number].insert(one.part);
    std::set<std::string> meant, taken;
    for (obj_object& one : objects) {
        const obj_part& part = content.text.parts[one.part];
        one.name = name_of(part);
        if (parts_of[part.number].size() > 1 && !part.object.empty() && !part.group.empty())
            one.name += "/" + part.group;
        if (one.name.empty()) one.name = one.medium_of(content).name;
        meant.insert(one.name);
    }
    for (obj_object& one : objects) {
        if (taken.insert(one.name).second) continue;
        std::string name;
        for (std::uint32_t i = 2; name.empty() || meant.contains(name) || taken.contains(name); ++i)
            name = one.name + "." + std::to_string(i);
        taken.insert(name);
        notes.push_back(joined({path, ":", std::to_string(one.line), ": there are several objects of the name '",
                                printable(one.name), "'; this one is called '", printable(name), "'"}));
        one.name = std::move(name);
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
