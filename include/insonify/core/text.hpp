#ifndef INSONIFY_CORE_TEXT_HPP
#define INSONIFY_CORE_TEXT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <string_view>

namespace insonify::inline INSONIFY_ABI::detail {

/// The parts of a message in one string. Compiles much faster than a sum of strings, which is inlined at every `throw`.
inline std::string joined(std::initializer_list<std::string_view> parts) {
    std::string whole;
    for (const std::string_view part : parts) whole.append(part.data(), part.size());
    return whole;
}

/// A number with up to four significant digits and, in every locale, a decimal point.
inline std::string number_text(float value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", static_cast<double>(value));
    std::string number{text};
    std::replace(number.begin(), number.end(), ',', '.');
    return number;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
