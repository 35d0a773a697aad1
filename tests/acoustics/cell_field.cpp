#include <insonify/acoustics/scatterers/cell_field.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

static_assert(scattering_field<gaussian_field> && scattering_field<poisson_scatterers>);

namespace cell_field_test {
namespace {

struct found {
    std::vector<double> depth;
    std::vector<vec2> amplitude;
};
template <class Field>
found along(const Field& field, const material_line& line, float begin, float end, float spacing = 25_um) {
    found all;
    field.scatter(line, begin, end, spacing, [&](const scatterer_run& run) {
        for (std::uint32_t i = 0; i < run.count; ++i) {
            const double depth = static_cast<double>(run.first) + i * static_cast<double>(run.step);
            const vec2 amplitude{run.real[i], run.imaginary[i]};
            if (!all.depth.empty() && depth - all.depth.back() < 1e-6) { // the second part of a divided slot
                all.amplitude.back() += amplitude;
                continue;
            }
            all.depth.push_back(depth);
            all.amplitude.push_back(amplitude);
        }
    });
    return all;
}

// Mean product of the scatterers of two lines at equal depths, within a quarter of a slot.
double correlation(const found& a, const found& b) {
    double sum = 0;
    for (std::size_t i = 0, k = 0; i < a.depth.size(); ++i) {
        while (k + 1 < b.depth.size() && b.depth[k] < a.depth[i] - 6e-6) ++k;
        if (std::fabs(b.depth[k] - a.depth[i]) < 6e-6) sum += static_cast<double>(dot(a.amplitude[i], b.amplitude[k]));
    }
    return sum / static_cast<double>(a.depth.size());
}

} // namespace
} // namespace cell_field_test

TEST_CASE("cell_field: values have mean 0 and power 1 per slot, and adjacent slots are uncorrelated") {
    double power = 0, real = 0, imaginary = 0, product = 0, cross_terms = 0;
    std::size_t count = 0;
    vec2 before{0, 0};
    for (int line = 0; line < 200; ++line) {
        const auto f = cell_field_test::along(gaussian_field{},
                                              {.origin = {0.37_mm * static_cast<float>(line), 0.1_mm, 0}}, 1_mm, 40_mm);
        for (const vec2 a : f.amplitude) {
            power += static_cast<double>(dot(a, a));
            real += static_cast<double>(a.x);
            imaginary += static_cast<double>(a.y);
            product += static_cast<double>(a.x) * a.y;
            cross_terms += static_cast<double>(dot(a, before));
            before = a;
            ++count;
        }
    }
    const auto n = static_cast<double>(count);
    CHECK(power / n == doctest::Approx(1).epsilon(0.01).scale(1e-30));
    for (const double sum : {real, imaginary, product, cross_terms}) CHECK(std::fabs(sum / n) < 0.01);
}

TEST_CASE("cell_field: the mean correlation of parallel lines is the stated covariance") {
    for (const float apart : {0.05_mm, 0.1_mm, 0.15_mm, 0.2_mm, 0.3_mm, 0.5_mm}) {
        double measured = 0;
        for (int i = 0; i < 300; ++i) {
            const float x = 0.413_mm * static_cast<float>(i);
            const auto a = cell_field_test::along(gaussian_field{}, {.origin = {x, 0, 0}}, 0, 20_mm);
            const auto b = cell_field_test::along(gaussian_field{}, {.origin = {x + apart, 0, 0}}, 0, 20_mm);
            measured += cell_field_test::correlation(a, b) / 300;
        }
        CHECK(std::fabs(measured - static_cast<double>(gaussian_field{}.covariance(apart, 0))) < 0.01);
    }
    CHECK(gaussian_field{}.covariance(0, 0) == 1);
    CHECK(gaussian_field{}.covariance(1_m, 0) == 0);
}

TEST_CASE("cell_field: scatterers do not depend on where the line starts") {
    const auto original = cell_field_test::along(gaussian_field{}, {.origin = {1_mm, 2_mm, 0}}, 10_mm, 11_mm);
    const auto moved = cell_field_test::along(gaussian_field{}, {.origin = {1_mm, 2_mm, 4.013_mm}}, 10_mm - 4.013_mm,
                                              11_mm - 4.013_mm);
    REQUIRE(original.depth.size() == moved.depth.size());
    for (std::size_t i = 1; i + 1 < original.depth.size(); ++i) {
        CHECK(original.depth[i] == doctest::Approx(moved.depth[i] + 4.013e-3).epsilon(1e-6).scale(1e-30));
        CHECK(length(original.amplitude[i] - moved.amplitude[i]) < 2e-3F);
    }
}

