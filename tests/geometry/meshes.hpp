#ifndef INSONIFY_TESTS_GEOMETRY_MESHES_HPP
#define INSONIFY_TESTS_GEOMETRY_MESHES_HPP

#include <insonify/geometry/mesh.hpp>
#include <cstdint>
#include <utility>

namespace mesh_test {

using namespace insonify;

/// Adds a mesh to another one.
inline void append(mesh& all, const mesh& more) {
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), more.positions.begin(), more.positions.end());
    for (const uvec3 f : more.faces) all.faces.push_back(f + first);
}

inline mesh turned_inside_out(mesh m) {
    for (uvec3& f : m.faces) std::swap(f.y, f.z);
    return m;
}

/// Three separate vertices for every face, as in STL files.
inline mesh unwelded(const mesh& m) {
    mesh soup;
    for (const uvec3 f : m.faces) {
        const auto first = static_cast<std::uint32_t>(soup.positions.size());
        soup.positions.insert(soup.positions.end(), {m.positions[f.x], m.positions[f.y], m.positions[f.z]});
        soup.faces.push_back({first, first + 1, first + 2});
    }
    return soup;
}

} // namespace mesh_test

#endif
