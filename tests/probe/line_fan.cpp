#include <insonify/core/random.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/line_fan.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <doctest/doctest.h>
#include <glm/glm.hpp>

using namespace insonify;

namespace line_fan_test {
namespace {

// A sector with any first and last angle, up to a full circle.
struct turned_sector {
    std::uint32_t lines = 40;
    float frequency = 5_MHz;
    float from = 0, to = 2 * pi, radius = 3_mm;
    vec2 apex{0, 0};
    bool backwards = false;
    ray beam(float line) const {
        const float angle = from + (to - from) * (line + 0.5F) / static_cast<float>(lines);
        const vec3 along{std::sin(angle), 0, std::cos(angle)};
        return {.origin = vec3{apex.x, 0, apex.y} + radius * along, .direction = backwards ? -along : along};
    }
    vec2 locate(vec2) const { return {0, 0}; }
    void check() const {}
};

// Whether the half line from the apex along a line (for parallel lines the whole line) crosses the segment from p to q.
bool crosses(const detail::line_fan& fan, std::size_t i, vec2 p, vec2 q) {
    const glm::dvec2 from{p}, way = glm::dvec2{q} - from;
    const glm::dvec2 along{fan[i].along}, origin = fan.parallel() ? glm::dvec2{fan[i].origin} : glm::dvec2{0, 0};
    const auto cross = [](glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; };
    const double fraction = cross(origin - from, along) / cross(way, along);
    const double down = glm::dot(from + fraction * way - origin, along);
    return fraction >= 0 && fraction <= 1 && (fan.parallel() || down >= 0);
}

} // namespace
} // namespace line_fan_test

