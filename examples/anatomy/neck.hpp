#ifndef INSONIFY_EXAMPLES_ANATOMY_NECK_HPP
#define INSONIFY_EXAMPLES_ANATOMY_NECK_HPP

#include <insonify/examinations.hpp>
#include "media.hpp"
#include "region.hpp"
#include "shapes.hpp"
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace anatomy {

/// What varies from neck to neck.
struct neck {
    float side = 0;       ///< 0: left, 1: right
    float resolution = 1; ///< cells are divided by it
    float fat = 3.5_mm;

    static const std::vector<member<neck>>& members() {
        static const std::vector<member<neck>> all{
            {"side", "", "side of the views: 0 left, 1 right", &neck::side, 0, 1, true},
            {"resolution", "", "cells of the meshes are divided by it", &neck::resolution, 0.3F, 2},
            {"fat", "m", "thickness of the subcutaneous fat", &neck::fat, 1.5_mm, 8_mm},
        };
        return all;
    }
};

/// The neck.
inline body make(const neck& of) {
    body made{.anatomy = scene{tissue::connective_tissue}};
    const swept outline{.sections = {{-70_mm, {0, 56_mm}, 64_mm, 56_mm}, {50_mm, {0, 56_mm}, 64_mm, 56_mm}},
                        .power = 2,
                        .start = 1_mm,
                        .end = 1_mm};
    made.anatomy.add(outline.surface(4_mm / of.resolution, 5_mm), tissue::gel, {.priority = -1000, .name = "gel"});
    made.anatomy.add(outline.surface(4_mm / of.resolution), media::skin, {.name = "skin"});
    made.anatomy.add(outline.surface(4_mm / of.resolution, -1.8_mm), media::fat, {.name = "fat"});
    made.anatomy.add(outline.surface(4_mm / of.resolution, -1.8_mm - of.fat), tissue::muscle, {.name = "muscle"});
    made.views.push_back({"carotid_transverse",
                          "carotid artery, across",
                          look_at({0, 0, -0.4_mm}, {0, 0, 1}, {1, 0, 0}),
                          presets::nerve_block.probe,
                          presets::nerve_block.settings,
                          {}});
    return made;
}

} // namespace anatomy

#endif
