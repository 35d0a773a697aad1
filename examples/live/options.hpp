#ifndef INSONIFY_EXAMPLES_LIVE_OPTIONS_HPP
#define INSONIFY_EXAMPLES_LIVE_OPTIONS_HPP

#include "../command_line.hpp"
#include "anatomy.hpp"
#include <iterator>

/// Options that programs of this folder share.
namespace live {

/// Declares the options of an anatomy.
inline void add_anatomy_options(CLI::App& app, anatomy& into) {
    using namespace command_line;
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
    add(app, "--skin", into.skin, "SIDE",
        "side of its skin, +x, -x, +y, -y, +z or -z: turns it and moves it below the probe (it stays where it is, with "
        "+z "
        "into the body)")
        ->check(CLI::IsMember(std::vector<std::string>(std::begin(sides), std::end(sides))))
        ->needs(obj);
    add(app, "--tissue", into.tissue, "TISSUE", "tissue of all faces of a file without materials (muscle)")
        ->check(name())
        ->needs(obj);
    add(app, "--background", into.background, "TISSUE", "medium around its objects (air)")->check(name())->needs(obj);
}

inline constexpr std::uint64_t max_frames = 100'000'000; ///< of --frames

} // namespace live

#endif
