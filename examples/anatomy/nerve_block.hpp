#ifndef INSONIFY_EXAMPLES_ANATOMY_NERVE_BLOCK_HPP
#define INSONIFY_EXAMPLES_ANATOMY_NERVE_BLOCK_HPP

#include "../nerve_block_phantom.hpp"
#include "region.hpp"
#include <vector>

namespace anatomy {

/// The phantom of a nerve block, always the same, without its needle, which is a path of its view.
inline body make_nerve_block() {
    body made{.anatomy = nerve_block_phantom()};
    const object_id needle = *made.anatomy.find("needle");
    const pose tip = made.anatomy[needle].at;
    made.anatomy.remove(needle);
    // Along the needle, z of its pose, back from the tip to the skin.
    const vec3 target = tip.translation, back = -tip.direction({0, 0, 1});
    const vec3 entry = target + (nerve_block::skin_top(target.x, target.y) - target.z) / back.z * back;
    made.views = {{.name = "nerve_block",
                   .title = "nerve beside an artery and a vein, above bone, across",
                   .probe = nerve_block::probe,
                   .settings = nerve_block::settings,
                   .needle = needle_path{entry, target},
                   .pressed = 0}};
    const auto line = [](const nerve_block::cord& lumen) {
        std::vector<tube_section> sections;
        for (int i = -12; i <= 12; ++i) {
            const float y = nerve_block::half_length * static_cast<float>(i) / 12;
            const vec2 centre = lumen.centre_at(y);
            sections.push_back({{centre.x, y, centre.y}, lumen.radii});
        }
        return sections_of(places_of(sections, {1, 0, 0}));
    };
    made.vessels = {
        {.name = "artery", .type = vessel::kind::artery, .line = line(nerve_block::artery), .peak_velocity = 0.6F},
        {.name = "vein", .type = vessel::kind::vein, .line = line(nerve_block::vein), .peak_velocity = -0.12F}};
    return made;
}

} // namespace anatomy

#endif
