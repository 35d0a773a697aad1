#ifndef INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP
#define INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP

#include <insonify/examinations.hpp>
#include "body_options.hpp"
#include <array>
#include <cmath>
#include <optional>
#include <string>

/// The command line of `simulate`; lengths in millimetres, frequencies in megahertz, angles in degrees.
struct simulate_options : body_options {
    std::optional<float> skin{};
    std::optional<std::array<float, 3>> fibres{}, layers{}; ///< of the background
    std::string probe{};
    std::optional<std::uint32_t> lines{};
    std::optional<float> width{}, radius{}, field_of_view{}, frequency{}, depth{};
    std::string law = "paper";
    std::optional<float> tgc{};
    std::optional<std::uint32_t> planes{}, looks{};
    std::array<std::uint32_t, 2> size{768, 0};
    std::string output = "out";
};

/// Declares the options and where their values are stored.
inline void add_options(CLI::App& app, simulate_options& into) {
    using namespace command_line;
    app.description(
        "Draws ultrasound images of an OBJ file, of a region of the body that is made by code, or of the phantom of a "
        "nerve block.\n"
        "Lengths are in millimetres unless a unit follows (4cm), frequencies in megahertz, angles in degrees.");

    CLI::Option* const file = add_body_options(app, into, "probe");
    add(app, "--skin", into.skin, "LENGTH",
        "thickness of skin below the outer surface of a body, or below the face of the probe, with gel and fat; 0: "
        "none, "
        "at most 20mm (1.5; with --background 0)")
        ->transform(length())
        ->check(number(0, 20))
        ->needs(file);
    const CLI::Validator component = number(-1e6, 1e6);
    add_list<3, float>(app, "--fibres", into.fibres, ',', component, "X,Y,Z",
                       "direction of the fibres of that medium (along the array)")
        ->needs(file);
    add_list<3, float>(app, "--layers", into.layers, ',', component, "X,Y,Z",
                       "direction across its layers, from the skin inwards (away from the probe)")
        ->needs(file);
    add(app, "--output", into.output, "FOLDER", "folder that the images are written to (out)")->check(name());
    add_list<2, std::uint32_t>(app, "--size", into.size, 'x', whole_number(0, 16384), "WxH",
                               "image size in pixels, 0 to 16384; 0 keeps the aspect ratio (768x0)");

    add(app, "--probe", into.probe, "KIND", "linear, convex or phased (convex; for the phantom linear)")
        ->check(CLI::IsMember({"linear", "convex", "phased"}));
    add_whole_number(app, "--lines", into.lines, "COUNT", "number of scan lines", 1, 4096);
    add(app, "--width", into.width, "LENGTH", "width of a linear or phased array, at most 1m")
        ->transform(length())
        ->check(positive_number(1000));
    add(app, "--radius", into.radius, "LENGTH", "radius of curvature of a convex array, at most 1m")
        ->transform(length())
        ->check(positive_number(1000));
    add(app, "--field-of-view", into.field_of_view, "ANGLE",
        "field of view of a convex array, at most 360, or of a phased one, at most 180")
        ->transform(angle())
        ->check(positive_number(360));
    add(app, "--frequency", into.frequency, "FREQUENCY", "centre frequency, at most 100MHz")
        ->transform(frequency())
        ->check(positive_number(100));
    add(app, "--depth", into.depth, "LENGTH", "imaging depth, at most 1m (80; for the phantom 40)")
        ->transform(length())
        ->check(positive_number(1000));
    add(app, "--law", into.law, "NAME",
        "variant of the paper's model for the component images: paper, as printed; attenuated, echoes are attenuated "
        "too; echo, attenuated both ways, bands behind interfaces (paper)")
        ->check(CLI::IsMember({"paper", "attenuated", "echo"}));
    add(app, "--tgc", into.tgc, "NUMBER",
        "time gain compensation of the B-mode image in dB/(cm MHz), at most 100 (the background's attenuation, 0.5 to "
        "1)")
        ->check(positive_number(100));
    add(app, "--planes", into.planes, "COUNT",
        "elevation planes of the B-mode image (slice thickness): 1, 3, 5 or 7 (7)")
        ->check(CLI::IsMember({"1", "3", "5", "7"}));
    add_whole_number(
        app, "--looks", into.looks, "COUNT",
        "looks at angles within " +
            std::to_string(std::lround(insonify::presets::nerve_block.settings.compound.spread * 180 / insonify::pi)) +
            " degrees (3), averaged for the B-mode image",
        1, 31);
}

#endif
