#include <insonify/acoustics/scattering.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

static_assert(scattering_field<gaussian_field<>> && scattering_field<no_scatterers>);

namespace scattering_test {
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
            all.depth.push_back(static_cast<double>(run.first) + i * static_cast<double>(run.step));
            all.amplitude.push_back(run.amplitude[i]);
        }
    });
    return all;
}

struct stretched {
    vec3 operator()(std::uint32_t, vec3 p) const { return {p.x, p.y, 2 * p.z}; }
};

} // namespace
} // namespace scattering_test

TEST_CASE("the field has power 1 a slot, mean 0, equal parts, and neighbours along the line are independent") {
    double power = 0, real = 0, imaginary = 0, product = 0, cross_terms = 0;
    std::size_t count = 0;
    vec2 before{0, 0};
    for (int line = 0; line < 200; ++line) {
        const auto f = scattering_test::along(gaussian_field<>{},
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
    CHECK(power / n == doctest::Approx(1).epsilon(0.01));
    for (const double sum : {real, imaginary, product, cross_terms}) CHECK(std::fabs(sum / n) < 0.01);
}

TEST_CASE("lines so far apart are as alike as covariance says, averaged over where they stand") {
    for (const float apart : {0.05_mm, 0.1_mm, 0.15_mm, 0.2_mm, 0.3_mm, 0.5_mm}) {
        double together = 0;
        std::size_t count = 0;
        for (int i = 0; i < 300; ++i) {
            const float x = 0.413_mm * static_cast<float>(i);
            const auto a = scattering_test::along(gaussian_field<>{}, {.origin = {x, 0, 0}}, 0, 20_mm);
            const auto b = scattering_test::along(gaussian_field<>{}, {.origin = {x + apart, 0, 0}}, 0, 20_mm);
            for (std::size_t k = 0; k < a.amplitude.size(); ++k)
                together += static_cast<double>(dot(a.amplitude[k], b.amplitude[k]));
            count += a.amplitude.size();
        }
        CHECK(std::fabs(together / static_cast<double>(count) -
                        static_cast<double>(gaussian_field<>{}.covariance(apart))) < 0.01);
    }
    CHECK(gaussian_field<>{}.covariance(0) == 1);
    CHECK(gaussian_field<>{}.covariance(1_m) == 0);
}

TEST_CASE("scatterers stay where they are in the material when the line starts elsewhere") {
    const auto near_by = scattering_test::along(gaussian_field<>{}, {.origin = {1_mm, 2_mm, 0}}, 10_mm, 11_mm);
    const auto moved = scattering_test::along(gaussian_field<>{}, {.origin = {1_mm, 2_mm, 4.013_mm}}, 10_mm - 4.013_mm,
                                              11_mm - 4.013_mm);
    REQUIRE(near_by.depth.size() == moved.depth.size());
    for (std::size_t i = 1; i + 1 < near_by.depth.size(); ++i) {
        CHECK(near_by.depth[i] == doctest::Approx(moved.depth[i] + 4.013e-3).epsilon(1e-6));
        CHECK(length(near_by.amplitude[i] - moved.amplitude[i]) < 2e-3F);
    }
}

TEST_CASE("a cut through a slot divides it: both parts together are the whole") {
    const material_line line{.origin = {0.3_mm, 0, 0}};
    const auto whole = scattering_test::along(gaussian_field<>{}, line, 1_mm, 2_mm);
    const auto upper = scattering_test::along(gaussian_field<>{}, line, 1_mm, 1.51_mm),
               lower = scattering_test::along(gaussian_field<>{}, line, 1.51_mm, 2_mm);
    CHECK(upper.amplitude.size() + lower.amplitude.size() == whole.amplitude.size() + 1);
    const vec2 sum = upper.amplitude.back() + lower.amplitude.front();
    CHECK(length(sum - whole.amplitude[upper.amplitude.size() - 1]) < 1e-4F);
}

TEST_CASE("lines of another direction, object or seed are independent") {
    const auto likeness = [](const gaussian_field<>& f, const material_line& a, const gaussian_field<>& g,
                             const material_line& b) {
        const auto x = scattering_test::along(f, a, 0, 100_mm), y = scattering_test::along(g, b, 0, 100_mm);
        double sum = 0;
        const std::size_t n = std::min(x.amplitude.size(), y.amplitude.size());
        for (std::size_t i = 0; i < n; ++i) sum += static_cast<double>(dot(x.amplitude[i], y.amplitude[i]));
        return std::fabs(sum / static_cast<double>(n));
    };
    const material_line line{};
    const float t = 0.3_deg;
    CHECK(likeness({}, line, {}, line) > 0.95);
    CHECK(likeness({}, line, {}, {.along = {std::sin(t), 0, std::cos(t)}}) < 0.06);
    CHECK(likeness({}, line, {}, {.object = 3}) < 0.06);
    CHECK(likeness({}, line, {.seed = 2}, line) < 0.06);
}

TEST_CASE("a map to the tissue at rest moves its scatterers") {
    // Everything was twice as deep: the slots stand at half their spacing, with the amplitudes of the undeformed line.
    const material_line line{};
    const auto rest = scattering_test::along(gaussian_field<>{}, line, 20_mm, 21_mm);
    const auto pressed = scattering_test::along(gaussian_field<scattering_test::stretched>{}, line, 10_mm, 10.5_mm);
    REQUIRE(pressed.depth.size() >= rest.depth.size());
    int matched = 0;
    for (std::size_t i = 1; i + 1 < rest.depth.size(); ++i)
        for (std::size_t k = 0; k < pressed.depth.size(); ++k)
            if (std::fabs(2 * pressed.depth[k] - rest.depth[i]) < 1e-6 &&
                length(pressed.amplitude[k] - rest.amplitude[i]) < 1e-3F)
                ++matched;
    CHECK(matched >= static_cast<int>(rest.depth.size()) - 4);
}