TEST_CASE("cell_field: the two parts of a divided slot add up to the slot") {
    const material_line line{.origin = {0.3_mm, 0, 0}};
    const auto whole = cell_field_test::along(gaussian_field{}, line, 1_mm, 2_mm);
    const auto upper = cell_field_test::along(gaussian_field{}, line, 1_mm, 1.51_mm),
               lower = cell_field_test::along(gaussian_field{}, line, 1.51_mm, 2_mm);
    CHECK(upper.amplitude.size() + lower.amplitude.size() == whole.amplitude.size() + 1);
    const vec2 sum = upper.amplitude.back() + lower.amplitude.front();
    CHECK(length(sum - whole.amplitude[upper.amplitude.size() - 1]) < 1e-4F);
}

TEST_CASE("cell_field: different directions, objects, planes or seeds give uncorrelated scatterers") {
    const material_line line{};
    const auto correlation = [&](const gaussian_field& other, const material_line& another) {
        return cell_field_test::correlation(cell_field_test::along(gaussian_field{}, line, 0, 200_mm),
                                            cell_field_test::along(other, another, 0, 200_mm));
    };
    CHECK(correlation({}, line) > 0.95);
    CHECK(std::fabs(correlation({}, {.along = normalize(vec3{0.3F, 0, 1})})) < 0.05);
    CHECK(std::fabs(correlation({}, {.object = 3})) < 0.05);
    CHECK(std::fabs(correlation({}, {.plane = 1})) < 0.05);
    CHECK(std::fabs(correlation({.seed = 2}, line)) < 0.05);
}

TEST_CASE("cell_field: the correlation of a rotated line near the pivot is the stated covariance") {
    // Near the pivot both lines traverse the same cells, unless the rotated one has another layout.
    for (const float turn : {0.2_deg, 1.0_deg, 3.0_deg}) {
        double measured = 0, all = 0;
        for (int i = 0; i < 2000; ++i) {
            const vec3 point{0.713_mm * static_cast<float>(i), 0.3_mm, 50.0113_mm};
            const vec3 straight{0, 0, 1}, turned{std::sin(turn), 0, std::cos(turn)};
            const auto through = [&](vec3 along) {
                return cell_field_test::along(gaussian_field{}, {.origin = point - 1_mm * along, .along = along},
                                              0.9_mm, 1.1_mm);
            };
            measured += cell_field_test::correlation(through(straight), through(turned));
            all += cell_field_test::correlation(through(straight), through(straight));
        }
        const double expected = static_cast<double>(gaussian_field{}.covariance(0, turn));
        MESSAGE("turned by ", (turn * 180 / pi), " degrees: ", (measured / all), " correlated, expected ", expected);
        CHECK(std::fabs(measured / all - expected) < 0.06);
    }
}

TEST_CASE("cell_field: lines one above the other are correlated by linear interpolation over their height") {
    for (const float height : {0.0F, 0.5_mm, 1.1_mm})
        for (const float apart : {0.1_mm, 0.3_mm, 0.6_mm}) {
            double measured = 0;
            for (int i = 0; i < 300; ++i) {
                const auto place = static_cast<float>(i);
                const material_line line{.origin = {0.771_mm * place, 1.413_mm * place, 0}, .height = height};
                material_line above = line;
                above.origin.y += apart;
                measured += cell_field_test::correlation(cell_field_test::along(gaussian_field{}, line, 0, 20_mm),
                                                         cell_field_test::along(gaussian_field{}, above, 0, 20_mm)) /
                            300;
            }
            const auto expected = static_cast<double>(
                gaussian_field{.cell = height > 0 ? height : gaussian_field{}.cell}.value_covariance(apart, 0));
            CHECK(std::fabs(measured - expected) < 0.015);
        }
}

TEST_CASE("cell_field: the roll of the line decorrelates scatterers gradually, and half a turn does not") {
    const auto rolled = [](float angle) {
        double sum = 0;
        for (int i = 0; i < 200; ++i) { // on the axis: elsewhere a rolled line meets other cells
            const vec3 axis{0.613_mm * static_cast<float>(i), 0.3_mm, 0};
            const auto seen = [&](float turn) {
                return cell_field_test::along(
                    gaussian_field{},
                    {.origin = axis, .elevation = {std::sin(turn), std::cos(turn), 0}, .height = 0.8_mm}, 0, 20_mm);
            };
            sum += cell_field_test::correlation(seen(0), seen(angle)) / 200;
        }
        return sum;
    };
    const double little = rolled(0.5_deg), more = rolled(3_deg), half_a_turn = rolled(180_deg);
    MESSAGE("correlation of lines rolled by 0.5 and 3 degrees: ", little, ", ", more, "; by 180: ", half_a_turn);
    CHECK(little > 0.85);
    CHECK(more < little);
    CHECK(more > 0.4);
    CHECK(half_a_turn > 0.99);
    const auto at_45_degrees = [](float beyond) {
        const float turn = 45_deg + beyond;
        return cell_field_test::along(gaussian_field{},
                                      {.elevation = {-std::sin(turn), std::cos(turn), 0}, .height = 0.8_mm}, 0, 200_mm);
    };
    CHECK(cell_field_test::correlation(at_45_degrees(-1e-4F), at_45_degrees(1e-4F)) > 0.9);
    CHECK(std::fabs(rolled(40_deg)) < 0.05);
}

