#include <insonify/acoustics/physical.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/compound.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace compound_test {
namespace {

const acquisition scan{.depth = 40_mm, .samples = 400};

// Looks on which each sample has the value of a function of its point in the slice plane.
template <class Probe, class Value>
scan_lines compounded(compounding<Probe>& looks, const Probe& probe, const compound_settings& settings,
                      const Value& value) {
    return looks(exec::seq, probe, scan, settings,
                 [&](std::uint32_t number, const steered<Probe>& look, const acquisition& of, scan_lines lines) {
                     lines.reshape(look.lines, of.samples, of.depth);
                     for (std::uint32_t i = 0; i < lines.count; ++i)
                         for (std::uint32_t k = 0; k < lines.samples; ++k) {
                             const float depth =
                                 (static_cast<float>(k) + 0.5F) * of.depth / static_cast<float>(of.samples);
                             lines(i, k) = value(number, look.beam(static_cast<float>(i)).at(depth));
                         }
                     return lines;
                 });
}

template <class Probe>
void check_places(const Probe& probe) {
    const auto field = [](std::uint32_t, vec3 p) { return 1 + 20 * p.x + 30 * p.z; }; // linear, as interpolation is
    compounding<Probe> looks;
    for (const std::uint32_t angles : {2U, 5U}) {
        const scan_lines found = compounded(looks, probe, {.angles = angles, .spread = 24_deg}, field);
        REQUIRE(found.count == probe.lines);
        REQUIRE(found.samples == scan.samples);
        double worst = 0;
        for (std::uint32_t i = 0; i < found.count; ++i)
            for (std::uint32_t k = 0; k < found.samples; ++k) {
                const vec3 p = probe.beam(static_cast<float>(i)).at((static_cast<float>(k) + 0.5F) * 0.1_mm);
                worst = std::max(worst, std::fabs(static_cast<double>(found(i, k) - field(0, p))));
            }
        MESSAGE(angles, " looks: ", worst / 30 * 1e6, " um off");
        CHECK(worst / 30 < 50e-6); // half a line and half a sample beyond the ends are not interpolated
    }
}

} // namespace

TEST_CASE("compounding: looks are averaged point by point, up to the sides, and no level changes there") {
    check_places(linear_array{.lines = 128});
    check_places(convex_array{.lines = 160});
    check_places(phased_array{.lines = 128});
}

TEST_CASE("compounding: where a look ends inside the image there is no step") {
    const linear_array probe{.lines = 256, .width = 38_mm};
    compounding<linear_array> looks;
    // One look is twice as bright as the others.
    const scan_lines found = compounded(looks, probe, {.angles = 3, .spread = 20_deg},
                                        [](std::uint32_t number, vec3) { return number == 2 ? 2.0F : 1.0F; });
    float steepest = 0, smallest = 2, largest = 1;
    for (std::uint32_t k = 0; k < found.samples; ++k)
        for (std::uint32_t i = 1; i < found.count; ++i) {
            if (k > 20) steepest = max(steepest, std::fabs(found(i, k) - found(i - 1, k)));
            smallest = min(smallest, found(i, k));
            largest = max(largest, found(i, k));
        }
    MESSAGE("steepest ", steepest, " a line, from ", smallest, " to ", largest);
    CHECK(steepest < 0.04F); // a cut would be 1/3 to 1/2
    CHECK(smallest == doctest::Approx(1).scale(1e-30));
    CHECK(largest < 1.67F);
}

TEST_CASE("compounding: one look at a time ends in the same average as all at once, bit by bit") {
    const linear_array probe{.lines = 64};
    const auto value = [](std::uint32_t number, vec3 p) { return 1 + 0.1F * static_cast<float>(number) + 7 * p.x; };
    for (const std::uint32_t angles : {1U, 2U, 5U, 8U}) {
        compounding<linear_array> full, rolling;
        const compound_settings all{.angles = angles},
            one{.angles = angles, .update = compound_settings::update_mode::one};
        const scan_lines expected = compounded(full, probe, all, value);
        std::vector<std::uint32_t> order;
        const auto next = [&] {
            return compounded(rolling, probe, one, [&](std::uint32_t number, vec3 p) {
                if (order.empty() || order.back() != number) order.push_back(number);
                return value(number, p);
            });
        };
        for (std::uint32_t i = 1; i < angles; ++i) CHECK(next() != expected);
        for (std::uint32_t i = 0; i < 3; ++i) CHECK(next() == expected);
        if (angles == 5) CHECK(order == std::vector<std::uint32_t>{2, 3, 1, 4, 0, 2, 3});
    }
}

TEST_CASE("compounding: each new look replaces the oldest; another probe, depth or number of looks starts anew") {
    linear_array probe{.lines = 64};
    compounding<linear_array> looks;
    compound_settings settings{.angles = 3, .update = compound_settings::update_mode::one};
    std::uint32_t looks_traced = 0;
    const auto next = [&](float level) {
        ++looks_traced;
        return compounded(looks, probe, settings, [&](std::uint32_t, vec3) { return level; })(32, 100);
    };
    CHECK(next(3) == doctest::Approx(3).scale(1e-30));
    CHECK(next(6) == doctest::Approx(4.5).scale(1e-30));
    CHECK(next(9) == doctest::Approx(6).scale(1e-30));
    CHECK(next(12) == doctest::Approx(9).scale(1e-30)); // 6, 9, 12
    settings.spread = 10_deg;
    CHECK(next(1) == doctest::Approx(1).scale(1e-30));
    CHECK(next(2) == doctest::Approx(1.5).scale(1e-30));
    settings.angles = 5;
    CHECK(next(4) == doctest::Approx(4).scale(1e-30));
    probe.width = 30_mm;
    CHECK(next(5) == doctest::Approx(5).scale(1e-30));
    looks.reset();
    CHECK(next(7) == doctest::Approx(7).scale(1e-30));
    CHECK(looks_traced == 9);
}

TEST_CASE("compounding: settings out of range are refused") {
    linear_array probe{.lines = 64};
    compounding<linear_array> looks;
    const auto draw = [&](const compound_settings& settings) {
        return compounded(looks, probe, settings, [](std::uint32_t, vec3) { return 1.0F; });
    };
    CHECK_THROWS_WITH_AS(draw({.angles = 40}), "compound: `angles` is 40; it must be 1 to 31 looks", usage_error);
    CHECK_THROWS_AS(draw({.angles = 0}), usage_error);
    CHECK_THROWS_WITH_AS(draw({.angles = 5, .spread = 20}), "compound: spread is 20 rad: did you mean 20_deg?",
                         usage_error);
    CHECK_THROWS_AS(draw({.angles = 5, .spread = -0.1F}), usage_error);
    CHECK(draw({}).samples == scan.samples); // works after errors
    compounding<radial_array> circle;
    CHECK_THROWS_AS(compounded(circle, radial_array{}, {.angles = 3}, [](std::uint32_t, vec3) { return 1.0F; }),
                    usage_error);
}

} // namespace compound_test
