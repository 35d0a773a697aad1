#ifndef INSONIFY_IO_IMPLEMENTATION_DEBUG_OBJ_HPP
#define INSONIFY_IO_IMPLEMENTATION_DEBUG_OBJ_HPP

#include <insonify/io/debug_obj.hpp>
#include <insonify/io/implementation_file.hpp>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <locale>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

void write_drawing(const std::string& path, const std::vector<drawn_object>& objects) {
    std::ofstream file = io::create_file(path);
    file.imbue(std::locale::classic());
    file.precision(std::numeric_limits<float>::max_digits10);
    file << "# drawn by insonify, in metres\n";

    std::size_t count = 0, next = 1; // OBJ counts vertices from 1, over the whole file
    const auto write_vertices = [&](const std::vector<vec3>& positions) {
        for (const vec3& p : positions) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
        const std::size_t first = next;
        next += positions.size();
        return first;
    };
    for (const drawn_object& one : objects) {
        std::string name = one.name.empty() ? "object_" + std::to_string(count) : one.name;
        std::replace_if(
            name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
        ++count;
        file << "o " << name << '\n';
        const std::size_t first = write_vertices(one.surface.positions);
        for (const uvec3& f : one.surface.faces)
            file << "f " << first + f.x << ' ' << first + f.y << ' ' << first + f.z << '\n';
        for (const std::vector<vec3>& polyline : one.polylines) {
            const std::size_t begin = write_vertices(polyline);
            file << 'l';
            for (std::size_t i = 0; i < polyline.size(); ++i) file << ' ' << begin + i;
            file << '\n';
        }
    }
    io::close_file(file, path);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
