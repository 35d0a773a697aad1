#ifndef INSONIFY_PYTHON_TUBE_LINES_HPP
#define INSONIFY_PYTHON_TUBE_LINES_HPP

#include "bindings.hpp"
#include <variant>

namespace insonify_python {

/// A `centre_line` in Python, with what it was made of: it is printed and pickled.
struct sectioned_line {
    std::vector<tube_section> sections{}; ///< empty: no line
    vec3 across{0, 0, 0};
    centre_line own{};
};

/// A line, or the sections of one: an array of N x 4 to 6.
using given_line = std::variant<sectioned_line, float_array>;

/// Sections, one a row: x, y and z of the centre, and the radius; or both radii; or both and the turn.
/// @param what  for the message, such as "make_tube: the line"
/// @throws usage_error  for an array of another shape
std::vector<tube_section> sections_of(const float_array& rows, const char* what);

/// The same as an array of N x 6.
float_array array_of_sections(const std::vector<tube_section>& sections);

/// @throws usage_error, geometry_error  for an array that is not that of a line
sectioned_line line_of(const given_line& given);

/// `tube_flow`, and `bent` maps, of a line that Python gave.
struct line_flow : tube_flow {
    sectioned_line course{};
};
template <class Map>
struct line_map : bent<Map> {
    sectioned_line course{};
};

/// The line of one of these, as a setting.
template <class Along>
void bind_line(settings_class<Along>& type, const char* doc) {
    type.property(
        "line", [](const Along& self) { return self.course; },
        [](Along& self, const given_line& given) {
            self.course = line_of(given);
            self.line = self.course.own;
        },
        doc);
}

} // namespace insonify_python
#endif
