#ifndef INSONIFY_FWD_HPP
#define INSONIFY_FWD_HPP

#include <insonify/core/config.hpp>

/// Forward declarations; may be included from any folder.
namespace insonify::inline INSONIFY_ABI {

struct acquisition;
struct convex_array;
struct law2011;
struct linear_array;
struct medium;
struct mesh;
struct mesh_view;
struct phased_array;
struct radial_array;
struct pose;
struct ray;
class scene;

template <class Pixel>
struct pixel_grid;
using image = pixel_grid<float>;

} // namespace insonify::inline INSONIFY_ABI
#endif
