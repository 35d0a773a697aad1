#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/implicit.hpp>
#include <insonify/geometry/validate.hpp>
#include "crossings.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <string>

using namespace insonify;

namespace implicit_test {
namespace {

constexpr double turn = 2 * 3.14159265358979323846;

double area_of(const mesh& m) {
    double sum = 0;
    for (const uvec3 f : m.faces) {
        const dvec3 a{m.positions[f.x]}, b{m.positions[f.y]}, c{m.positions[f.z]};
        sum += 0.5 * length(cross(b - a, c - a));
    }
    return sum;
}

float torus(vec3 p) {
    const float from_axis = std::sqrt(p.x * p.x + p.y * p.y) - 8_mm;
    return std::sqrt(from_axis * from_axis + p.z * p.z) - 3_mm;
}

/// A sum of six plane waves in random directions.
struct waves {
    std::uint64_t seed = 0;

    float operator()(vec3 p) const {
        float sum = 0;
        for (std::uint64_t k = 0; k < 6; ++k) {
            const auto number = [&](std::uint64_t i) { return hash_uniform(seed, 4 * k + i); };
            const vec3 direction = 1.2F / 1_mm * (vec3{number(0), number(1), number(2)} - vec3{0.5F});
            sum += std::sin(dot(direction, p) + 6 * number(3));
        }
        return sum * 1_mm;
    }
};

template <class Make>
std::string sentence(const Make& make) {
    try {
        make();
    } catch (const geometry_error& e) {
        return e.what();
    }
    return "no error";
}

} // namespace

TEST_CASE("an implicit sphere is closed, and its volume and area converge with the square of the cell") {
    const vec3 centre{0.1_mm, 0.23_mm, -0.31_mm};
    const double volume = 2 * turn / 3 * 1e-6, area = 2 * turn * 1e-4;
    double volume_error[3], area_error[3], furthest[3];
    for (int i = 0; i < 3; ++i) {
        const float cell = 2_mm / static_cast<float>(1 << i);
        const mesh ball =
            mesh_implicit([&](vec3 p) { return length(p - centre) - 10_mm; }, {vec3{-12_mm}, vec3{13_mm}}, cell);
        const mesh_report report = validate(ball);
        CHECK(report.closed());
        CHECK(report.components == 1);
        CHECK(report.degenerate_faces == 0);
        CHECK(report.inside_out_components == 0);
        volume_error[i] = 1 - report.volume / volume;
        area_error[i] = 1 - area_of(ball) / area;
        furthest[i] = 0;
        for (const vec3& p : ball.positions)
            furthest[i] = std::fmax(furthest[i], static_cast<double>(std::fabs(length(p - centre) - 10_mm)));
        CAPTURE(cell);
        CHECK(furthest[i] < 0.01 * static_cast<double>(cell));
    }
    CHECK(volume_error[0] > 0); // its flat faces lie inside the ball
    CHECK(volume_error[0] < 6e-3);
    for (int i = 0; i < 2; ++i) {
        CHECK(volume_error[i] / volume_error[i + 1] == doctest::Approx(4).scale(1e-30).epsilon(0.05));
        CHECK(area_error[i] / area_error[i + 1] == doctest::Approx(4).scale(1e-30).epsilon(0.05));
    }
}

TEST_CASE("vertices lie on the surface, whatever the slope of the function") {
    const vec3 radii{8_mm, 6_mm, 5_mm}; // of an ellipsoid
    const aabb box{vec3{-12_mm}, vec3{12_mm}};
    for (const float scale : {1e-25F, 1e-3F, 1.0F, 10.0F, 1000.0F, 1e20F}) {
        const mesh ball = mesh_implicit([&](vec3 p) { return scale * (length(p) - 7_mm); }, box, 1_mm);
        const mesh ellipsoid =
            mesh_implicit([&](vec3 p) { return scale * (dot(p / radii, p / radii) - 1); }, box, 0.5_mm);
        float off_ball = 0, off_ellipsoid = 0; // metres
        for (const vec3 p : ball.positions) off_ball = max(off_ball, std::fabs(length(p) - 7_mm));
        for (const vec3 p : ellipsoid.positions)
            off_ellipsoid = max(off_ellipsoid, std::fabs(length(p / radii) - 1) * 5_mm);
        CHECK(off_ball < 2_um);
        CHECK(off_ellipsoid < 5_um);
        CHECK(enclosed_volume(ellipsoid) ==
              doctest::Approx(2 * turn / 3 * 8e-3 * 6e-3 * 5e-3).scale(1e-30).epsilon(0.01));
    }
}

TEST_CASE("beside the box and where it cuts a body off, the surface does not depend on the slope of the function") {
    for (const float scale : {1e-3F, 1.0F, 1000.0F}) {
        const auto ball = [&](vec3 p) { return scale * (length(p) - 8_mm); };
        float off = 0, off_cut = 0; // metres
        for (const vec3 p : mesh_implicit(ball, {vec3{-9_mm}, vec3{9_mm}}, 1_mm).positions)
            off = max(off, std::fabs(length(p) - 8_mm));
        CHECK(off < 0.1_mm);
        const mesh cut = mesh_implicit(ball, {vec3{-9.3_mm}, {9.3_mm, 9.3_mm, 6.1_mm}}, 1_mm);
        CHECK(validate(cut).closed());
        CHECK(validate(cut).degenerate_faces == 0);
        float highest = 0;
        for (const vec3 p : cut.positions) {
            highest = max(highest, p.z);
            if (p.z > 6_mm && length(p) < 7.9_mm) off_cut = max(off_cut, std::fabs(p.z - 6.1_mm));
        }
        CHECK(highest < 6.1_mm + 1_um);
        CHECK(off_cut < 1_um);
    }
}

TEST_CASE("an implicit torus has one handle, and the volume and the area of Pappus") {
    const mesh ring = mesh_implicit(torus, {vec3{-12_mm, -12_mm, -4_mm}, vec3{12_mm, 12_mm, 4_mm}}, 0.5_mm);
    const mesh_report report = validate(ring);
    CHECK(report.closed());
    CHECK(report.volume == doctest::Approx(turn * 8e-3 * turn / 2 * 9e-6).epsilon(4e-3).scale(1e-30));
    CHECK(area_of(ring) == doctest::Approx(turn * 8e-3 * turn * 3e-3).epsilon(2e-3).scale(1e-30));
    // Euler: vertices - edges + faces = 0, with 3/2 edges a face.
    CHECK(2 * ring.positions.size() == ring.faces.size());
}

TEST_CASE("a bound of the slope leaves out calls and changes nothing") {
    const aabb box{vec3{-40_mm}, vec3{40_mm}};
    int calls = 0;
    const auto counted = [&](vec3 p) {
        ++calls;
        return torus(p);
    };
    const mesh all = mesh_implicit(counted, box, 1_mm);
    const int without = calls;
    calls = 0;
    const mesh near_by = mesh_implicit(counted, box, 1_mm, {.max_slope = 1});
    CHECK(all.positions == near_by.positions);
    CHECK(all.faces == near_by.faces);
    CHECK(calls * 8 < without);
}

TEST_CASE("random smooth functions give closed surfaces, also where they end at the box") {
    int open = 0, empty_faces = 0, inside_out = 0, misplaced = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const waves function{seed};
        const float cell = 1_mm + 1_mm * hash_uniform(seed, 99);
        const aabb box{vec3{-10_mm, -8_mm, -9_mm}, vec3{10_mm, 8_mm, 7_mm}};
        const mesh found = mesh_implicit(function, box, cell);
        const mesh_report report = validate(found);
        if (!report.closed()) MESSAGE("seed ", seed, ": ", explain(report));
        open += report.closed() ? 0 : 1;
        empty_faces += report.degenerate_faces > 0 ? 1 : 0;
        // The volume, by sampling.
        double inside = 0, all = 0;
        for (float z = -8.75_mm; z < 7_mm; z += 0.5_mm)
            for (float y = -7.75_mm; y < 8_mm; y += 0.5_mm)
                for (float x = -9.75_mm; x < 10_mm; x += 0.5_mm) {
                    inside += function({x, y, z}) < 0 ? 1 : 0;
                    ++all;
                }
        const double volume = 20e-3 * 16e-3 * 16e-3;
        inside_out += report.volume < 0 ? 1 : 0;
        misplaced += std::fabs(report.volume / volume - inside / all) > 0.02 ? 1 : 0;
    }
    CHECK(open == 0);
    CHECK(empty_faces == 0);
    CHECK(inside_out == 0);
    CHECK(misplaced == 0);
}

