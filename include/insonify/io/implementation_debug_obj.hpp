#ifndef INSONIFY_IO_IMPLEMENTATION_DEBUG_OBJ_HPP
#define INSONIFY_IO_IMPLEMENTATION_DEBUG_OBJ_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/io/debug_obj.hpp>
#include <insonify/io/implementation_file.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <locale>
#include <numeric>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

void write_drawing(const std::string& path, const std::vector<drawn_object>& objects) {
    for (const drawn_object& one : objects) {
        const std::size_t vertices = one.positions.size();
        bool valid = std::accumulate(one.polylines.begin(), one.polylines.end(), std::uint64_t{0}) <= vertices;
        for (const uvec3& f : one.faces) valid = valid && std::max({f.x, f.y, f.z}) < vertices;
        if (!valid)
            throw usage_error{"write_drawing: object '" + one.name +
                              "' has a face or polyline with a vertex index out of range"};
    }
    std::ofstream file = detail::create_file(path);
    file.imbue(std::locale::classic());
    file.precision(std::numeric_limits<float>::max_digits10);
    file << "# drawn by insonify, in metres\n";

    std::size_t count = 0, first = 1; // OBJ indices start at 1 and count the vertices of the whole file
    for (const drawn_object& one : objects) {
        std::string name = one.name.empty() ? "object_" + std::to_string(count) : one.name;
        std::replace_if(
            name.begin(), name.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
        ++count;
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
