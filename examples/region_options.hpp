#ifndef INSONIFY_EXAMPLES_REGION_OPTIONS_HPP
#define INSONIFY_EXAMPLES_REGION_OPTIONS_HPP

#include "anatomy/regions.hpp"
#include "command_line.hpp"
#include "region_values.hpp"
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

/// The values of --parameter. @throws usage_error  as `anatomy::values_of`
inline anatomy::values parameters_of(const region_options& chosen, const anatomy::region& region) {
    try {
        return anatomy::values_of(region, chosen.parameters);
    } catch (const insonify::usage_error& fault) {
        throw insonify::usage_error{std::string{"--parameter: "} + fault.what()};
    }
}

#endif
