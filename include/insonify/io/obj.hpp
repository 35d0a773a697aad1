#ifndef INSONIFY_IO_OBJ_HPP
#define INSONIFY_IO_OBJ_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/repair.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Whether and how objects are mended while they are read. By default they stay as they are, and a program that never
/// asks for `repair` does not compile it.
class obj_repair {
  public:
    obj_repair() = default; ///< no repair
    template <class Deferred = void>
    obj_repair(const repair_settings& settings) : settings_(settings), repair_(insonify::repair) {} ///< with `settings`

    explicit operator bool() const { return repair_ != nullptr; } ///< whether objects are mended
    repaired_mesh operator()(const mesh_view& m) const {
        return repair_(m, settings_);
    } ///< mends a mesh; only where it is `true`

  private:
    repair_settings settings_{};
    repaired_mesh (*repair_)(const mesh_view&, const repair_settings&) = nullptr;
};

/// How to read a Wavefront OBJ file.
struct obj_settings {
    /// Material libraries that a file may open: restricted for meshes from untrusted sources.
    enum class library_access {
        own_folder, ///< those in the folder of the OBJ file or below, after resolving symbolic links
        anywhere,   ///< all
    };

    float unit = 0;                    ///< length of 1 in the file, metres, as in {.unit = 1_mm}; required
    medium background = tissue::water; ///< of a scene: the medium outside all objects
    library_access libraries = library_access::own_folder; ///< of a scene: the material libraries that may be opened
    obj_repair repair{}; ///< mends open meshes, as in {.repair = repair_settings{}}; by default they stay as they are
    /// Of a scene: angle between the fibres of muscles and their long axis, radians, -pi/2 to pi/2, for objects whose
    /// structure has a sheath and whose material has neither `fibres` nor `pennation`; see `load_obj_scene`.
    float pennation = 0;
};

/// Loads all faces of an OBJ file as one mesh. Groups and materials are ignored, and no other file is opened.
///
/// Polygons are triangulated and unused vertices removed; the others keep their order.
/// Defined where INSONIFY_IMPLEMENTATION is defined.
/// @throws usage_error  for a missing unit, or another setting out of range
/// @throws io_error     naming the line, for a file that is missing, empty or without faces, a malformed number, a
///                      vertex that is not finite, or an index out of range
mesh load_obj(const std::string& path, const obj_settings& settings);

/// The same, and tells what `repair` did.
/// @param notes  a sentence for each, which begins with the path; replaces its content
mesh load_obj(const std::string& path, const obj_settings& settings, std::vector<std::string>& notes);

/// Loads an OBJ file as a scene, which has yet to be built: load_obj_scene(path, {.unit = 1_mm}).build(exec::par).
///
/// The faces of one object (`o`), group (`g`) and material (`usemtl`) become one object of the scene. It has the name
/// of the `o`; where an `o` has several groups, `heart/left`; without an `o`, that of the group; else that of the
/// material. Each `o` line begins another object. Of equal names, all but the first get a number: `rib`, `rib.2`. The
/// material is looked up by name in the material libraries (`mtllib`), which may have these keys after `newmtl`:
///
///     density          kg/m^3                        sound_speed         m/s
///     attenuation      dB/cm at 1 MHz                attenuation_power   exponent of the frequency
///     backscatter_db   relative to liver             roughness_um        rms height
///     scatterers_per_mm3   for sparse speckle       priority            a whole number: of overlapping objects, that
///                                                                       with the highest priority gives the medium
///     structure        name of a tissue, or `none`   fibres    their direction in the file, as in `fibres 0 0 1`
///     pennation        degrees, -90 to 90: the fibres are the long axis of the object, turned by so much towards its
///                      flattest direction; both point to where their largest component is positive
///
/// With density and sound_speed they define a medium; without, they modify the tissue of that name. A name without
/// keys, or without a library, must be that of a tissue, such as `muscle`: see `tissue::all`.
/// Defined where INSONIFY_IMPLEMENTATION is defined.
/// @throws as load_obj, and io_error for a face without a material, an unknown material, a closed surface of two
/// materials, a library with values out of range, or one outside the folder of the file, unless `libraries` allows it
scene load_obj_scene(const std::string& path, const obj_settings& settings);

/// The same, and tells what the scene has otherwise than the file: objects that were given another name, because it was
/// taken; groups that were joined, because only together they are closed; what `repair` did to an object; and keys of a
/// material library that are neither ours nor those of renderers. The faces of the others are as in the file.
/// @param notes  a sentence for each, which begins with the path and the line; replaces its content
scene load_obj_scene(const std::string& path, const obj_settings& settings, std::vector<std::string>& notes);

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
    detail::check_rigid(at, "write_debug_obj", "the pose of the probe");
    if (probe.lines > 65536)
        throw usage_error{"write_debug_obj: ", probe.lines, " lines are more than 65536; draw fewer"};
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
