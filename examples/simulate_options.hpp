#ifndef INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP
#define INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

/// What the command line of `simulate` says; lengths in millimetres, the frequency in megahertz, angles in degrees.
struct simulate_options {
    std::string file{}; ///< empty: the built-in phantom
    float unit = 1;
    std::string background = "fat";
    std::string probe{};
    std::optional<std::uint32_t> lines{};
    std::optional<float> width{}, radius{}, field_of_view{}, frequency{}, depth{};
    std::optional<std::array<float, 3>> from{}, towards{};
    std::array<float, 3> lateral{1, 0, 0};
    std::string law = "paper";
    std::optional<float> tgc{};
    std::uint32_t planes = 7;
    std::array<std::uint32_t, 2> size{768, 0};
    std::string output = "out";
};

/// Tells the parser what to read where.
inline void add_options(CLI::App& app, simulate_options& into) {
    using units = std::map<std::string, float>;
    const auto length = CLI::AsNumberWithUnit(units{{"um", 1e-3F}, {"mm", 1}, {"cm", 10}, {"m", 1000}});
    const auto frequency = CLI::AsNumberWithUnit(units{{"hz", 1e-6F}, {"khz", 1e-3F}, {"mhz", 1}});
    const auto add = [&](const char* name, auto& value, const char* shown, const char* help) {
        return app.add_option(name, value, help)->type_name(shown)->option_text(shown);
    };
    app.description(
        "Draws ultrasound pictures of an OBJ file, or of the built-in phantom of a nerve block.\n"
        "Lengths are in millimetres unless a unit follows (4cm), frequencies in megahertz, angles in degrees.");
    app.get_formatter()->column_width(28);

    add("file", into.file, "OBJ", "Wavefront OBJ; its materials say what tissue it is");
    add("--unit", into.unit, "LENGTH", "what 1 in the file stands for (1mm)")
        ->transform(length)
        ->check(CLI::PositiveNumber);
    add("--background", into.background, "TISSUE", "what surrounds the objects of the file (fat)");
    add("--output", into.output, "FOLDER", "where the pictures go (out)");
    add("--size", into.size, "WxH", "of the pictures; a 0 is chosen to fit (768x0)")->delimiter('x');

    add("--probe", into.probe, "KIND", "linear, convex or phased (convex; for the phantom linear)")
        ->check(CLI::IsMember({"linear", "convex", "phased"}));
    add("--lines", into.lines, "COUNT", "of a frame");
    add("--width", into.width, "LENGTH", "of the face of a linear or phased array")->transform(length);
    add("--radius", into.radius, "LENGTH", "of the face of a convex array")->transform(length);
    add("--field-of-view", into.field_of_view, "ANGLE", "of a convex or phased array")->check(CLI::Range(0.0F, 360.0F));
    add("--frequency", into.frequency, "FREQUENCY", "of the sound")->transform(frequency);
    add("--depth", into.depth, "LENGTH", "of the picture (80; for the phantom 40)")
        ->transform(length)
        ->check(CLI::PositiveNumber);

    add("--from", into.from, "X,Y,Z", "middle of the probe's face")->delimiter(',')->transform(length);
    add("--towards", into.towards, "X,Y,Z", "what it looks at (without both: along y, at the middle of all objects)")
        ->delimiter(',')
        ->transform(length);
    add("--lateral", into.lateral, "X,Y,Z", "direction of the array (1,0,0)")->delimiter(',')->transform(length);
    add("--law", into.law, "NAME",
        "of the component pictures: paper, as printed; attenuated, so are echoes too; echo, that there and back, "
        "behind interfaces (paper)")
        ->check(CLI::IsMember({"paper", "attenuated", "echo"}));
    add("--tgc", into.tgc, "NUMBER", "of the B-mode: dB/(cm MHz) to make up for (the background's, 0.5 to 1)")
        ->check(CLI::PositiveNumber);
    add("--planes", into.planes, "COUNT", "of the B-mode: slices for the thickness of the beam, 1, 3, 5 or 7 (7)");
}

#endif
