#ifndef INSONIFY_IO_DEBUG_OBJ_HPP
#define INSONIFY_IO_DEBUG_OBJ_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// A named object of a drawing, in metres.
struct drawn_object {
    std::string name{};            ///< name after `o`; by default object_ and its number
    std::vector<vec3> positions{}; ///< vertices
    std::vector<uvec3> faces{};    ///< three vertex indices each, from 0; may be empty
    std::vector<std::uint32_t>
        polylines{}; ///< number of vertices of each polyline, consecutive from the first; may be empty
};

/// Writes objects as Wavefront OBJ, in metres: faces as `f`, polylines as `l`.
///
/// Defined where INSONIFY_IMPLEMENTATION is defined.
/// @throws usage_error  for a vertex index out of range, before anything is written
/// @throws io_error     for a file that cannot be written
void write_drawing(const std::string& path, const std::vector<drawn_object>& objects);

/// Writes a probe and a scene as an OBJ file in metres, for a mesh viewer: it shows why an image is empty.
///
/// The objects of the file are `probe`, the outline of the field of view; `lines`, one polyline for each line of the
/// probe; and every object of the scene at its pose. The scene need not be built.
/// @throws usage_error     for a depth out of range, more than 65536 lines, or a setting of the probe out of range
/// @throws geometry_error  for a pose that is not a rigid transform
/// @throws io_error        for a file that cannot be written
template <transducer Probe>
void write_debug_obj(const std::string& path, const scene& body, const Probe& probe, const pose& at, float depth) {
    probe.check();
    if (!is_rigid(at))
        throw geometry_error{"write_debug_obj: the pose of the probe is not a rigid transform; make it with look_at, "
                             "or mend it with orthonormalised"};
    if (probe.lines > 65536)
        throw usage_error{"write_debug_obj: " + std::to_string(probe.lines) + " lines are more than 65536; draw fewer"};
    check_depth(depth, "write_debug_obj");

    const auto point = [&](float line, float along) { return at.point(probe.beam(line).at(along)); };
    drawn_object outline{.name = "probe"}, lines{.name = "lines"};
    std::vector<vec3> end;
    for (std::uint32_t i = 0; i <= probe.lines; ++i) {
        const float middle = static_cast<float>(i), border = middle - 0.5F;
        outline.positions.push_back(point(border, 0));
        end.push_back(point(border, depth));
        if (i < probe.lines) lines.positions.insert(lines.positions.end(), {point(middle, 0), point(middle, depth)});
    }
    outline.positions.insert(outline.positions.end(), end.rbegin(), end.rend());
    outline.positions.push_back(vec3{outline.positions.front()});
    outline.polylines.push_back(static_cast<std::uint32_t>(outline.positions.size()));
    lines.polylines.assign(probe.lines, 2);

    std::vector<drawn_object> drawing{std::move(outline), std::move(lines)};
    for (const object& one : body.objects()) {
        drawing.push_back({.name = one.name, .positions = one.surface.positions, .faces = one.surface.faces});
        for (vec3& p : drawing.back().positions) p = one.at.point(p);
    }
    write_drawing(path, drawing);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
