#ifndef INSONIFY_EXAMPLES_REGION_VALUES_HPP
#define INSONIFY_EXAMPLES_REGION_VALUES_HPP

#include "anatomy/region.hpp"
#include "units.hpp"
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

/// The parameters of a region as users write them: lengths are in millimetres and angles in degrees unless a unit follows.
namespace anatomy {

/// In the unit that users write; not a number for a word that is no value of this parameter.
inline float written_value(const parameter& of, const std::string& word) {
    const std::string own = of.unit;
    return static_cast<float>(own == "m"     ? units::number_with_unit(word, units::lengths)
                              : own == "rad" ? units::number_with_unit(word, units::angles)
                                             : units::number_of(word));
}

/// Values by words such as "fat=6mm".
/// @throws usage_error  for another word, a name that is not a parameter's or is given twice, and a value out of range
inline values values_of(const region& of, const std::vector<std::string>& words) {
    values all;
    for (const std::string& text : words) {
        const std::string name = text.substr(0, text.find('='));
        const std::string word = text.substr(std::min(name.size() + 1, text.size()));
        if (name.empty() || word.empty())
            throw usage_error{"'" + text + "' is not a name and its value, such as fat=6mm or side=1"};
        const parameter& one = of.find_parameter(name);
        const float value = written_value(one, word);
        if (!std::isfinite(value)) {
            const std::string own = one.unit;
            throw usage_error{text + ": '" + word + "' is not " +
                              (own == "m"     ? units::a_length
                               : own == "rad" ? units::an_angle
                                              : "a number")};
        }
        const parameter_unit in = one.written_unit();
        if (!all.emplace(name, of.checked(one, value * in.size, in)).second)
            throw usage_error{"`" + name + "` is given twice; a body has one value"};
    }
    return all;
}

} // namespace anatomy

#endif
