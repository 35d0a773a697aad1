#ifndef INSONIFY_CORE_ERROR_HPP
#define INSONIFY_CORE_ERROR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>

namespace insonify::inline INSONIFY_ABI {

/// A file could not be read or written, or its content is invalid. The message names the file and the line or object.
struct io_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An invalid mesh, pose or primitive. `validate` reports the defects of a mesh.
struct geometry_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A setting that is out of range, or a call out of order, such as tracing a scene that was not built.
struct usage_error : std::logic_error {
    using std::logic_error::logic_error;
};

namespace detail {

/// The parts of a message in one string. Compiles much faster than a sum of strings, which is inlined at every `throw`.
inline std::string joined(std::initializer_list<std::string_view> parts) {
    std::string whole;
    for (const std::string_view part : parts) whole.append(part.data(), part.size());
    return whole;
}

/// A number with up to so many significant digits and, in every locale, a decimal point.
inline std::string number_text(float value, int digits = 4) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, static_cast<double>(value));
    std::string number{text};
    std::replace(number.begin(), number.end(), ',', '.');
    return number;
}

/// "3 holes", "1 hole".
inline std::string counted(std::size_t count, const char* one, const char* many) {
    return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
