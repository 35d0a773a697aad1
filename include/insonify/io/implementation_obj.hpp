#ifndef INSONIFY_IO_IMPLEMENTATION_OBJ_HPP
#define INSONIFY_IO_IMPLEMENTATION_OBJ_HPP

#include <insonify/io/implementation_file.hpp>
#include <insonify/io/implementation_obj_media.hpp>
#include <insonify/io/implementation_obj_text.hpp>
#include <insonify/io/implementation_tinyobj.hpp>
#include <insonify/io/obj.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {
namespace detail {

/// One triangle of an OBJ file.
struct obj_face {
    uvec3 corners{0, 0, 0};
    std::uint32_t part = 0; ///< index of the object or group
    int medium = -1;        ///< index of the name after `usemtl`; -1: none
    std::uint32_t line = 0;
};

/// The content of an OBJ file, in its order.
struct obj_content {
    obj_text text{};
    std::vector<vec3> positions{}; ///< metres
    std::vector<std::string> parts{};
    std::vector<obj_face> faces{};
};

/// Gives tinyobjloader the names after `usemtl`, which `read_obj_text` has replaced by numbers.
class medium_numbers : public loader::MaterialReader {
  public:
    explicit medium_numbers(std::size_t count) : count_{count} {}
    bool operator()(const std::string&, std::vector<loader::material_t>*, std::map<std::string, int>* numbers,
                    std::string*, std::string*) override {
        for (std::size_t i = 0; i < count_; ++i) numbers->emplace(std::to_string(i), static_cast<int>(i));
        return true;
    }

  private:
    std::size_t count_;
};

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
    medium_numbers numbers{content.text.media.size()};
    if (!loader::LoadObj(&vertices, &shapes, &materials, &warnings, &errors, &stream, &numbers, true, false))
        throw io_error{path + ": tinyobjloader cannot read the file: " + errors};

    for (std::size_t i = 0; i + 2 < vertices.vertices.size(); i += 3) {
        const vec3 p{vertices.vertices[i], vertices.vertices[i + 1], vertices.vertices[i + 2]};
        content.positions.push_back(unit * p);
        if (!is_finite(content.positions.back()))
            throw io_error{path + ":" + std::to_string(content.text.vertex_lines[i / 3]) +
                           ": a coordinate of this vertex is too large; check the file and its unit"};
    }
    std::vector<std::uint32_t>& missing = content.text.face_triangles;
    for (const loader::shape_t& shape : shapes) {
        for (std::size_t i = 0; i < shape.mesh.material_ids.size(); ++i) {
            const auto corner = [&](std::size_t k) {
                return static_cast<std::uint32_t>(shape.mesh.indices[3 * i + k].vertex_index);
            };
            content.faces.push_back({{corner(0), corner(1), corner(2)},
                                     static_cast<std::uint32_t>(content.parts.size()),
                                     shape.mesh.material_ids[i],
                                     shape.mesh.smoothing_group_ids[i]});
            --missing[content.faces.back().line];
        }
        content.parts.push_back(shape.name);
    }
    for (std::size_t line = 0; line < missing.size(); ++line)
        if (missing[line] != 0)
            throw io_error{path + ":" + std::to_string(line) +
                           ": this polygon cannot be triangulated; triangulate the mesh before exporting it"};
    return content;
}

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

} // namespace detail

mesh load_obj(const std::string& path, const obj_settings& settings) {
    const detail::obj_content content = detail::read_obj(path, settings.unit);
    std::vector<uvec3> faces;
    faces.reserve(content.faces.size());
    for (const detail::obj_face& face : content.faces) faces.push_back(face.corners);
    return detail::select_faces(content.positions, std::move(faces));
}

scene load_obj_scene(const std::string& path, const obj_settings& settings) {
    scene loaded{settings.background};
    const detail::obj_content content = detail::read_obj(path, settings.unit);
    const detail::obj_libraries libraries = detail::read_libraries(path, content.text.libraries, settings.libraries);

    struct future_object {
        std::string name{};
        int medium = -1;
        std::vector<uvec3> faces{};
    };
    std::vector<future_object> objects; // by first face
    std::map<std::pair<std::string, int>, std::size_t> known;
    for (const detail::obj_face& face : content.faces) {
        const std::string& name = content.parts[face.part];
        if (face.medium < 0)
            throw io_error{path + ":" + std::to_string(face.line) + ": the face of object '" + detail::printable(name) +
                           "' has no medium; add a line such as 'usemtl muscle' before it"};
        const auto [place, is_new] = known.try_emplace({name, face.medium}, objects.size());
        if (is_new) objects.push_back({.name = name, .medium = face.medium});
        objects[place->second].faces.push_back(face.corners);
    }
    for (future_object& one : objects) {
        const detail::named_line& wanted = content.text.media[static_cast<std::size_t>(one.medium)];
        const detail::obj_medium found = detail::find_medium(path, wanted, libraries);
        loaded.add(detail::select_faces(content.positions, std::move(one.faces)), found.inside,
                   {.priority = found.priority, .name = one.name.empty() ? wanted.name : one.name});
    }
    return loaded;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
