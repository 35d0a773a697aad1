#ifndef INSONIFY_EXAMPLES_BODY_OPTIONS_HPP
#define INSONIFY_EXAMPLES_BODY_OPTIONS_HPP

#include <insonify/insonify.hpp>
#include "anatomy_check.hpp"
#include "region_options.hpp"
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// What lies there, and from where it is seen: options of `simulate` and `channels`. Lengths in millimetres, angles in degrees.
struct body_options : region_options {
    std::string file{}; ///< empty: a region, or a phantom
    bool list = false;
    float unit = 1;
    std::optional<std::string> background{};
    bool repair = false;
    float pennation = 0;
    std::optional<std::array<float, 3>> from{}, towards{}, lateral{};
};

/// Declares them. @param probe  what is placed, in words  @return the one of the file
inline CLI::Option* add_body_options(CLI::App& app, body_options& into, const std::string& probe) {
    using namespace command_line;
    CLI::Option* const file =
        add(app, "file", into.file, "OBJ", "Wavefront OBJ; its materials name the tissues")->check(name());
    add(app, "--unit", into.unit, "LENGTH", "length of 1 in the file, above 0, at most 10m (1mm)")
        ->transform(length())
        ->check(positive_number(1e4))
        ->needs(file);
    add(app, "--background", into.background, "TISSUE", "medium around the objects of the file (deep_fat)")
        ->check(name())
        ->needs(file);
    add_mesh_options(app, into.repair, into.pennation, file);
    add_region_options(app, into, "a region of the body instead of a file: see --list", 0, 999'999'999)->excludes(file);
    app.add_flag("--list", into.list,
                 "lists the regions, or that of --anatomy, with their views and parameters, and ends");
    auto* const from = add_list<3, float>(app, "--from", into.from, ',', length(), "X,Y,Z",
                                          "position of the " + probe + ": the middle of its face");
    auto* const towards =
        add_list<3, float>(app, "--towards", into.towards, ',', length(), "X,Y,Z",
                           "point that the " + probe + " looks at (default: along y, at the centre of all objects)");
    from->needs(towards);
    towards->needs(from);
    add_list<3, float>(app, "--lateral", into.lateral, ',', number(-1e6, 1e6), "X,Y,Z",
                       "direction of the array, for a file or with --from (1,0,0)");
    return file;
}

/// @throws usage_error  for a direction of the array that nothing uses
inline void check_place(const body_options& chosen) {
    if (chosen.lateral && chosen.file.empty() && !chosen.from)
        throw insonify::usage_error{"--lateral requires --from and --towards, or a file"};
}

/// From where the options look, or the usual place.
/// @{
inline insonify::pose pose_of(const body_options& chosen, const insonify::pose& usual) {
    using namespace insonify;
    if (!chosen.from) return usual;
    const auto vector = [](const std::array<float, 3>& of) { return vec3{of[0], of[1], of[2]}; };
    return look_at(1_mm * vector(*chosen.from), 1_mm * vector(*chosen.towards),
                   vector(chosen.lateral.value_or(std::array<float, 3>{1, 0, 0})));
}
/// The usual place of a file: 10 mm above the box around all objects, looking along y.
inline insonify::pose pose_of(const body_options& chosen, const insonify::aabb& box) {
    using namespace insonify;
    if (chosen.from) return pose_of(chosen, pose{});
    const std::array<float, 3> lateral = chosen.lateral.value_or(std::array<float, 3>{1, 0, 0});
    return look_at({box.centre().x, box.lower.y - 10_mm, box.centre().z}, box.centre(),
                   {lateral[0], lateral[1], lateral[2]});
}
/// @}

/// A region in one of its views, built; the probe of the view is pressed into the skin, unless options place it.
struct region_in_view {
    std::string title{};
    insonify::scene body{};
    insonify::pose at{};
    anatomy::view seen{};
};

/// @throws usage_error  for a region, view or parameter that there is not, and a value out of range
inline region_in_view load_region(const body_options& chosen) {
    const anatomy::region& region = anatomy::find_region(chosen.anatomy);
    anatomy::values values = parameters_of(chosen, region);
    if (chosen.seed) values.merge(region.drawn(*chosen.seed));
    anatomy::body made = region.make(values);
    const anatomy::view seen = chosen.view.empty() ? made.views.front() : made.find_view(chosen.view);
    made.anatomy.build(insonify::exec::par);
    const insonify::pose at = chosen.from ? pose_of(chosen, seen.at) : anatomy::press_probe(made.anatomy, seen);
    const std::string title{region.title};
    return {chosen.from ? title : title + ": " + seen.title, std::move(made.anatomy), at, seen};
}

/// The body of a file, not built, and what was read.
struct body_of_file {
    insonify::scene body{};
    std::string description{};
};

/// @throws io_error, usage_error  for a file that cannot be read
inline body_of_file load_file(const body_options& chosen) {
    using namespace insonify;
    const float unit = chosen.unit * 1_mm;
    const medium& background = tissue_named(chosen.background.value_or("deep_fat"));
    std::vector<std::string> notes;
    body_of_file made{
        .body = load_obj_scene(chosen.file, reading_of(unit, background, chosen.repair, chosen.pennation), notes)};
    made.description = describe_anatomy(chosen.file, made.body, unit, notes);
    return made;
}

/// Lists a region with its views and parameters.
inline void list_region(const anatomy::region& region) {
    std::printf("--anatomy %s: %s\n", region.name, region.title);
    for (const anatomy::view& view : region.make().views)
        std::printf("  --view %s: %s\n", view.name.c_str(), view.title.c_str());
    for (const anatomy::parameter& one : region.parameters) {
        const anatomy::parameter_unit in = one.written_unit();
        const auto text = [&](float value) {
            return one.is_choice ? std::to_string(std::lround(value)) : insonify::detail::number_text(value / in.size);
        };
        std::printf("  --parameter %s=%s%s: %s, %s to %s\n", one.name, text(one.usual).c_str(), in.name,
                    one.description, text(one.smallest).c_str(), text(one.largest).c_str());
    }
}
/// Lists a region by name, or all. @param only  empty: all  @throws usage_error  where there is no such region
inline void list_regions(const std::string& only) {
    if (!only.empty()) return list_region(anatomy::find_region(only));
    for (const anatomy::region& region : anatomy::regions()) list_region(region);
}

#endif
