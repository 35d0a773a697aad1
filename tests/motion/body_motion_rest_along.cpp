#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/motion/press.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

namespace rest_along_test {
namespace {

struct dice {
    std::uint64_t seed, drawn = 0;
    float between(float low, float high) { return low + hash_uniform(seed, drawn++) * (high - low); }
    vec3 point(float size) { return {between(-size, size), between(-size, size), between(-size, size)}; }
};

pose random_pose(dice& random) {
    const vec3 from = random.point(10_mm);
    return look_at(from, from + vec3{random.between(-1, 1), random.between(-1, 1), 1}, {1, random.between(-1, 1), 0});
}

// Faces as rough as can be: neighbours differ by up to 0.9 of `decay`.
pressed_face random_face(dice& random) {
    pressed_face face{.at = random_pose(random), .decay = random.between(10_mm, 30_mm)};
    for (auto& row : face.depth)
        for (float& depth : row) depth = random.between(0, 0.9F) * face.decay;
    for (auto& row : face.skin)
        for (float& skin : row) skin = random.between(-2_mm, 2_mm);
    return face;
}

pulsation random_pulse(dice& random) {
    const float radius = random.between(1_mm, 5_mm);
    return {.from = random.point(10_mm),
            .to = random.point(10_mm),
            .radius = radius,
            .amplitude = random.between(-0.6F, 0.9F) * radius,
            .time = random.between(0, 1)};
}

collapse random_collapse(dice& random) {
    return {.from = random.point(10_mm),
            .to = random.point(10_mm),
            .direction = random.point(1),
            .radius = random.between(1_mm, 6_mm),
            .outside = random.between(0, 30_mmHg)};
}

needle_drag random_drag(dice& random) {
    return {.entry = random.point(20_mm), .tip = random.point(20_mm), .drag = random.between(-2_mm, 2_mm)};
}

/// Points at rest, displaced and returned: how far from where they began. A map may compress tissue near a point to `residual`,
/// and spread an error of 0.1 um in its place by one over that.
template <class Make>
void check_inverse(const std::string& name, const Make& make) {
    double worst = 0, reached = 0;
    int lost = 0;
    for (std::uint64_t trial = 0; trial < 300; ++trial) {
        dice random{trial + 1};
        const auto map = make(random);
        for (int i = 0; i < 200; ++i) {
            const vec3 rest = random.point(30_mm), now = map(rest), found = map.rest_of(now);
            vec3 by_newton = now;
            lost += detail::newton_inverse{map}(now, by_newton) ? 0 : 1;
            worst = std::fmax(worst, static_cast<double>(length(found - rest)));
            reached = std::fmax(reached, static_cast<double>(length(map(found) - now)));
        }
    }
    MESSAGE(name, ": off by at most ", 1e6 * reached, " um where it is now, ", 1e6 * worst,
            " um at rest; expected 0.2 and 5 um; Newton's method in space loses ", lost, " of 60,000 points");
    CHECK(reached < 0.2e-6);
    CHECK(worst < 5e-6);
}

} // namespace
} // namespace rest_along_test

TEST_CASE("maps of the library bring their inverse, whatever their settings") {
    using namespace rest_along_test;
    check_inverse("pulsation", random_pulse);
    check_inverse("collapse", random_collapse);
    check_inverse("needle_drag", random_drag);
    check_inverse("pressed_face", random_face);
    check_inverse("breathing", [](dice& random) {
        return breathing{.direction = random.point(1),
                         .amplitude = random.between(-20_mm, 20_mm),
                         .extent = random.between(25_mm, 60_mm),
                         .time = random.between(0, 4)};
    });
    check_inverse("indentation", [](dice& random) {
        return indentation{.at = random_pose(random), .depth = random.between(0, 18_mm)};
    });
}

