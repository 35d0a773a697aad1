#include <insonify/acoustics/scatterers/cell_field.hpp>
#include <insonify/core/units.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace rest_curve_test {
namespace {

/// Tissue that has sunk, most at a depth of 30 mm: nodes every millimetre, down to 100 mm.
struct sunk_tissue {
    std::vector<float> nodes{};
    displacement_view displacement{};

    sunk_tissue() {
        for (int z = 0; z <= 100; ++z)
            for (int i = 0; i < 4; ++i) {
                const float from_middle = (static_cast<float>(z) - 30) / 15;
                const float numbers[] = {0, 0, -2_mm * std::exp(-0.5F * from_middle * from_middle), 0};
                nodes.insert(nodes.end(), numbers, numbers + 4);
            }
        displacement = {.nodes = nodes, .size = {2, 2, 101}, .per_spacing = vec3{1 / 1_mm}, .straight_length = 2_mm};
    }
};

} // namespace
} // namespace rest_curve_test

TEST_CASE("straight pieces of a line in tissue at rest stay within their tolerance, and are long where they can be") {
    using namespace rest_curve_test;
    const sunk_tissue tissue;
    const material_line line{.displacement = &tissue.displacement};
    for (const float tolerance : {4_um, 60_um}) {
        const detail::rest_curve curve{line, 1_mm, 52.5_mm, nullptr};
        CHECK(curve.distance(curve.last()) == 52.5_mm);
        double worst = 0;
        int pieces = 0;
        for (std::uint32_t from = 0; from < curve.last(); ++pieces) {
            const std::uint32_t to = curve.straight_until(from, curve.last(), tolerance);
            REQUIRE(to > from);
            for (std::uint32_t i = from; i <= to; ++i) {
                const float distance = curve.distance(i);
                const vec3 straight = curve.point(from) + (distance - curve.distance(from)) * curve.along(from, to);
                const vec3 aside = straight - tissue.displacement.rest(line.at(distance));
                worst = std::fmax(worst, static_cast<double>(length(aside)));
            }
            from = to;
        }
        // A piece of length L that bends by k leaves its chord by k L^2 / 8, k at most 2 mm / (15 mm)^2.
        const int expected = static_cast<int>(51.5_mm / std::sqrt(8 * tolerance / (2_mm / (15_mm * 15_mm))));
        MESSAGE("within ", 1e6F * tolerance, " um: ", pieces, " pieces, if all were the shortest ", expected,
                "; off by at most ", 1e6 * worst, " um");
        CHECK(worst <= static_cast<double>(tolerance));
        CHECK(pieces <= expected + 2); // lengths are multiples of 2 mm
    }
}

TEST_CASE("a curve of a long line ends before it, one of a short line is one piece") {
    using namespace rest_curve_test;
    const sunk_tissue tissue;
    const material_line line{.displacement = &tissue.displacement};
    const detail::rest_curve all{line, 0, 100_mm, nullptr}, end{line, 64_mm, 66.9_mm, nullptr},
        scrap{line, 10_mm, 10.01_mm, nullptr};
    CHECK(all.last() == 32);
    CHECK(all.distance(32) == doctest::Approx(64_mm).scale(1e-30));
    CHECK(end.last() == 1);
    CHECK(end.distance(1) == 66.9_mm);
    CHECK(scrap.last() == 1);
    CHECK(scrap.distance(1) == 10.01_mm);
}
