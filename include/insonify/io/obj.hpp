#ifndef INSONIFY_IO_OBJ_HPP
#define INSONIFY_IO_OBJ_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/scene/scene.hpp>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

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
};

/// Loads all faces of an OBJ file as one mesh. Groups and materials are ignored, and no other file is opened.
///
/// Polygons are triangulated and unused vertices removed; the others keep their order.
/// Defined where INSONIFY_IMPLEMENTATION is defined.
/// @throws usage_error  for a missing unit
/// @throws io_error     naming the line, for a file that is missing, empty or without faces, a malformed number, a
///                      vertex that is not finite, or an index out of range
mesh load_obj(const std::string& path, const obj_settings& settings);

/// Loads an OBJ file as a scene, which has yet to be built: load_obj_scene(path, {.unit = 1_mm}).build(exec::par).
///
/// The faces of one object (`o`), group (`g`) and material (`usemtl`) become one object of the scene. It has the name of the
/// `o`; where an `o` has several groups, `heart/left`; without an `o`, that of the group; else that of the material. Each `o`
/// line begins another object. Of equal names, all but the first get a number: `rib`, `rib.2`. The material is looked up by name in the material libraries (`mtllib`), which may have these
/// keys after `newmtl`:
///
///     density          kg/m^3                        sound_speed         m/s
///     attenuation      dB/cm at 1 MHz                attenuation_power   exponent of the frequency
///     backscatter_db   relative to liver             roughness_um        rms height
///     scatterers_per_mm3   for sparse speckle       priority            a whole number: of overlapping objects, that
///                                                                       with the highest priority gives the medium
///     structure        name of a tissue, or `none`
///
/// With density and sound_speed they define a medium; without, they modify the tissue of that name. A name without
/// keys, or without a library, must be that of a tissue, such as `muscle`: see `tissue::all`.
/// Defined where INSONIFY_IMPLEMENTATION is defined.
/// @throws as load_obj, and io_error for a face without a material, an unknown material, a closed surface of two materials, a
///         library with values out of range, or one outside the folder of the file, unless `libraries` allows it
scene load_obj_scene(const std::string& path, const obj_settings& settings);

/// The same, and tells what the scene has otherwise than the file: objects that were given another name, because it was
/// taken, and groups that were joined, because only together they are closed. The faces of the others are as in the file.
/// @param notes  a sentence for each, which begins with the path and the line; replaces its content
scene load_obj_scene(const std::string& path, const obj_settings& settings, std::vector<std::string>& notes);

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