TEST_CASE("a composition has the inverse of its parts: no point is lost where edges of one meet those of another") {
    using namespace rest_along_test;
    double reached = 0;
    int lost = 0, folded = 0;
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
        dice random{trial + 1};
        const auto map =
            compose(random_pulse(random), random_collapse(random), random_face(random), random_drag(random));
        static_assert(invertible_map<std::remove_const_t<decltype(map)>>);
        for (int i = 0; i < 200; ++i) {
            const vec3 rest = random.point(30_mm), now = map(rest);
            vec3 found = now, by_newton = now;
            CHECK(detail::find_rest(map, now, found));
            reached = std::fmax(reached, static_cast<double>(length(map(found) - now)));
            lost += detail::newton_inverse{map}(now, by_newton) ? 0 : 1;
            folded += determinant(detail::derivative(map, rest, now)) > 0 ? 0 : 1;
        }
    }
    MESSAGE("off by at most ", 1e6 * reached, " um where it is now; expected 2 um; Newton's method in space loses ",
            lost, " of 40,000 points, and forward differences at ", folded, " seem to fold over, across edges");
    CHECK(reached < 2e-6);
}

TEST_CASE("a composition with a map that has no inverse is inverted in space") {
    const auto shear = [](vec3 rest) { return rest + vec3{0.2F * rest.z, 0, 0}; };
    const auto map = compose(shear, needle_drag{});
    static_assert(!invertible_map<std::remove_const_t<decltype(map)>>);
    const vec3 rest{1_mm, 2_mm, 10_mm};
    vec3 found = map(rest);
    CHECK(detail::find_rest(map, map(rest), found));
    CHECK(length(found - rest) < 1e-6F);
}

TEST_CASE("Newton's method along rows: exact, with few points of the map, and tissue that folds over is noticed") {
    int calls = 0;
    const auto sunk_by = [&](float depth) { // folds over where it is more than 20 mm
        return [&calls, depth](vec3 rest) {
            ++calls;
            return rest + vec3{0, 0, depth * std::exp(-rest.x * rest.x / (2 * 15_mm * 15_mm) - rest.z / 20_mm)};
        };
    };
    const auto nodes_of = [&calls](const auto& map, const pose& at) {
        const detail::displacement_lattice where{at, vec3{1_mm}, {40, 2, 40}};
        std::vector<float> nodes(4 * where.count());
        detail::invert_map(exec::seq, map, where, nodes.data());
        double worst = 0;
        std::size_t lost = 0;
        for (std::size_t i = 0; i < where.count(); ++i) {
            const vec3 rest = where.point(i) + at.direction({nodes[4 * i], nodes[4 * i + 1], nodes[4 * i + 2]});
            worst = std::fmax(worst, static_cast<double>(length(map(rest) - where.point(i))));
            lost += nodes[4 * i + 3] != 0 ? 1 : 0;
        }
        calls -= static_cast<int>(where.count()); // those of this check
        return std::pair{worst, lost};
    };
    const vec3 first{0, -20_mm, 5_mm}, across{1, 0, 0}, down{0, 0, 1};
    for (const pose& at : {look_at(first, first + down, across), look_at(first, first + across, down)}) {
        calls = 0;
        const auto [worst, lost] = nodes_of(sunk_by(5_mm), at);
        const double each = calls / 3200.0;
        MESSAGE("off by at most ", 1e6 * worst, " um, expected 0.3; ", each, " points of the map for each, expected 3");
        CHECK(worst < 0.3e-6);
        CHECK(lost == 0);
        CHECK(each < 3);
        CHECK(nodes_of(sunk_by(30_mm), at).second > 0);
    }
}

TEST_CASE("pressed_face: a depth that folds tissue over is an error") {
    pressed_face face;
    face.depth[2][7] = face.decay;
    CHECK_THROWS_WITH_AS(face.check(),
                         "pressed_face: `depth` must be at least 0 and less than `decay` at each point of the grid, or "
                         "than `decay` (1 - `stop`) above what is stiff, `left`, `right` and `skin` finite, "
                         "`elevation` and `recovery` above 0 and finite, and `at` a rigid pose",
                         usage_error);
    face.depth[2][7] = 0.99F * face.decay;
    face.check();
}
