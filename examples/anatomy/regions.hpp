#ifndef INSONIFY_EXAMPLES_ANATOMY_REGIONS_HPP
#define INSONIFY_EXAMPLES_ANATOMY_REGIONS_HPP

#include "leg.hpp"
#include "lumbar.hpp"
#include "neck.hpp"
#include "nerve_block.hpp"
#include "region.hpp"
#include "right_upper_quadrant.hpp"
#include <string>
#include <vector>

namespace anatomy {

/// All regions.
inline const std::vector<region>& regions() {
    static const std::vector<region> all{
        region_of<neck>("neck", "Neck, C5 to T1"),
        region_of<leg>("leg", "Leg: thigh and calf"),
        region_of<right_upper_quadrant>("right_upper_quadrant", "Right upper quadrant of the abdomen"),
        region_of<lumbar>("lumbar", "Lumbar spine, L2 to the sacrum"),
        {"nerve_block", "Phantom of a nerve block", {}, [](const values&) { return make_nerve_block(); }},
    };
    return all;
}

/// The region of that name; null where there is none.
inline const region* region_named(const std::string& name) {
    for (const region& one : regions())
        if (one.name == name) return &one;
    return nullptr;
}

/// The names of all regions, for messages.
inline std::string names_of_regions() {
    std::string known;
    for (const region& one : regions()) known += std::string{known.empty() ? "" : ", "} + one.name;
    return known;
}

/// @throws usage_error  where there is no region of that name
inline const region& find_region(const std::string& name) {
    if (const region* found = region_named(name)) return *found;
    throw usage_error{"there is no region '" + name + "'; known are " + names_of_regions()};
}

} // namespace anatomy

#endif
