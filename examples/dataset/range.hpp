#ifndef INSONIFY_DATASET_RANGE_HPP
#define INSONIFY_DATASET_RANGE_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include "text.hpp"
#include <istream>
#include <sstream>
#include <string>

namespace dataset {

/// From what to what a number varies, uniformly: `3..5`, or `4` for one value.
struct range {
    float from = 0;
    float to = 0;

    friend std::istream& operator>>(std::istream& text, range& read) {
        std::string word;
        text >> word;
        const std::size_t dots = word.find("..");
        const auto number = [&](const std::string& part) {
            std::size_t used = 0;
            float value = 0;
            try {
                value = std::stof(part, &used);
            } catch (const std::exception&) {
                used = 0;
            }
            if (used == 0 || used != part.size() || !insonify::is_finite(value)) text.setstate(std::ios::failbit);
            return value;
        };
        read.from = number(word.substr(0, dots));
        read.to = dots == std::string::npos ? read.from : number(word.substr(dots + 2));
        return text;
    }
    std::string text() const { return digits(from) + (from == to ? "" : ".." + digits(to)); }

    static bool readable(const std::string& word) {
        std::istringstream text{word};
        range read;
        return word.find_first_of(" \t") == std::string::npos && static_cast<bool>(text >> read);
    }
    /// How to write what cannot be read; empty where it can.
    static std::string complaint(const std::string& word) {
        if (readable(word)) return "";
        const std::size_t mark = word.find_first_of("-:,", 1);
        const std::string meant = mark == std::string::npos ? "" : word.substr(0, mark) + ".." + word.substr(mark + 1);
        return "'" + word + "' is neither a number nor a range; a range is written " +
               (readable(meant) ? meant : "with two dots, such as 5..9");
    }
};

/// A range of a parameter by its name: `fat=3..5`. Its unit is the parameter's.
struct named_range {
    std::string name{}, text{}, from{}, to{};

    /// @throws usage_error  for other words
    explicit named_range(const std::string& word) {
        const std::size_t sign = word.find('=');
        name = word.substr(0, sign);
        if (sign != std::string::npos) text = word.substr(sign + 1);
        if (name.empty() || text.empty())
            throw insonify::usage_error{"--parameter: '" + word + "' is not a name and a range, such as fat=3..5"};
        const std::size_t dots = text.find("..");
        from = text.substr(0, dots);
        to = dots == std::string::npos ? from : text.substr(dots + 2);
    }
};

} // namespace dataset
#endif
