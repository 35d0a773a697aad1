#ifndef INSONIFY_EXAMPLES_UNITS_HPP
#define INSONIFY_EXAMPLES_UNITS_HPP

#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <string>

/// Numbers with units, as users write them.
namespace units {

struct named_unit {
    const char* name;
    double factor;
};
inline constexpr named_unit lengths[] = {{"", 1}, {"um", 1e-3}, {"mm", 1}, {"cm", 10}, {"m", 1000}},
                            frequencies[] = {{"", 1}, {"Hz", 1e-6}, {"kHz", 1e-3}, {"MHz", 1}},
                            angles[] = {{"", 1}, {"deg", 1}, {"rad", 57.295779513082321}};

/// What a word with such a unit is, in messages.
inline constexpr const char *a_length = "a length, such as 40mm, 4cm or 0.04m",
                            *a_frequency = "a frequency, such as 5MHz", *an_angle = "an angle, such as 15deg";

/// The number of a whole word; not a number where the word is none.
inline double number_of(const std::string& word) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    return word.empty() || end != word.c_str() + word.size() ? std::nan("") : value;
}

/// The number of a word in the unit of `units`; a unit alone is one of it. Not a number where the word is none.
template <std::size_t Count>
double number_with_unit(const std::string& word, const named_unit (&units)[Count]) {
    char* end = nullptr;
    double value = std::strtod(word.c_str(), &end);
    if (word.empty()) return std::nan("");
    if (end == word.c_str()) value = 1;
    const auto lower = [](std::string text) {
        for (char& letter : text) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
        return text;
    };
    for (const named_unit& one : units)
        if (lower(end) == lower(one.name)) return value * one.factor;
    return std::nan("");
}

} // namespace units

#endif
