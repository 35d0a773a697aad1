#ifndef INSONIFY_IO_OBJ_HPP
#define INSONIFY_IO_OBJ_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/scene/scene.hpp>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// Which material libraries a mesh from elsewhere may make a program open.
enum class library_access {
    own_folder, ///< those in the folder of the OBJ file or below it, links followed
    anywhere,   ///< whatever it names
};

/// How to read a Wavefront OBJ file.
struct obj_settings {
    float unit = 0;                    ///< metres that 1 in the file stands for, as in {.unit = 1_mm}; must be given
    medium background = tissue::water; ///< of a scene: what fills the space around the objects
    library_access libraries = library_access::own_folder; ///< of a scene: which of those it names are opened
};

/// All faces of an OBJ file as one mesh. Groups and media are not looked at, and no other file is opened.
///
/// Polygons are cut into triangles, vertices that no face uses are dropped, the others keep their order.
/// Compiled where INSONIFY_IMPLEMENTATION is defined.
/// @throws usage_error  where the unit is missing
/// @throws io_error     naming the line, where the file is missing, empty or without faces, a number cannot be read, a
///                      vertex is not finite, or an index names a vertex that does not exist
mesh load_obj(const std::string& path, const obj_settings& settings);

/// An OBJ file as a scene, yet to be built: load_obj_scene(path, {.unit = 1_mm}).build(exec::par).
///
/// The faces of one object or group (`o`, `g`) with one medium (`usemtl`) make one object of the scene, named after the
/// object or group. The medium is looked up by its name in the material libraries (`mtllib`), which may hold these keys
/// under `newmtl`:
///
///     density          kg/m^3                        sound_speed         m/s
///     attenuation      dB/cm at 1 MHz                attenuation_power   exponent of the frequency
///     backscatter_db   relative to liver             roughness_um        rms height
///     scatterers_per_mm3   for sparse texture       priority            a whole number: of objects that overlap the
///                                                                       highest counts
///
/// With density and sound_speed they describe the medium completely; with fewer they change the tissue of that name.
/// A name without any key, or without a library, must be that of a tissue, such as `muscle`: see `tissue::all`.
/// Compiled where INSONIFY_IMPLEMENTATION is defined.
/// @throws as load_obj, and io_error for a face without a medium, an unknown medium, a library with values that make no
///         sense, or one outside of the file's own folder, unless `libraries` allows it
scene load_obj_scene(const std::string& path, const obj_settings& settings);

} // namespace insonify::inline INSONIFY_ABI
#endif
