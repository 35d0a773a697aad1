#ifndef INSONIFY_IO_IMPLEMENTATION_OBJ_HPP
#define INSONIFY_IO_IMPLEMENTATION_OBJ_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/io/implementation_file.hpp>
#include <insonify/io/implementation_obj_media.hpp>
#include <insonify/io/implementation_obj_objects.hpp>
#include <insonify/io/implementation_obj_text.hpp>
#include <insonify/io/implementation_tinyobj.hpp>
#include <insonify/io/obj.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {
namespace detail {

inline obj_content read_obj(const std::string& path, float unit) {
    if (unit == 0) throw usage_error{path + ": OBJ files have no unit of length; give it: {.unit = 1_mm}"};
    if (!is_finite(unit) || !(unit > 0))
        throw usage_error{path + ": the unit must be finite and above 0, as in {.unit = 1_mm}"};

    obj_content content{.text = read_obj_text(path, read_file(path))};
    loader::attrib_t vertices;
    std::vector<loader::shape_t> shapes;
    std::vector<loader::material_t> materials;
    std::string warnings, errors;
    std::istringstream stream{std::exchange(content.text.rewritten, {})};
    if (!loader::LoadObj(&vertices, &shapes, &materials, &warnings, &errors, &stream, nullptr, true, false))
        throw io_error{path + ": tinyobjloader cannot read the file: " + errors};

    for (std::size_t i = 0; i + 2 < vertices.vertices.size(); i += 3) {
        const vec3 p{vertices.vertices[i], vertices.vertices[i + 1], vertices.vertices[i + 2]};
        content.positions.push_back(unit * p);
        if (!is_finite(content.positions.back()))
            throw io_error{path + ":" + std::to_string(content.text.vertex_lines[i / 3]) +
                           ": a coordinate of this vertex is too large; check the file and its unit"};
    }
    std::vector<std::uint32_t> found(content.text.lines.size()); // triangles of each line
    for (const loader::shape_t& shape : shapes)
        for (std::size_t i = 0; i < shape.mesh.smoothing_group_ids.size(); ++i) {
            const auto corner = [&](std::size_t k) {
                return static_cast<std::uint32_t>(shape.mesh.indices[3 * i + k].vertex_index);
            };
            content.faces.push_back({{corner(0), corner(1), corner(2)}, shape.mesh.smoothing_group_ids[i]});
            ++found[content.faces.back().line];
        }
    for (std::size_t line = 0; line < found.size(); ++line)
        if (found[line] != content.text.lines[line].triangles)
            throw io_error{path + ":" + std::to_string(line) +
                           ": this polygon cannot be triangulated; triangulate the mesh before exporting it"};
    return content;
}

} // namespace detail

mesh load_obj(const std::string& path, const obj_settings& settings) {
    const detail::obj_content content = detail::read_obj(path, settings.unit);
    std::vector<uvec3> faces;
    faces.reserve(content.faces.size());
    for (const detail::obj_face& face : content.faces) faces.push_back(face.corners);
    return detail::select_faces(content.positions, std::move(faces));
}

scene load_obj_scene(const std::string& path, const obj_settings& settings, std::vector<std::string>& notes) {
    scene loaded{settings.background};
    const detail::obj_content content = detail::read_obj(path, settings.unit);
    const detail::obj_libraries libraries = detail::read_libraries(path, content.text.libraries, settings.libraries);
    std::vector<detail::obj_object> objects = detail::divide_into_objects(path, content);
    notes.clear();
    detail::join_split_bodies(path, content, objects, notes);
    detail::name_objects(path, content, objects, notes);
    for (detail::obj_object& one : objects) {
        const detail::obj_medium found = detail::find_medium(path, one.medium_of(content), libraries);
        loaded.add(detail::select_faces(content.positions, std::move(one.faces)), found.inside,
                   {.priority = found.priority, .name = std::move(one.name)});
    }
    return loaded;
}

scene load_obj_scene(const std::string& path, const obj_settings& settings) {
    std::vector<std::string> notes;
    return load_obj_scene(path, settings, notes);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
