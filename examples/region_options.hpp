#ifndef INSONIFY_EXAMPLES_REGION_OPTIONS_HPP
#define INSONIFY_EXAMPLES_REGION_OPTIONS_HPP

#include "anatomy/regions.hpp"
#include "command_line.hpp"
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

/// The options of a region of the body, of all programs that draw one.
struct region_options {
    std::string anatomy{}, view{};         ///< of `anatomy::regions()`; empty: none, its first one
    std::vector<std::string> parameters{}; ///< of the region: "name=value"
    std::optional<std::uint64_t> seed{};   ///< draws the parameters of the region
};

/// Declares them. @param which  what --anatomy is, in words  @param low, high  of --seed  @return the one of the region
inline CLI::Option* add_region_options(CLI::App& app, region_options& into, const std::string& which, std::uint64_t low,
                                       std::uint64_t high) {
    using namespace command_line;
    CLI::Option* const region = add(app, "--anatomy", into.anatomy, "REGION", which)->check(name());
    add(app, "--view", into.view, "NAME", "standard view of the region, with its own probe (the first)")
        ->check(name())
        ->needs(region);
    app.add_option("--parameter", into.parameters, "of the region, such as fat=6mm; may be repeated")
        ->type_name("NAME=VALUE")
        ->option_text("NAME=VALUE")
        ->allow_extra_args(false)
        ->needs(region);
    add_whole_number(app, "--seed", into.seed, "NUMBER", "draws the parameters of the region", low, high)
        ->needs(region);
    return region;
}

/// The values of --parameter: lengths as those of the command line, others as numbers.
/// @throws usage_error  for a text that is no name and value
inline anatomy::values parameters_of(const region_options& chosen, const anatomy::region& region) {
    using namespace insonify;
    anatomy::values values;
    for (const std::string& text : chosen.parameters) {
        const std::string name = text.substr(0, text.find('='));
        std::string value = text.substr(std::min(name.size() + 1, text.size()));
        const bool is_length = std::any_of(region.parameters.begin(), region.parameters.end(), [&](const auto& one) {
            return one.name == name && std::string{one.unit} == "m";
        });
        if (is_length)
            if (const std::string fault = command_line::length()(value); !fault.empty())
                throw usage_error{"--parameter: " + text + ": " + fault};
        const double number = command_line::detail::number_of(value);
        if (!std::isfinite(number))
            throw usage_error{"--parameter: '" + text + "' is not a name and its value, such as fat=6mm or side=1"};
        values[name] = static_cast<float>(number) * (is_length ? 1_mm : 1);
    }
    return values;
}

#endif
