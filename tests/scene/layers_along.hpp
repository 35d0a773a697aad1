#ifndef INSONIFY_TESTS_SCENE_LAYERS_ALONG_HPP
#define INSONIFY_TESTS_SCENE_LAYERS_ALONG_HPP

#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include "crossing_memory.hpp"
#include <doctest/doctest.h>
#include <vector>

/// The layers along a line of a scene, and what is expected of them.
namespace scene_test {

using namespace insonify;

// What lies along a line, as (object, begin) pairs; the background is object ~0.
struct stretch {
    std::uint32_t object;
    float begin;
};

inline std::vector<layer> along(const scene& body, const ray& line, float depth = 0.1F) {
    crossing_memory memory;
    line_crossings found = memory.found();
    const scene_view flat = body.view_for_rays(exec::seq);
    REQUIRE(find_crossings(flat, line, depth, found));
    const view<const layer> layers =
        stack_layers(flat, {.origin = line.origin, .along = line.direction}, depth, found, view<layer>{memory.layers});
    return {layers.begin(), layers.end()};
}

inline void check_layers(const std::vector<layer>& layers, const std::vector<stretch>& expected, float depth = 0.1F,
                         double tolerance = 1e-5) {
    REQUIRE(layers.size() == expected.size());
    for (std::size_t i = 0; i < layers.size(); ++i) {
        CHECK(layers[i].object == expected[i].object);
        CHECK(layers[i].begin == doctest::Approx(expected[i].begin).epsilon(tolerance).scale(1e-30));
        CHECK(layers[i].end == (i + 1 < layers.size() ? layers[i + 1].begin : depth));
    }
}

inline constexpr std::uint32_t outside = ~0U;

inline std::uint32_t id(object_id object) { return static_cast<std::uint32_t>(object); }

inline mesh cube(float from, float to) { return make_box({-20_mm, -20_mm, from}, {20_mm, 20_mm, to}); }

} // namespace scene_test

#endif
