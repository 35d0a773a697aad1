#ifndef INSONIFY_EXAMPLES_LIVE_OBJ_HPP
#define INSONIFY_EXAMPLES_LIVE_OBJ_HPP

#include "../anatomy_check.hpp"
#include "session.hpp"
#include <stdexcept>
#include <string>

namespace live {

/// Metres from a length such as "1mm", "2.5cm" or "m". @throws std::invalid_argument  for anything else
inline float unit_of(const std::string& length) {
    const std::size_t number_end = std::min(length.find_first_not_of("0123456789."), length.size());
    const std::string unit = length.substr(number_end);
    const float metres = unit == "mm" ? 1e-3F : unit == "cm" ? 1e-2F : unit == "m" ? 1.0F : 0.0F;
    const float number = number_end > 0 ? parse_number("the unit", length.substr(0, number_end)) : 1.0F;
    if (!(number * metres > 0))
        throw std::invalid_argument{"the unit is '" + length + "'; it must be a length in mm, cm or m, such as 1mm"};
    return number * metres;
}

/// A session whose patient is an OBJ file: materials are tissues of the library, see `load_obj_scene`. +z points into
/// the body; the probe begins above the middle of its skin.
/// @param unit        of the file, metres
/// @param background  medium around its objects
/// @throws std::runtime_error  for a file that cannot be read, or a mesh that is open, naming the object and what to do
inline session session_of_obj(const std::string& path, float unit, const medium& background = patient::air) {
    scene body = load_obj_scene(path, {.unit = unit, .background = background});
    check_anatomy(body, path, unit);
    body.build(exec::par);
    return session{std::move(body)};
}

} // namespace live

#endif
