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

TEST_CASE("structure: fibres end on a surface as parabolas, from any side and at any angle of incidence") {
    // A fibre at an angle a to the surface that curves over its last length l is the parabola through its end,
    // x = 2 sqrt(D d) / tan a at the depth d <= D = l / 2 sin a, and from x = l cos a on the straight line on which it would
    // have gone on. All its points have one place across the fibres: c = sin a x' - cos a d', where (x', d') is displaced.
    constexpr double degree = 3.14159265358979 / 180, length = 20e-3;
    for (const double a : {3 * degree, 15 * degree, 60 * degree})
        for (const float cosine : {1.0F, 0.8F, -1.0F, -0.3F}) {
            const double largest = 0.5 * length * std::sin(a), end = 7e-3;
            const detail::fibre_insertion fibre{
                {0, 0, -1}, static_cast<float>(end), cosine, static_cast<float>(largest)};
            for (double x = 0; x < 1.5 * length; x += 0.25e-3) {
                const double beyond = x - length * std::cos(a),
                             depth = beyond < 0 ? largest * std::pow(x / (length * std::cos(a)), 2)
                                                : largest + beyond * std::tan(a);
                const float distance = static_cast<float>(end + depth / static_cast<double>(cosine));
                float aside[detail::wide_lanes];
                store(fibre.displacement(detail::wide_floats(distance)), aside);
                const double across = std::sin(a) * x - std::cos(a) * (depth - static_cast<double>(aside[0]));
                CHECK(std::fabs(across - std::sin(a) * length * std::cos(a) + std::cos(a) * largest) < 2e-6);
            }
        }
}

TEST_CASE("structure: the pieces of a line where fibres curve are chords of their parabolas, and end where fibres do") {
    const detail::fibre_insertion entry{{0, 0, -1}, 2_mm, 0.9F, 1.8_mm}, exit{{0, 0.6F, 0.8F}, 14_mm, -0.7F, 2.5_mm},
        straight{{0, 0, 1}, 14_mm, -1, 0}, none{};
    for (const detail::fibre_insertion& first : {entry, none})
        for (const detail::fibre_insertion& last : {exit, straight, none}) {
            const detail::fibre_course course{first, last};
            const float begin = first.cosine != 0 ? 2_mm : -3_mm, end = last.cosine != 0 ? 14_mm : 21_mm;
            float reached = begin;
            course.for_each_piece(-3_mm, 21_mm, [&](float from, float to, const detail::fibre_course::piece& piece) {
                CHECK(from == reached);
                CHECK(from < to);
                reached = to;
                for (const float x : {from, to}) {
                    float at_entry[detail::wide_lanes], at_exit[detail::wide_lanes];
                    store(first.displacement(detail::wide_floats(x)), at_entry);
                    store(last.displacement(detail::wide_floats(x)), at_exit);
                    const float curved = piece.at_exit != 0 ? at_exit[0] : at_entry[0];
                    CHECK(std::fabs(piece.aside.at(x) - curved) < 2e-6F);
                }
            });
            CHECK(std::fabs(reached - end) < 1e-7F);
        }
    int pieces = 0;
    detail::fibre_course{entry, exit}.for_each_piece(5_mm, 6_mm, [&](float from, float to, const auto& piece) {
        CHECK(from == 5_mm);
        CHECK(to == 6_mm);
        CHECK(piece.stretch == 0);
        ++pieces;
    });
    CHECK(pieces == 1);
}

TEST_CASE("structure: fibres that do not curve have the sheets of straight ones, up to where they end") {
    constexpr std::uint32_t count = 200;
    const placed_structure placed{tissue::muscle.structure, mat3{1}};
    const vec3 along = normalize(vec3{0.2F, 0.1F, 1});
    const detail::object_segment segment{{1_mm, 2_mm, 3_mm}, along, along, 3, 7};
    const std::vector<float> straight = gains_at({placed, segment}, 0, 0.1_mm, count);
    const detail::fibre_insertion end{{0, 0, 1}, 15.05_mm, -1, 0};
    const std::vector<float> ending = gains_at({placed, segment, {{}, end}}, 0, 0.1_mm, count);
    float brightest = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (i <= 150) CHECK(std::fabs(ending[i] - straight[i]) < 1e-3F * straight[i]);
        if (i > 150) CHECK(ending[i] <= 1.001F * straight[i]);
        if (i > 150) brightest = max(brightest, straight[i] / ending[i]);
    }
    CHECK(brightest > 1.5F);
}

} // namespace structure_gains_test
