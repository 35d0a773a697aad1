#ifndef INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP
#define INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>

/// The command line of `simulate`; lengths in millimetres, frequencies in megahertz, angles in degrees.
struct simulate_options {
    std::string file{}; ///< empty: the built-in phantom
    float unit = 1;
    std::string background = "fat";
    std::optional<std::array<float, 3>> fibres{}, layers{}; ///< of the background
    std::string probe{};
    std::optional<std::uint32_t> lines{};
    std::optional<float> width{}, radius{}, field_of_view{}, frequency{}, depth{};
    std::optional<std::array<float, 3>> from{}, towards{};
    std::array<float, 3> lateral{1, 0, 0};
    std::string law = "paper";
    std::optional<float> tgc{};
    std::uint32_t planes = 7, looks = 3;
    std::array<std::uint32_t, 2> size{768, 0};
    std::string output = "out";
};

/// Accepts numbers above 0. CLI::PositiveNumber does too, but prints the range of a double with 300 digits.
inline CLI::Validator positive_number() {
    const auto check = [](const std::string& given) {
        return std::strtof(given.c_str(), nullptr) > 0 ? std::string{} : given + " is not a number above 0";
    };
    return {check, "", "positive_number"};
}

/// Declares the options and where their values are stored.
inline void add_options(CLI::App& app, simulate_options& into) {
    using units = std::map<std::string, float>;
    const auto length = CLI::AsNumberWithUnit(units{{"um", 1e-3F}, {"mm", 1}, {"cm", 10}, {"m", 1000}});
    const auto frequency = CLI::AsNumberWithUnit(units{{"hz", 1e-6F}, {"khz", 1e-3F}, {"mhz", 1}});
    const auto add = [&](const char* name, auto& value, const char* shown, const char* help) {
        return app.add_option(name, value, help)->type_name(shown)->option_text(shown);
    };
    app.description(
        "Draws ultrasound images of an OBJ file, or of the built-in phantom of a nerve block.\n"
        "Lengths are in millimetres unless a unit follows (4cm), frequencies in megahertz, angles in degrees.");
    app.get_formatter()->column_width(28);

    add("file", into.file, "OBJ", "Wavefront OBJ; its materials name the tissues");
    add("--unit", into.unit, "LENGTH", "length of one unit of the file (1mm)")
        ->transform(length)
        ->check(positive_number());
    add("--background", into.background, "TISSUE", "medium around the objects of the file (fat)");
    add("--fibres", into.fibres, "X,Y,Z", "direction of the fibres of that medium (along the array)")->delimiter(',');
    add("--layers", into.layers, "X,Y,Z", "direction across its layers, from the skin inwards (away from the probe)")
        ->delimiter(',');
    add("--output", into.output, "FOLDER", "folder that the images are written to (out)");
    add("--size", into.size, "WxH", "image size in pixels; 0 keeps the aspect ratio (768x0)")->delimiter('x');

    add("--probe", into.probe, "KIND", "linear, convex or phased (convex; for the phantom linear)")
        ->check(CLI::IsMember({"linear", "convex", "phased"}));
    add("--lines", into.lines, "COUNT", "number of scan lines");
    add("--width", into.width, "LENGTH", "width of a linear or phased array")->transform(length);
    add("--radius", into.radius, "LENGTH", "radius of curvature of a convex array")->transform(length);
    add("--field-of-view", into.field_of_view, "ANGLE", "field of view of a convex or phased array")
        ->check(CLI::Range(0.0F, 360.0F));
    add("--frequency", into.frequency, "FREQUENCY", "centre frequency")->transform(frequency);
    add("--depth", into.depth, "LENGTH", "imaging depth (80; for the phantom 40)")
        ->transform(length)
        ->check(positive_number());

    auto* const from = add("--from", into.from, "X,Y,Z", "position of the probe: the middle of its face");
    auto* const towards = add("--towards", into.towards, "X,Y,Z",
                              "point that the probe looks at (default: along y, at the centre of all objects)");
    from->delimiter(',')->transform(length)->needs(towards);
    towards->delimiter(',')->transform(length)->needs(from);
    add("--lateral", into.lateral, "X,Y,Z", "direction of the array (1,0,0)")->delimiter(',')->transform(length);
    add("--law", into.law, "NAME",
        "variant of the paper's model for the component images: paper, as printed; attenuated, echoes are attenuated "
        "too; "
        "echo, attenuated both ways, bands behind interfaces (paper)")
        ->check(CLI::IsMember({"paper", "attenuated", "echo"}));
    add("--tgc", into.tgc, "NUMBER",
        "time gain compensation of the B-mode image in dB/(cm MHz) (the background's attenuation, 0.5 to 1)")
        ->check(positive_number());
    add("--planes", into.planes, "COUNT", "elevation planes of the B-mode image (slice thickness): 1, 3, 5 or 7 (7)");
    add("--looks", into.looks, "COUNT", "looks at angles within 16 degrees, averaged for the B-mode image (3)");
}

#endif