TEST_CASE("cell_field: oblique lines have power 1 per slot, too, and a bounded slope") {
    for (const vec3 along : {normalize(vec3{0.06F, 0, 1}), normalize(vec3{0.3F, -0.2F, 1}), vec3{0, 0.8F, -0.6F}}) {
        double power = 0, slots = 0;
        const vec3 lateral = normalize(cross(vec3{0.2F, 1, 0}, along)), elevation = cross(along, lateral);
        for (int i = 0; i < 300; ++i) {
            const material_line line{
                .origin = {0.37_mm * static_cast<float>(i), 0, 0}, .along = along, .elevation = elevation};
            gaussian_field{}.scatter(line, 0, 30_mm, 25_um, [&](const scatterer_run& run) {
                for (std::uint32_t k = 0; k < run.count; ++k)
                    power += static_cast<double>(run.real[k] * run.real[k] + run.imaginary[k] * run.imaginary[k]);
                CHECK(std::fabs(run.slope.x) < 0.18F); // at most the angle between neighbouring lattice directions
                CHECK(std::fabs(run.slope.y) < 0.18F);
            });
            slots += 30e-3 / 25e-6;
        }
        CHECK(power / slots == doctest::Approx(1).epsilon(0.015).scale(1e-30));
    }
}

TEST_CASE("cell_field: the medium's scatterer density overrides that of the field") {
    const auto fourth_moment = [](float of_medium, float of_field) { // large for sparse scatterers
        double second = 0, fourth = 0, n = 0;
        for (int i = 0; i < 200; ++i) {
            const material_line line{.origin = {0.41_mm * static_cast<float>(i), 0, 0}, .scatterer_density = of_medium};
            const auto f = cell_field_test::along(poisson_scatterers{.numbers = {.density = of_field}}, line, 0, 20_mm);
            for (const vec2 a : f.amplitude) {
                const auto p = static_cast<double>(dot(a, a));
                second += p, fourth += p * p, n += 1;
            }
        }
        return fourth * n / (second * second);
    };
    const double sparse = fourth_moment(20e9F, 2000e9F), dense = fourth_moment(0, 2000e9F);
    CHECK(sparse == doctest::Approx(fourth_moment(0, 20e9F)).epsilon(1e-6).scale(1e-30));
    CHECK(sparse > 4 * dense);
}

TEST_CASE("cell_field: scatterers move with the tissue") {
    // Tissue compressed to half its depth: slots at half the spacing, with the amplitudes of the undeformed line.
    std::vector<float> nodes;
    for (const float z : {0_mm, 20_mm})
        for (int corner = 0; corner < 4; ++corner) nodes.insert(nodes.end(), {0, 0, z, 0}); // was at 2 z
    const displacement_view displacement{
        .nodes = nodes, .per_spacing = vec3{50}, .at = {.translation = {-10_mm, -10_mm, 0}}};
    const material_line line{};
    const auto rest = cell_field_test::along(gaussian_field{}, line, 20_mm, 21_mm);
    const auto after = cell_field_test::along(gaussian_field{}, {.displacement = &displacement}, 10_mm, 10.6_mm);
    REQUIRE(after.depth.size() >= rest.depth.size());
    int matched = 0;
    for (std::size_t i = 1; i + 1 < rest.depth.size(); ++i)
        for (std::size_t k = 0; k < after.depth.size(); ++k)
            if (std::fabs(2 * after.depth[k] - rest.depth[i]) < 1e-6 &&
                length(after.amplitude[k] - rest.amplitude[i]) < 1e-3F)
                ++matched;
    CHECK(matched >= static_cast<int>(rest.depth.size()) - 4);
}

TEST_CASE("cell_field: values are finite at any distance from the origin") {
    const vec3 along = normalize(vec3{0.6F, -0.3F, 0.8F});
    for (const float away : {1e3F, 1e5F, 1e8F, 1e16F, 1e22F, FLT_MAX})
        for (const vec3 origin : {vec3{away, 0, 0}, vec3{0, -away, 0}, vec3{away, away, -away}}) {
            const material_line line{.origin = origin, .along = along};
            const auto f = cell_field_test::along(gaussian_field{}, line, 1_mm, 5_mm);
            CHECK(f.amplitude.size() >= 100);
            for (const vec2 a : f.amplitude) REQUIRE((is_finite(a.x) && is_finite(a.y)));
            for (const float spacing : {25_um, 1e-15F, 1e-27F}) { // as in media of almost no sound speed
                const gaussian_field field{};
                const vec2 one = gaussian_field::surface_values{field, line, 2_mm, spacing}(2_mm);
                CHECK((is_finite(one.x) && is_finite(one.y)));
                const auto few = cell_field_test::along(gaussian_field{}, line, 0, 100 * spacing, spacing);
                for (const vec2 a : few.amplitude) REQUIRE((is_finite(a.x) && is_finite(a.y)));
            }
        }
}
