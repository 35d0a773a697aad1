#ifndef INSONIFY_CHANNELS_ARRAYS_HPP
#define INSONIFY_CHANNELS_ARRAYS_HPP

#include <insonify/channels/element_array.hpp>
#include <insonify/channels/transmit.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include "../command_line.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

/// The arrays and transmits that options name.
namespace channels {

using namespace insonify;

/// An array that --array names.
struct named_array {
    const char* name; ///< of the option
    const char* title;
    const char* type;  ///< linear, phased or curved
    float opening_deg; ///< beyond the ends of the array, of the slice that is covered
    std::variant<element_array, convex_element_array> elements;
};

/// All of them.
inline const std::vector<named_array>& arrays() {
    static const std::vector<named_array> all{
        {"l11_5v", "L11-5v", "linear", 30, presets::l11_5v_elements},
        {"l12_3v", "L12-3v", "linear", 30, presets::l12_3v_elements},
        {"c5_2v", "C5-2v", "curved", 30, presets::c5_2v_elements},
        {"p4_2v", "P4-2v", "phased", 45, presets::p4_2v_elements},
    };
    return all;
}
inline std::vector<std::string> array_names() {
    std::vector<std::string> names;
    for (const named_array& one : arrays()) names.emplace_back(one.name);
    return names;
}

/// @throws usage_error  for another name
inline const named_array& find_array(const std::string& name) {
    for (const named_array& one : arrays())
        if (one.name == name) return one;
    throw usage_error{"--array: there is no array '" + name + "'"};
}

/// The type of the arrays that scan as a probe does.
inline const char* array_type(const std::variant<linear_array, convex_array, phased_array>& probe) {
    constexpr const char* types[] = {"linear", "curved", "phased"};
    return types[probe.index()];
}
/// The first array of a type.
inline const named_array& array_of_type(const std::string& type) {
    return *std::find_if(arrays().begin(), arrays().end(), [&](const named_array& one) { return one.type == type; });
}

/// The names of all arrays of a type, in words.
inline std::string arrays_of_type(const std::string& type) {
    std::string names;
    for (const named_array& one : arrays())
        if (one.type == type) names += (names.empty() ? "" : " or ") + std::string{one.name};
    return names;
}

/// The transmits that --transmits names.
/// @throws usage_error  for a word that is none of its kinds, or numbers out of range
template <element_transducer Array>
std::vector<transmit> transmits_named(const std::string& text, const Array& array) {
    const std::vector<std::string> words = CLI::detail::split(text, ':');
    const std::string& kind = words[0];
    const auto fail = [&](const std::string& what) -> usage_error {
        return usage_error{"--transmits: '" + text + "': " + what};
    };
    if (text == "fsa") return full_synthetic_aperture(array);
    const bool is_complete =
        !text.ends_with(':') && ((kind == "plane" && words.size() == 3) || (kind == "diverging" && words.size() == 4) ||
                                 (kind == "focused" && (words.size() == 3 || words.size() == 4)));
    if (!is_complete)
        throw fail("it must be plane:COUNT:ANGLE, diverging:COUNT:ANGLE:LENGTH, focused:COUNT:DEPTH, "
                   "focused:COUNT:DEPTH:ANGLE or fsa");
    if (const std::string fault = command_line::whole_number(1, 1024)(words[1]); !fault.empty())
        throw fail("the count " + fault);
    const auto count = static_cast<std::uint32_t>(std::stoul(words[1]));
    const auto length_of = [&](std::string word) {
        if (std::string fault = command_line::length()(word); !fault.empty()) throw fail(fault);
        if (const std::string fault = command_line::positive_number(1000)(word); !fault.empty())
            throw fail("the length " + fault);
        return static_cast<float>(units::number_of(word)) * 1_mm;
    };
    const auto angle_of = [&](std::string word) {
        if (std::string fault = command_line::angle()(word); !fault.empty()) throw fail(fault);
        if (const std::string fault = command_line::number(0, 160)(word); !fault.empty())
            throw fail("the angle " + fault);
        return static_cast<float>(units::number_of(word)) * 1_deg;
    };
    const auto fraction = [&](std::uint32_t i) { // -0.5 to 0.5, both ends included
        return count == 1 ? 0.0F : static_cast<float>(i) / static_cast<float>(count - 1) - 0.5F;
    };
    const auto towards = [&](float angle) { return vec3{std::sin(angle), 0, std::cos(angle)}; };
    if (kind == "plane") return plane_waves(array, count, angle_of(words[2]));
    std::vector<vec3> points(count);
    if (kind == "diverging") {
        const float spread = angle_of(words[2]), behind = length_of(words[3]);
        for (std::uint32_t i = 0; i < count; ++i) points[i] = -behind * towards(spread * fraction(i));
        return diverging_waves(array, points);
    }
    const float depth = length_of(words[2]);
    if (words.size() == 4) {
        const float spread = angle_of(words[3]);
        for (std::uint32_t i = 0; i < count; ++i) points[i] = depth * towards(spread * fraction(i));
        return focused(array, points);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        const float place = (static_cast<float>(i) + 0.5F) / static_cast<float>(count);
        const ray beam = array.element(static_cast<std::uint32_t>(place * static_cast<float>(array.elements)));
        points[i] = beam.origin + depth * beam.direction;
    }
    return focused(array, points, array.fnumber);
}

} // namespace channels
#endif
