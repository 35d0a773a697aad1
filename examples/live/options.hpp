#ifndef INSONIFY_EXAMPLES_LIVE_OPTIONS_HPP
#define INSONIFY_EXAMPLES_LIVE_OPTIONS_HPP

#include "../region_options.hpp"
#include "recording.hpp"
#include <iterator>

/// Options that programs of this folder share.
namespace live {

/// The options of what a program examines: a file, or a region of the body.
struct anatomy_options {
    anatomy_file file{};
    region_options region{};
};

/// Declares the options of an anatomy.
inline void add_anatomy_options(CLI::App& app, anatomy_options& chosen) {
    using namespace command_line;
    anatomy_file& into = chosen.file;
    CLI::Option* const obj =
        add(app, "--obj", into.file, "FILE",
            "anatomy: Wavefront OBJ, whose materials name the tissues (a phantom of a nerve block)")
            ->check(name());
    app.add_option_function<float>(
           "--unit", [&into](const float& millimetres) { into.unit = millimetres * 1_mm; },
           "length of 1 in that file (1mm, as most segmentations of medical images have it)")
        ->type_name("LENGTH")
        ->option_text("LENGTH")
        ->transform(length())
        ->check(positive_number(1e4))
        ->needs(obj);
    app.add_option_function<float>(
           "--skin", [&into](const float& millimetres) { into.skin = millimetres * 1_mm; },
           "thickness of skin below the surface of an object that encloses all others; 0: none, at most 20mm (1.5mm)")
        ->type_name("LENGTH")
        ->option_text("LENGTH")
        ->transform(length())
        ->check(number(0, 20))
        ->needs(obj);
    add(app, "--skin-side", into.side, "SIDE",
        "side of its skin, +x, -x, +y, -y, +z or -z: turns it and moves it below the probe (it stays where it is, with "
        "+z into the body)")
        ->check(CLI::IsMember(std::vector<std::string>(std::begin(sides), std::end(sides))))
        ->needs(obj);
    add_mesh_options(app, into.repair, into.pennation, obj);
    add(app, "--tissue", into.tissue, "TISSUE", "tissue of all faces of a file without materials (muscle)")
        ->check(name())
        ->needs(obj);
    add(app, "--background", into.background, "TISSUE", "medium around its objects (air)")->check(name())->needs(obj);
    std::string regions;
    for (const ::anatomy::region& one : ::anatomy::regions())
        regions += std::string{regions.empty() ? "" : ", "} + one.name;
    add_region_options(app, chosen.region, "a region of the body instead of a file: " + regions, 1, max_patient)
        ->excludes(obj);
}

/// What they ask for. @throws usage_error  for a region, view or parameter that does not exist, or a value out of range
inline anatomy_choice choice_of(const anatomy_options& chosen) {
    const region_options& asked = chosen.region;
    anatomy_choice choice{.file = chosen.file};
    if (asked.anatomy.empty()) return choice;
    choice.case_number = find_case(asked.anatomy, asked.view);
    choice.patient = static_cast<std::uint32_t>(asked.seed.value_or(0));
    const ::anatomy::region& region = ::anatomy::find_region(asked.anatomy);
    choice.given = checked(asked.anatomy, parameters_of(asked, region));
    return choice;
}

inline constexpr std::uint64_t max_frames = 100'000'000; ///< of --frames

} // namespace live

#endif
