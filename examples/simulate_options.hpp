#ifndef INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP
#define INSONIFY_EXAMPLES_SIMULATE_OPTIONS_HPP

#include <insonify/examinations.hpp>
#include "region_options.hpp"
#include <cmath>
#include <optional>

/// The command line of `simulate`; lengths in millimetres, frequencies in megahertz, angles in degrees.
struct simulate_options : region_options {
    std::string file{}; ///< empty: a region, or the built-in phantom
    bool list = false;
    float unit = 1;
    std::optional<std::string> background{};
    std::optional<float> skin{};
    bool repair = false;
    float pennation = 0;
    std::optional<std::array<float, 3>> fibres{}, layers{}; ///< of the background
    std::string probe{};
    std::optional<std::uint32_t> lines{};
    std::optional<float> width{}, radius{}, field_of_view{}, frequency{}, depth{};
    std::optional<std::array<float, 3>> from{}, towards{}, lateral{};
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

    CLI::Option* const file =
        add(app, "file", into.file, "OBJ", "Wavefront OBJ; its materials name the tissues")->check(name());
    add(app, "--unit", into.unit, "LENGTH", "length of 1 in the file, above 0, at most 10m (1mm)")
        ->transform(length())
        ->check(positive_number(1e4))
        ->needs(file);
    add(app, "--background", into.background, "TISSUE", "medium around the objects of the file (deep_fat)")
        ->check(name())
        ->needs(file);
    add(app, "--skin", into.skin, "LENGTH",
        "thickness of skin below the outer surface of a body, or below the face of the probe, with gel and fat; 0: "
        "none, "
        "at most 20mm (1.5; with --background 0)")
        ->transform(length())
        ->check(number(0, 20))
        ->needs(file);
    add_mesh_options(app, into.repair, into.pennation, file);
    const CLI::Validator component = number(-1e6, 1e6);
    add_list<3, float>(app, "--fibres", into.fibres, ',', component, "X,Y,Z",
                       "direction of the fibres of that medium (along the array)")
        ->needs(file);
    add_list<3, float>(app, "--layers", into.layers, ',', component, "X,Y,Z",
                       "direction across its layers, from the skin inwards (away from the probe)")
        ->needs(file);
    add_region_options(app, into, "a region of the body instead of a file: see --list", 0, 999'999'999)->excludes(file);
    app.add_flag("--list", into.list, "lists the regions with their views and parameters, and ends");
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

    auto* const from = add_list<3, float>(app, "--from", into.from, ',', length(), "X,Y,Z",
                                          "position of the probe: the middle of its face");
    auto* const towards =
        add_list<3, float>(app, "--towards", into.towards, ',', length(), "X,Y,Z",
                           "point that the probe looks at (default: along y, at the centre of all objects)");
    from->needs(towards);
    towards->needs(from);
    add_list<3, float>(app, "--lateral", into.lateral, ',', component, "X,Y,Z",
                       "direction of the array, for a file or with --from (1,0,0)");
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