TEST_CASE("surfaces through the points of the lattice are closed") {
    for (const float shift : {0.0F, 0.5F, 0.25F, 1.0F}) { // planes and edges that meet the lattice exactly
        const auto cube = [&](vec3 p) {
            const vec3 beyond = abs(p) - vec3{2_mm + shift * 1_mm};
            return std::fmax(beyond.x, std::fmax(beyond.y, beyond.z));
        };
        const mesh_report report = validate(mesh_implicit(cube, {vec3{-4_mm}, vec3{4_mm}}, 1_mm));
        CHECK(report.closed());
        CHECK(report.degenerate_faces == 0);
        const double side = 4e-3 + 2e-3 * static_cast<double>(shift);
        CHECK(report.volume == doctest::Approx(side * side * side).epsilon(0.06).scale(1e-30)); // edges are cut
    }
}

TEST_CASE("a function that is negative everywhere gives the box, one that never is gives nothing") {
    const aabb box{{1_mm, 2_mm, 3_mm}, {11_mm, 7_mm, 7_mm}};
    const mesh full = mesh_implicit([](vec3) { return -1_mm; }, box, 1_mm);
    const mesh_report report = validate(full);
    CHECK(report.closed());
    CHECK(report.volume == doctest::Approx(200e-9).epsilon(0.02).scale(1e-30));
    for (const vec3& p : full.positions) {
        CHECK(box.lower.x - p.x < 0.2_mm);
        CHECK(p.x - box.upper.x < 0.2_mm);
    }
    CHECK(mesh_implicit([](vec3) { return 1_mm; }, box, 1_mm).faces.empty());
    CHECK(mesh_implicit([](vec3) { return 0.0F; }, box, 1_mm).faces.empty());
}

