#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/scene.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace layers_test {
namespace {

constexpr ray line{.origin = {0.3_mm, 0.2_mm, 0}};
constexpr line_frame frame{.origin = {0.3_mm, 0.2_mm, 0}};

struct memory {
    std::vector<crossing> crossings = std::vector<crossing>(64);
    std::vector<std::uint32_t> inside;
    std::vector<layer> layers;
    line_crossings found{};

    memory(std::size_t max_inside, std::size_t max_layers) : inside(max_inside), layers(max_layers) {
        found = {.room = view<crossing>{crossings}, .inside = {.ranks = view<std::uint32_t>{inside}}};
    }
    view<const layer> stack(const scene& body, float depth) {
        const scene_view flat = body.view_for_rays(exec::seq);
        REQUIRE(find_crossings(flat, line, depth, found));
        return stack_layers(flat, frame, depth, found, view<layer>{layers});
    }
};

// `count` boxes, one in the other, the outermost from 10 mm to 30 mm; each surface 1 mm from the next.
scene nested_boxes(int count) {
    scene body{medium{}};
    for (int i = 0; i < count; ++i) {
        const float half = 10_mm - 1_mm * static_cast<float>(i);
        body.add(make_box(vec3{0, 0, 20_mm} - vec3{half}, vec3{0, 0, 20_mm} + vec3{half}),
                 medium{.density = 2 + static_cast<float>(i)});
    }
    body.build(exec::seq);
    return body;
}

} // namespace
} // namespace layers_test

TEST_CASE("layers that do not fit are refused as a whole; with exactly enough room they cover the line without gaps") {
    const scene body = layers_test::nested_boxes(4); // 8 surfaces: 9 layers
    for (const std::uint32_t room : {0U, 1U, 8U, 9U, 10U}) {
        layers_test::memory own{8, room};
        const view<const layer> layers = own.stack(body, 50_mm);
        REQUIRE(layers.size() == (room < 9 ? 0U : 9U));
        float end = 0;
        for (const layer& one : layers) {
            CHECK(one.begin == end);
            end = one.end;
        }
        if (room >= 9) {
            CHECK(end == 50_mm);
            for (std::uint32_t i = 0; i < 9; ++i) {
                const std::uint32_t depth = i < 4 ? i : 8 - i; // objects that contain it
                CHECK(layers[i].object == (depth == 0 ? ~0U : depth - 1));
            }
        }
    }
}

TEST_CASE("a line that enters more objects than there is room for makes no layers at all") {
    const scene body = layers_test::nested_boxes(4);
    for (const std::uint32_t room : {0U, 1U, 3U, 4U}) {
        layers_test::memory own{room, 16};
        CHECK(own.stack(body, 50_mm).size() == (room < 4 ? 0U : 9U));
    }
}

TEST_CASE("crossings less than a micrometre apart are applied together, those further apart are not") {
    for (const float gap : {0.0F, 0.5e-6F, 5e-6F}) {
        scene body{medium{.density = 1}};
        body.add(make_box({-5_mm, -5_mm, 5_mm}, {5_mm, 5_mm, 10_mm}), medium{.density = 2});
        body.add(make_box({-5_mm, -5_mm, 10_mm + gap}, {5_mm, 5_mm, 15_mm}), medium{.density = 3});
        body.build(exec::seq);
        layers_test::memory own{8, 16};
        CHECK(own.stack(body, 20_mm).size() == (gap > 1e-6F ? 5U : 4U));
    }
}
