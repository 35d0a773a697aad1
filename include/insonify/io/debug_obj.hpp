#ifndef INSONIFY_IO_DEBUG_OBJ_HPP
#define INSONIFY_IO_DEBUG_OBJ_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/later.hpp>
#include <insonify/core/math.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// One named object of a drawing in space, in metres.
struct drawn_object {
    std::string name{};                     ///< after `o`; empty: object_ and its number
    std::vector<vec3> positions{};          ///< of the vertices
    std::vector<uvec3> faces{};             ///< three vertices each, from 0; may be none
    std::vector<std::uint32_t> polylines{}; ///< how many vertices each takes, in turn, from the first on; may be none
};

/// Writes objects as Wavefront OBJ, in metres: faces as `f`, polylines as `l`.
///
/// Compiled where INSONIFY_IMPLEMENTATION is defined.
/// @throws usage_error  for a face or polyline with a vertex that is not there, and nothing is written
/// @throws io_error     where the file cannot be written
void write_drawing(const std::string& path, const std::vector<drawn_object>& objects);

/// Writes what a probe looks at as one OBJ file in metres, to be opened in a mesh viewer: why is the picture empty?
///
/// The objects of the file: `probe`, the outline of the field from the face down to `depth`; `lines`, one polyline for
/// each line of the probe; then every object of the scene under its name, where it is placed. The scene need not be
/// built.
/// @throws usage_error     for a depth that is none, more than 65536 lines, or a probe that makes no sense
/// @throws geometry_error  for a pose that is no rigid motion
/// @throws io_error        where the file cannot be written
template <transducer Probe>
void write_debug_obj(const std::string& path, const scene& body, const Probe& probe, const pose& at, float depth) {
    probe.check();
    if (!is_rigid(at)) throw geometry_error{"write_debug_obj: the pose of the probe is no rigid motion"};
    if (probe.lines > 65536) throw usage_error{"write_debug_obj: at most 65536 lines are drawn; ask for fewer"};
    if (!is_depth(depth))
        throw usage_error{"write_debug_obj: the depth must be a number of metres, from 1 nm to 1000 km"};

    const auto point = [&](float line, float along) { return at.point(probe.beam(line).at(along)); };
    later_t<Probe, drawn_object> outline{.name = "probe"}, lines{.name = "lines"};
    later_t<Probe, std::vector<vec3>> end;
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

    later_t<Probe, std::vector<drawn_object>> drawing{std::move(outline), std::move(lines)};
    for (const object& one : body.objects()) {
        drawing.push_back({.name = one.name, .positions = one.surface.positions, .faces = one.surface.faces});
        for (vec3& p : drawing.back().positions) p = one.at.point(p);
    }
    write_drawing(path, drawing);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