TEST_CASE("what cannot be meshed is refused with a sentence") {
    const auto ball = [](vec3 p) { return length(p) - 1_mm; };
    const auto says = [](const std::string& text, const char* part) {
        INFO(text);
        CHECK(text.find(part) != std::string::npos);
    };
    const aabb box{vec3{-2_mm}, vec3{2_mm}};
    says(sentence([&] { mesh_implicit(ball, box, 0); }), "`cell` is 0; it must be a length above 0");
    says(sentence([&] { mesh_implicit(ball, box, -1_mm); }), "`cell` is -0.001");
    says(sentence([&] { mesh_implicit(ball, box, std::numeric_limits<float>::quiet_NaN()); }), "`cell` is");
    says(sentence([&] { mesh_implicit(ball, box, 1_um); }), "too many cells of 1e-06 m");
    says(sentence([&] { mesh_implicit(ball, aabb{}, 1_mm); }), "the box is empty or not finite");
    says(sentence([&] { mesh_implicit(ball, {vec3{0}, vec3{1_mm, 1_mm, 0}}, 1_mm); }), "the box is empty");
    says(sentence([&] {
             mesh_implicit(ball, {vec3{0}, vec3{std::numeric_limits<float>::infinity()}}, 1_mm);
         }),
         "the box is empty or not finite");
    says(sentence([&] { mesh_implicit(ball, box, 1_mm, {.max_slope = -1}); }), "`max_slope` is -1");
    says(sentence([&] {
             mesh_implicit([](vec3 p) { return p.x > 0 ? std::numeric_limits<float>::quiet_NaN() : 1; }, box, 1_mm);
         }),
         "gives NaN or an infinite value at {");
}

TEST_CASE("faces of an implicit surface do not cross, even where the cells do not resolve it") {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        CAPTURE(seed);
        const aabb box{vec3{-12_mm}, vec3{12_mm}};
        for (const float cell : {1_mm, 2.5_mm})
            CHECK(mesh_test::crossings_of(mesh_implicit(waves{seed}, box, cell)).faces == 0);
        // A thin bent plate with a hole.
        const auto plate = [&](vec3 p) {
            const float bent = p.z - 1_mm * std::sin(p.x / 2_mm + static_cast<float>(seed));
            return std::max({std::fabs(bent) - 0.6_mm, length(p) - 9_mm, 2_mm - length(vec2{p.x, p.y})});
        };
        CHECK(mesh_test::crossings_of(mesh_implicit(plate, box, 2_mm)).faces == 0);
    }
}

} // namespace implicit_test
