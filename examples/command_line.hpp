#ifndef INSONIFY_EXAMPLES_COMMAND_LINE_HPP
#define INSONIFY_EXAMPLES_COMMAND_LINE_HPP

#include "units.hpp"
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <iostream>
#include <string>
#include <type_traits>
#include <vector>

/// The command line of the programs, by CLI11: options whose values are checked before anything begins. Lengths are read with or
/// without a unit and stored in millimetres, frequencies in megahertz, angles in degrees.
namespace command_line {

namespace detail {

inline std::string text_of(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.9g", value);
    return digits;
}

template <std::size_t Count>
CLI::Validator in_units(const units::named_unit (&of)[Count], const char* sentence) {
    const auto convert = [&of, sentence](std::string& word) {
        const double value = units::number_with_unit(word, of);
        if (!std::isfinite(value)) return "'" + word + "' is not " + sentence;
        word = text_of(value);
        return std::string{};
    };
    return {convert, "", "unit"};
}

} // namespace detail

/// Turns "4cm" into "40"; "mm" is 1 mm. @{
inline CLI::Validator length() { return detail::in_units(units::lengths, units::a_length); }
inline CLI::Validator frequency() { return detail::in_units(units::frequencies, units::a_frequency); }
inline CLI::Validator angle() { return detail::in_units(units::angles, units::an_angle); }
/// @}

/// Accepts numbers above 0, up to a limit.
inline CLI::Validator positive_number(double high) {
    const auto check = [high](const std::string& given) {
        const double value = units::number_of(given);
        return value > 0 && value <= high ? std::string{}
                                          : given + " is not a number above 0, at most " + detail::text_of(high);
    };
    return {std::function<std::string(const std::string&)>{check}, "", "positive_number"};
}
/// Accepts numbers of a range.
inline CLI::Validator number(double low, double high) {
    const auto check = [low, high](const std::string& given) {
        const double value = units::number_of(given);
        return value >= low && value <= high
                   ? std::string{}
                   : given + " is not a number from " + detail::text_of(low) + " to " + detail::text_of(high);
    };
    return {std::function<std::string(const std::string&)>{check}, "", "number"};
}
/// Accepts whole numbers of a range.
inline CLI::Validator whole_number(std::uint64_t low, std::uint64_t high) {
    const auto check = [low, high](const std::string& given) {
        const bool digits = !given.empty() && given.find_first_not_of("0123456789") == std::string::npos;
        const double value = digits ? units::number_of(given) : -1;
        return value >= static_cast<double>(low) && value <= static_cast<double>(high)
                   ? std::string{}
                   : given + " is not a whole number from " + std::to_string(low) + " to " + std::to_string(high);
    };
    return {std::function<std::string(const std::string&)>{check}, "", "whole_number"};
}
/// Accepts names: an option that follows at once is not one.
inline CLI::Validator name() {
    const auto check = [](const std::string& given) {
        return given.empty()               ? std::string{"the name is empty"}
               : given.rfind("--", 0) == 0 ? "a name is missing before " + given
                                           : std::string{};
    };
    return {std::function<std::string(const std::string&)>{check}, "", "name"};
}

/// Accepts names of PNG files.
inline CLI::Validator png_name() {
    const auto check = [](const std::string& given) {
        return CLI::detail::to_lower(given).ends_with(".png") ? std::string{}
                                                              : given + " is not the name of a PNG file: x.png";
    };
    return {std::function<std::string(const std::string&)>{check}, "", "png_name"};
}

/// Declares an option with one value.
/// @param shown  what its value is, as --help shows it
template <class Value>
CLI::Option* add(CLI::App& app, const char* option, Value& value, const char* shown, const std::string& help) {
    return app.add_option(option, value, help)->type_name(shown)->option_text(shown)->expected(1);
}

/// Declares an option whose value is a whole number of a range, which --help states; the present value is the default where it
/// lies there.
template <class Value>
CLI::Option* add_whole_number(CLI::App& app, const char* option, Value& value, const char* shown,
                              const std::string& help, std::uint64_t low, std::uint64_t high) {
    std::string range = ", " + std::to_string(low) + " to " + std::to_string(high);
    if constexpr (std::is_integral_v<Value>)
        if (const auto now = static_cast<std::uint64_t>(value); now >= low && now <= high)
            range += " (" + std::to_string(now) + ")";
    return add(app, option, value, shown, help + range)->check(whole_number(low, high));
}

/// Declares an option whose value is a list of numbers in one word, such as 1,2,3.
/// @param unit  checks and changes each of them
template <std::size_t Count, class Number, class Target>
CLI::Option* add_list(CLI::App& app, const char* option, Target& value, char separator, const CLI::Validator& unit,
                      const char* shown, const std::string& help) {
    const auto parse = [&value, separator, unit, option, shown](const std::string& word) {
        std::vector<std::string> parts = CLI::detail::split(word, separator);
        std::array<Number, Count> numbers{};
        if (parts.size() != Count) throw CLI::ValidationError{option, "'" + word + "' is not " + shown};
        for (std::size_t i = 0; i < Count; ++i) {
            if (const std::string fault = unit(parts[i]); !fault.empty()) throw CLI::ValidationError{option, fault};
            numbers[i] = static_cast<Number>(units::number_of(parts[i]));
        }
        value = numbers;
    };
    return app.add_option_function<std::string>(option, parse, help)->type_name(shown)->option_text(shown)->expected(1);
}

/// Reads the command line, runs a program, and prints why it failed.
/// @param declare  declare(app) declares the options
/// @param run      run() returns the exit status
template <class Declare, class Run>
int run(const char* program, int count, char** arguments, const Declare& declare, const Run& work) {
    CLI::App app;
    try {
        app.get_formatter()->column_width(28);
        declare(app);
        app.parse(count, arguments);
        return work();
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const std::exception& fault) {
        std::cerr << program << ": " << fault.what() << '\n';
        return 2;
    }
}

/// Declares how the meshes of a file are read. @param pennation  degrees  @param file  the option that names it
inline void add_mesh_options(CLI::App& app, bool& repair, float& pennation, CLI::Option* file) {
    app.add_flag("--repair", repair, "closes and orients meshes that enclose nothing, and says what it did")
        ->needs(file);
    add(app, "--pennation", pennation, "ANGLE",
        "of muscles without fibres of their own: angle to their long axis, -90 to 90 (0)")
        ->transform(angle())
        ->check(number(-90, 90))
        ->needs(file);
}

} // namespace command_line

#endif
