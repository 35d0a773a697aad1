#include <insonify/acoustics/tissue.hpp>
#include <insonify/tissue/structure_gains.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace structure_gains_test {
namespace {

std::vector<float> gains_at(const detail::structure_gains& of, float first, float spacing, std::uint32_t count) {
    std::vector<float> gain(count + max_simd_width);
    of.compute({first, spacing, count, gain.data()});
    gain.resize(count);
    return gain;
}

} // namespace

TEST_CASE("structure: the gains along a line are those of its points one by one, in every direction") {
    // For one point the only cell is the one that contains it; along a line cells are listed.
    constexpr std::uint32_t count = 250;
    constexpr float spacing = 0.13_mm;
    for (const tissue::named_medium& each : tissue::all) {
        if (each.value.structure.empty()) continue;
        const placed_structure placed{each.value.structure, mat3{1}};
        int different = 0, all = 0;
        for (const vec3 direction : {vec3{1, 0, 0}, vec3{0, 1, 0}, vec3{0, 0, 1}, vec3{0, 0, -1}, vec3{1, 2, -3},
                                     vec3{-3, 1, 0.2F}, vec3{0.01F, 1, 0.02F}, vec3{1, 0.03F, -0.02F}})
            for (std::uint32_t key = 0; key < 20; ++key) {
                const vec3 origin{7.3_mm * static_cast<float>(key), 0.31_mm, -41_mm}, along = normalize(direction);
                const detail::structure_gains of{placed, {origin, along, along, 3, key}};
                const std::vector<float> line = gains_at(of, 1_mm, spacing, count);
                for (std::uint32_t i = 0; i < count; ++i, ++all) {
                    const float alone = gains_at(of, 1_mm + static_cast<float>(i) * spacing, spacing, 1)[0];
                    different += std::fabs(line[i] - alone) > 0.01F * alone ? 1 : 0;
                }
            }
        MESSAGE(std::string{each.name} << ": " << different << " of " << all << " points differ by more than 1 %");
        CHECK(different <= all / 1000); // points on the border of a cell
    }
}

TEST_CASE("structure: a wave of no height changes no gain, though points lie at its nodes") {
    constexpr std::uint32_t count = 250, points_per_node = 20;
    for (const tissue::named_medium& each : tissue::all) {
        structure flat = each.value.structure;
        if (flat.sheets.fill == 0 && flat.septa.fill == 0) continue;
        const float spacing = detail::gain_spacing(flat);
        flat.wave = 0;
        structure waved = flat;
        waved.wave = 1e-15F;
        waved.wave_length = 2 * points_per_node * spacing;
        const placed_structure placed_flat{flat, mat3{1}}, placed_waved{waved, mat3{1}};
        int different = 0;
        for (std::uint32_t key = 0; key < 400; ++key) {
            const auto number = static_cast<float>(key);
            const vec3 along = normalize(vec3{0.1F, 0.2F, 1}), origin{0, 1.7_mm * number, 0.37_mm * number};
            const detail::object_segment segment{origin, along, along, 3, key};
            const float first = 3 * spacing - segment.place(); // of points at whole multiples of their distance
            const std::vector<float> expected = gains_at({placed_flat, segment}, first, spacing, count),
                                     gains = gains_at({placed_waved, segment}, first, spacing, count);
            for (std::uint32_t i = 0; i < count; ++i)
                different += std::fabs(gains[i] - expected[i]) > 0.01F * expected[i] ? 1 : 0;
        }
        CAPTURE(std::string{each.name});
        CHECK(different == 0);
    }
}

TEST_CASE("structure: cells far smaller or larger than the line are no trouble") {
    for (const float size : {1e-6F, 1e-4F, 10.0F}) {
        structure s = tissue::muscle.structure;
        s.sheets.cell = vec3{size};
        s.sheets.thickness = min(0.15e-3F, 0.1F * size);
        s.mottling.size = s.grain.size = vec3{size};
        s.wave_length = size;
        const placed_structure placed{s, mat3{1}};
        const vec3 along = normalize(vec3{1, 2, 3});
        const detail::structure_gains of{placed, {{0.2F, 0.1F, -0.3F}, along, along, 3, 1}};
        std::vector<float> gain(200 + max_simd_width);
        of.compute({0, 0.1_mm, 200, gain.data()});
        for (std::uint32_t i = 0; i < 200; ++i) CHECK((is_finite(gain[i]) && gain[i] >= 0));
    }
}

} // namespace structure_gains_test