TEST_CASE("a segment crosses the same lines as in double precision, with every probe") {
    using namespace line_fan_test;
    std::size_t compared = 0, different = 0, crossed = 0;
    const auto check = [&](const auto& probe) {
        detail::line_fan fan;
        REQUIRE(fan.assign(probe));
        REQUIRE(fan.size() == probe.lines);
        for (std::uint64_t i = 0; i < 3000; ++i) {
            const auto at = [&](std::uint64_t k) { return 60_mm * hash_uniform(probe.lines, 4 * i + k) - 30_mm; };
            const vec2 p{at(0), at(1)}, q = i % 2 == 0 ? vec2{at(2), at(3)} : p + 0.1F * vec2{at(2), at(3)};
            std::vector<int> met(probe.lines);
            fan.for_each_crossed(p, fan.gap(p), q, fan.gap(q), [&](std::uint32_t first, std::uint32_t last) {
                REQUIRE(first < last);
                REQUIRE(last <= probe.lines);
                for (std::uint32_t line = first; line < last; ++line) ++met[line];
            });
            for (std::uint32_t line = 0; line < probe.lines; ++line) {
                REQUIRE(met[line] <= 1);
                ++compared;
                crossed += met[line] == 1;
                different += (met[line] == 1) != crosses(fan, line, p, q);
            }
        }
    };
    check(linear_array{.lines = 37, .width = 30_mm});
    check(linear_array{.lines = 1, .width = 30_mm});
    check(linear_array{.lines = 2, .width = 1_mm});
    check(convex_array{.lines = 41, .radius = 20_mm, .field_of_view = 70_deg});
    check(convex_array{.lines = 64, .radius = 5_mm, .field_of_view = 330_deg});
    check(phased_array{.lines = 33, .field_of_view = 90_deg});
    check(phased_array{.lines = 32, .field_of_view = 179_deg});
    for (const std::uint32_t lines : {3U, 64U, 99U}) check(radial_array{.lines = lines, .radius = 1_mm});
    check(turned_sector{.lines = 45});
    check(turned_sector{.from = 2, .to = 5, .apex = {7_mm, -3_mm}});
    MESSAGE(compared, " lines compared, ", crossed, " crossed, ", different, " differ");
    CHECK(different * 100'000 < compared); // endpoints within rounding of a line
    CHECK(crossed * 20 > compared);
}

TEST_CASE("a closed polygon crosses each line an even number of times, an odd number around the apex") {
    using namespace line_fan_test;
    const auto times = [](const auto& probe, vec2 centre, float size) {
        detail::line_fan fan;
        REQUIRE(fan.assign(probe));
        std::vector<int> met(probe.lines);
        const auto at = [&](int i) {
            const float turn = 2 * pi * static_cast<float>(i % 50) / 50;
            return centre + size * vec2{std::cos(turn), std::sin(turn)};
        };
        for (int i = 0; i < 50; ++i)
            fan.for_each_crossed(at(i), fan.gap(at(i)), at(i + 1), fan.gap(at(i + 1)),
                                 [&](std::uint32_t first, std::uint32_t last) {
                                     for (std::uint32_t line = first; line < last; ++line) ++met[line];
                                 });
        return met;
    };
    for (std::uint64_t i = 0; i < 200; ++i) {
        const vec2 centre{20_mm * hash_uniform(1, 2 * i) - 10_mm, 20_mm * hash_uniform(1, 2 * i + 1) - 10_mm};
        if (std::fabs(length(centre) - 4_mm) < 0.1_mm) continue; // the circle is approximated by a polygon
        for (const int n : times(radial_array{.lines = 64, .radius = 1_mm}, centre, 4_mm))
            CHECK((n % 2 == 1) == (length(centre) < 4_mm));
        for (const int n : times(linear_array{.lines = 64, .width = 20_mm}, centre, 4_mm)) CHECK(n % 2 == 0);
    }
}

TEST_CASE("a segment crosses a line at the same distance as in double precision") {
    const convex_array probe{.lines = 31, .radius = 20_mm, .field_of_view = 80_deg};
    detail::line_fan fan;
    REQUIRE(fan.assign(probe));
    for (std::uint32_t i = 0; i < probe.lines; ++i)
        for (const float depth : {0.0F, 1_mm, 37_mm, 150_mm}) {
            const vec2 on = fan[i].origin + depth * fan[i].along, across{fan[i].along.y, -fan[i].along.x};
            const auto crossing = [&](vec2 p, vec2 q) { // lane 0 is line i
                float distance[simd_width];
                store(fan.from(i).intersect(p, q), distance);
                return distance[0];
            };
            CHECK(crossing(on - 3_mm * across, on + 1_mm * across) == doctest::Approx(depth).scale(2e-3).epsilon(1e-6));
            CHECK(
                std::fabs(crossing(on - 1_mm * across + 2_mm * fan[i].along, on + 3_mm * across - 6_mm * fan[i].along) -
                          depth) < 1e-7F);
        }
}

TEST_CASE("lines that are not a fan are refused") {
    using namespace line_fan_test;
    struct out_of_plane : linear_array {
        ray beam(float line) const {
            return {.origin = linear_array::beam(line).origin, .direction = {0, 0.1F, 0.995F}};
        }
    };
    struct from_right : linear_array {
        ray beam(float line) const { return linear_array::beam(static_cast<float>(lines) - 1 - line); }
    };
    struct no_point : linear_array {
        ray beam(float line) const {
            const float angle = 0.1F * line * line;
            return {.origin = linear_array::beam(line).origin, .direction = {std::sin(angle), 0, std::cos(angle)}};
        }
    };
    CHECK_FALSE(detail::line_fan{}.assign(out_of_plane{}));
    CHECK_FALSE(detail::line_fan{}.assign(from_right{}));
    CHECK_FALSE(detail::line_fan{}.assign(no_point{{.lines = 8}}));
    CHECK_FALSE(detail::line_fan{}.assign(radial_array{.lines = 2}));                  // opposite
    CHECK_FALSE(detail::line_fan{}.assign(turned_sector{.backwards = true}));          // converging
    CHECK_FALSE(detail::line_fan{}.assign(turned_sector{.lines = 100, .to = 4 * pi})); // twice around
}
