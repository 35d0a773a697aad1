#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include "crossings.hpp"
#include <array>
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;

namespace shapes_test {
namespace {

/// Every edge is traversed once in each direction, no vertex is duplicate or unused, and the surface has genus 0.
bool is_watertight_ball(const mesh& m) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> walked;
    for (const uvec3 f : m.faces) {
        if (f.x >= m.positions.size() || f.y >= m.positions.size() || f.z >= m.positions.size()) return false;
        ++walked[{f.x, f.y}];
        ++walked[{f.y, f.z}];
        ++walked[{f.z, f.x}];
    }
    for (const auto& [edge, times] : walked)
        if (edge.first == edge.second || times != 1 || !walked.contains({edge.second, edge.first})) return false;
    std::map<std::array<float, 3>, int> places;
    for (const vec3 p : m.positions) ++places[{p.x, p.y, p.z}];
    const auto vertices = static_cast<std::int64_t>(m.positions.size());
    const auto faces = static_cast<std::int64_t>(m.faces.size());
    return places.size() == m.positions.size() && vertices - static_cast<std::int64_t>(walked.size()) / 2 + faces == 2;
}

/// Signed volume relative to the first vertex; positive for faces that point outwards.
double volume(const mesh& m) {
    double sum = 0;
    for (const uvec3 f : m.faces) {
        double e[3][3];
        for (int i = 0; i < 3; ++i) {
            e[0][i] = static_cast<double>(m.positions[f.x][i]) - m.positions[0][i];
            e[1][i] = static_cast<double>(m.positions[f.y][i]) - m.positions[0][i];
            e[2][i] = static_cast<double>(m.positions[f.z][i]) - m.positions[0][i];
        }
        sum += e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
               e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    }
    return sum / 6;
}

double length_of(vec3 v) {
    return std::sqrt(static_cast<double>(v.x) * v.x + static_cast<double>(v.y) * v.y + static_cast<double>(v.z) * v.z);
}

template <class Make>
std::string sentence(const Make& make) {
    try {
        make();
    } catch (const geometry_error& e) {
        return e.what();
    }
    return "no error";
}

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();

} // namespace

TEST_CASE("a box is a closed surface of 12 * 4^subdivisions triangles around its volume") {
    for (std::uint32_t s = 0; s < 5; ++s) {
        const mesh box = make_box({-1, -2, 3}, {1, 2, 6}, s);
        CHECK(box.faces.size() == 12U << (2 * s));
        CHECK(is_watertight_ball(box));
        CHECK(volume(box) == doctest::Approx(24).scale(1e-30).epsilon(1e-12));
    }
}

TEST_CASE("the vertices of a subdivided box lie exactly on its six sides") {
    const vec3 lower{-0.1F, 0.3F, 0.7F}, upper{0.2F, 0.45F, 0.93F};
    int off = 0;
    for (const vec3 p : make_box(lower, upper, 4).positions)
        off += p.x != lower.x && p.x != upper.x && p.y != lower.y && p.y != upper.y && p.z != lower.z && p.z != upper.z;
    CHECK(off == 0);
}

TEST_CASE("an icosphere has 20 * 4^subdivisions triangles and all vertices on the sphere") {
    const vec3 centre{0.01F, -0.02F, 0.03F};
    for (std::uint32_t s = 0; s < 6; ++s) {
        const mesh sphere = make_sphere(centre, 10_mm, s);
        CHECK(sphere.faces.size() == 20U << (2 * s));
        CHECK(is_watertight_ball(sphere));
        double worst = 0;
        for (const vec3 p : sphere.positions) worst = std::max(worst, std::abs(length_of(p - centre) - 0.01));
        CHECK(worst < 1e-8);
    }
}

TEST_CASE("the volume of an icosphere grows towards 4/3 pi r^3, the gap shrinking by four each time") {
    const double ideal = 4.0 / 3 * 3.14159265358979323846;
    CHECK(volume(make_sphere({0, 0, 0}, 1, 0)) ==
          doctest::Approx(2.536150).scale(1e-30).epsilon(1e-6)); // icosahedron in a unit sphere
    double gap = ideal - volume(make_sphere({0, 0, 0}, 1, 2));
    for (std::uint32_t s = 3; s < 7; ++s) {
        const double next = ideal - volume(make_sphere({0, 0, 0}, 1, s));
        CHECK(gap / next == doctest::Approx(4).scale(1e-30).epsilon(0.02));
        gap = next;
    }
}

TEST_CASE("an icosphere has its six extreme points as vertices") {
    const mesh sphere = make_sphere({0, 0, 30_mm}, 10_mm, 5);
    int found = 0;
    for (const vec3 p : sphere.positions) found += p == vec3{0, 0, 30_mm - 10_mm} || p == vec3{10_mm, 0, 30_mm};
    CHECK(found == 2);
}

TEST_CASE("a cylinder is a closed prism over a regular polygon, whatever its direction") {
    const vec3 from{0.1F, 0.2F, 0.3F};
    for (const vec3 along : {vec3{0, 0, 1}, vec3{0, 0, -1}, vec3{1, 0, 0}, vec3{0, 1, 0}, vec3{0.6F, -0.64F, 0.48F}})
        for (const std::uint32_t n : {3U, 4U, 24U, 500U}) {
            const mesh cylinder = make_cylinder(from, from + 2.0F * along, 0.5F, n);
            CHECK(cylinder.faces.size() == 4 * n);
            CHECK(is_watertight_ball(cylinder));
            const double polygon = 0.5 * n * std::sin(2 * 3.14159265358979323846 / n) * 0.25;
            CHECK(volume(cylinder) == doctest::Approx(2 * polygon).scale(1e-30).epsilon(1e-5));
        }
}

TEST_CASE("a cylinder has one segment along its axis by default, vertex for vertex") {
    const mesh plain = make_cylinder({1, 2, 3}, {-2, 0.5F, 7}, 0.3F, 24);
    const mesh one = make_cylinder({1, 2, 3}, {-2, 0.5F, 7}, 0.3F, 24, 1);
    CHECK(plain.positions == one.positions);
    CHECK(plain.faces == one.faces);
}

TEST_CASE("a cylinder of 24 segments around and 20 along can be bent into an arc") {
    mesh tube = make_cylinder({0, 0, 0}, {0, 0, 1}, 0.1F, 24, 20);
    CHECK(tube.faces.size() == 2 * 24 * 21);
    CHECK(is_watertight_ball(tube));
    const double polygon = 12 * std::sin(2 * 3.14159265358979323846 / 24) * 0.01; // area of the cross-section
    CHECK(volume(tube) == doctest::Approx(polygon).scale(1e-30).epsilon(1e-5));
    for (vec3& p : tube.positions) { // a quarter of a circle of radius 2 / pi about the y axis through x = -2 / pi
        const float angle = p.z * pi / 2, radius = p.x + 2 / pi;
        p = {radius * std::cos(angle) - 2 / pi, p.y, radius * std::sin(angle)};
    }
    CHECK(is_watertight_ball(tube));
    CHECK(volume(tube) == doctest::Approx(polygon).scale(1e-30).epsilon(2e-3)); // Pappus: a bent tube keeps its volume
    double furthest = 0; // of the vertices, from the surface of the torus
    for (std::size_t i = 2; i < tube.positions.size(); ++i) {
        const vec3 p = tube.positions[i];
        const double from_axis = std::hypot(static_cast<double>(p.x) + 2 / 3.14159265358979, static_cast<double>(p.z));
        const double from_centre = std::hypot(from_axis - 2 / 3.14159265358979, static_cast<double>(p.y));
        furthest = std::max(furthest, std::abs(from_centre - 0.1));
    }
    CHECK(furthest < 1e-6);
}

TEST_CASE("subdividing a mesh keeps its vertices and adds one for each edge") {
    const mesh coarse{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 2, 0}}, {{0, 1, 2}, {1, 3, 2}}};
    const mesh fine = subdivide(coarse);
    REQUIRE(fine.positions.size() == 9); // 4 corners, 5 edges
    CHECK(fine.faces.size() == 8);
    for (std::size_t i = 0; i < 4; ++i) CHECK(fine.positions[i] == coarse.positions[i]);
    CHECK(fine.faces[0].x == 0);
    CHECK(fine.positions[fine.faces[0].y] == vec3{1, 0, 0});
    CHECK(fine.positions[fine.faces[0].z] == vec3{0, 1, 0});
    CHECK(fine.positions[fine.faces[5].z] == vec3{2, 1, 0}); // face 1, second corner, and the midpoint before it
    CHECK(subdivide(mesh{}).faces.empty());
    CHECK(sentence([] {
              subdivide(mesh{{{0, 0, 0}}, {{0, 1, 0}}});
          }).find("subdivide: a face names vertex") != std::string::npos);
}

TEST_CASE("shapes out of range are refused with a sentence") {
    const auto says = [](const std::string& text, const char* part) {
        INFO(text);
        CHECK(text.find(part) != std::string::npos);
    };
    says(sentence([] { make_box({0, 0, 0}, {1, 0, 1}); }), "make_box: the extent from `lower` to `upper` along y");
    says(sentence([] { make_box({0, 0, 0}, {1, 1, -1}); }), "along z must be above 0");
    says(sentence([] { make_box({0, not_a_number, 0}, {1, 1, 1}); }), "make_box: coordinates must be finite");
    says(sentence([] { make_box({0, 0, 0}, {infinite, 1, 1}); }), "make_box: coordinates must be finite");
    says(sentence([] { make_box({-3e38F, 0, 0}, {3e38F, 1, 1}); }), "within 1000 km");
    says(sentence([] { make_box({0, 0, 0}, {1, 1, 1}, 11); }), "make_box: 11 subdivisions are more than 10");
    says(sentence([] { make_box({1, 0, 0}, {1.000001F, 1, 1}, 8); }), "make_box: vertices round to the same point");
    says(sentence([] { make_sphere({0, 0, 0}, 0, 2); }), "make_sphere: the radius must be above 0");
    says(sentence([] { make_sphere({0, 0, 0}, -1, 2); }), "make_sphere: the radius must be above 0");
    says(sentence([] { make_sphere({0, 0, 0}, not_a_number, 2); }), "make_sphere: the radius must be above 0");
    says(sentence([] { make_sphere({0, 0, 0}, 1e30F, 2); }), "at most 1000 km");
    says(sentence([] { make_sphere({0, 0, infinite}, 1, 2); }), "make_sphere: coordinates must be finite");
    says(sentence([] { make_sphere({0, 0, 0}, 1, 11); }), "make_sphere: 11 subdivisions are more than 10");
    says(sentence([] { make_sphere({30, 0, 0}, 1_um, 5); }), "place it with a pose");
    says(sentence([] { make_cylinder({0, 0, 0}, {0, 0, 0}, 1, 8); }), "distance between `from` and `to`");
    says(sentence([] { make_cylinder({0, 0, 0}, {0, 0, 1}, 0, 8); }), "make_cylinder: the radius");
    says(sentence([] {
             make_cylinder({0, 0, 0}, {0, 0, 1}, 1, 2);
         }),
         "`segments` is 2; it must be from 3 to 1,000,000");
    says(sentence([] { make_cylinder({0, 0, 0}, {0, 0, 1}, 1, 4000000000U); }), "`segments` is 4000000000");
    says(sentence([] { make_cylinder({0, 0, 0}, {0, 0, 1}, 1, 8, 0); }), "`segments_along` is 0; it must be from 1");
    says(sentence([] {
             make_cylinder({0, 0, 0}, {0, 0, 1}, 1, 1'000'000, 1'000'000);
         }),
         "at most 2^27 segments in all");
    says(sentence([] {
             make_cylinder({0, 0, 0}, {0, not_a_number, 1}, 1, 8);
         }),
         "make_cylinder: coordinates must be finite");
}

TEST_CASE("a straight tube with round ends has the volume of a cylinder and a ball") {
    for (const vec3 along : {vec3{0, 0, 1}, vec3{0, -1, 0}, vec3{0.6F, -0.64F, 0.48F}}) {
        std::vector<tube_section> line;
        for (int i = 0; i <= 10; ++i)
            line.push_back({vec3{1, 2, 3} + 0.4F * static_cast<float>(i) * along, vec2{0.5F}});
        const double round = 3.14159265358979 * 0.25 * 4, ball = 4 * 3.14159265358979 / 3 * 0.125;
        double gap[2];
        for (const std::uint32_t n : {64U, 128U}) {
            const mesh tube = make_tube(line, {.segments = n});
            CHECK(is_watertight_ball(tube));
            gap[n / 128] = 1 - volume(tube) / (round + ball);
        }
        CHECK(gap[0] < 3e-3);
        CHECK(gap[0] / gap[1] == doctest::Approx(4).scale(1e-30).epsilon(0.02));
        const mesh flat = make_tube(line, {.segments = 64, .ends = tube_settings::end_shape::flat});
        CHECK(is_watertight_ball(flat));
        CHECK(volume(flat) ==
              doctest::Approx(32 * std::sin(3.14159265358979 / 32) * 0.25 * 4).scale(1e-30).epsilon(1e-5));
    }
}

TEST_CASE("a tube along a helix keeps its section, and its ellipses do not twist about the line") {
    std::vector<tube_section> line;
    for (int i = 0; i <= 400; ++i) {
        const float turn = 0.02F * static_cast<float>(i);
        line.push_back({{2 * std::cos(turn), 2 * std::sin(turn), 0.3F * turn}, {0.3F, 0.2F}});
    }
    const mesh tube = make_tube(line, {.segments = 48, .ends = tube_settings::end_shape::flat});
    CHECK(is_watertight_ball(tube));
    const double polygon = 24 * std::sin(2 * 3.14159265358979 / 48) * 0.06;
    CHECK(volume(tube) == doctest::Approx(polygon * 8 * std::sqrt(4.09)).epsilon(1e-3).scale(1e-30)); // Pappus
    // The axis of a ring: its first vertex less the centre. Parallel transport: it changes along the tangent only.
    double sideways = 0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const auto axis = [&](std::size_t ring) { return (tube.positions[2 + ring] - line[ring].centre) / 0.3F; };
        const vec3 tangent = normalize(line[i].centre - line[i - 1].centre);
        const vec3 change = axis(i) - axis(i - 1);
        sideways += length_of(change - dot(change, tangent) * tangent);
    }
    CHECK(sideways < 0.01); // radians over more than a full turn
}

TEST_CASE("a tube tapers, begins where it is told to, and turns with `turn`") {
    const std::vector<tube_section> line{{{0, 0, 0}, {2, 1}}, {{0, 0, 4}, {1, 0.5F}, pi / 2}};
    const mesh tube = make_tube(line, {.segments = 4, .ends = tube_settings::end_shape::flat, .across = {0, 1, 1}});
    CHECK(is_watertight_ball(tube));
    REQUIRE(tube.positions.size() == 10);
    CHECK(length_of(tube.positions[2] - vec3{0, 2, 0}) < 1e-6);
    CHECK(length_of(tube.positions[3] - vec3{-1, 0, 4}) < 1e-6);                       // 90 degrees about z
    CHECK(make_tube(line, {.segments = 10}).faces.size() == 2 * 10 * (2 - 2 + 2 * 2)); // as the guide's table says
    const mesh cone = make_tube({{{0, 0, 0}, vec2{1}}, {{0, 0, 3}, vec2{0.5F}}},
                                {.segments = 400, .ends = tube_settings::end_shape::flat});
    CHECK(volume(cone) == doctest::Approx(3.14159265358979 * (1 + 0.5 + 0.25)).epsilon(1e-3).scale(1e-30));
}

TEST_CASE("a flat sheet has the volume of a plate, a curved one that of a shell, and a border may taper") {
    const auto sheet_on = [](const auto& place, std::uint32_t columns, std::uint32_t rows, const auto& thickness) {
        std::vector<sheet_point> points;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t column = 0; column < columns; ++column) {
                const float u = static_cast<float>(column) / static_cast<float>(columns - 1);
                const float v = static_cast<float>(row) / static_cast<float>(rows - 1);
                points.push_back({place(u, v), thickness(u, v)});
            }
        return make_sheet(points, columns);
    };
    const mesh plate = sheet_on(
        [](float u, float v) {
            return vec3{4 * u, 3 * v, 1};
        },
        9, 5, [](float, float) { return 0.5F; });
    CHECK(is_watertight_ball(plate));
    CHECK(volume(plate) == doctest::Approx(6).scale(1e-30).epsilon(1e-6));
    CHECK(plate.positions[0].z == 1.25F); // columns along x, rows along y: the upper side is at +z
    const mesh shell = sheet_on(
        [](float u, float v) {
            return vec3{2 * std::cos(pi * u), 3 * v, 2 * std::sin(pi * u)};
        },
        200, 5, [](float, float) { return 0.4F; });
    CHECK(is_watertight_ball(shell));
    CHECK(volume(shell) == doctest::Approx(3.14159265358979 * 2 * 3 * 0.4).epsilon(1e-3).scale(1e-30));
    const mesh saddles = sheet_on(
        [](float u, float v) {
            return vec3{u, v, 0.05F * std::sin(20 * u) * std::sin(20 * v)};
        },
        21, 21, [](float, float) { return 1e-3F; });
    CHECK(mesh_test::crossings_of(saddles).faces == 0); // as both sides have the same diagonals
    const mesh wedge = sheet_on(
        [](float u, float v) {
            return vec3{4 * u, 3 * v, 0};
        },
        9, 5, [](float u, float) { return 0.5F * (1 - u) + 1e-4F; });
    CHECK(is_watertight_ball(wedge));
    CHECK(volume(wedge) == doctest::Approx(3.0012).scale(1e-30).epsilon(1e-4));
}

TEST_CASE("tubes and sheets out of range are refused with a sentence") {
    const auto says = [](const std::string& text, const char* part) {
        INFO(text);
        CHECK(text.find(part) != std::string::npos);
    };
    const auto tube = [](const std::vector<tube_section>& line, const tube_settings& settings = {}) {
        return sentence([&] { make_tube(line, settings); });
    };
    const tube_section from{{0, 0, 0}, vec2{1}}, to{{0, 0, 4}, vec2{1}};
    says(tube({}), "make_tube: `line` has 0 points; give from 2");
    says(tube({from}), "`line` has 1 points");
    says(tube({from, from}), "make_tube: the distance between two points must be above 0");
    says(tube({from, {{0, 0, 4}, {0, 1}}}), "make_tube: the first of the `radii` must be above 0");
    says(tube({from, {{0, 0, 4}, {1, -1}}}), "make_tube: the second of the `radii`");
    says(tube({from, {{0, not_a_number, 4}, vec2{1}}}), "make_tube: coordinates must be finite");
    says(tube({from, {{0, 0, 4}, vec2{1}, not_a_number}}), "make_tube: `turn` is not finite");
    says(tube({from, {{0, 0, 4}, vec2{1}, pi}}), "make_tube: `turn` changes by more than a quarter turn at point 1");
    says(tube({from, to}, {.segments = 2}), "`segments` is 2; it must be from 3 to 4096");
    says(tube({from, to}, {.across = {infinite, 0, 0}}), "`across` is not finite");
    says(tube({from, to, from}), "make_tube: the line turns back at point 1");
    says(tube({from, {{0, 0, 0.5F}, vec2{1}}, {{0.5F, 0, 0.6F}, vec2{1}}}), "bends more sharply than the radius");

    const auto sheet = [](const std::vector<sheet_point>& points, std::uint32_t columns) {
        return sentence([&] { make_sheet(points, columns); });
    };
    const std::vector<sheet_point> square{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{1, 1, 0}}};
    says(sheet(square, 2), "no error");
    says(sheet(square, 3), "make_sheet: 4 points in rows of 3; give at least 2 full rows");
    says(sheet(square, 0), "in rows of 0");
    says(sheet({{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{1, 1, 0}, -1}}, 2), "make_sheet: the thickness must be above");
    says(sheet({{{0, 0, 0}}, {{1, 0, 0}}, {{2, 0, 0}}, {{3, 0, 0}}}, 2), "lie on one line");
    std::vector<sheet_point> bent;
    for (int row = 0; row < 3; ++row)
        for (int i = 0; i < 9; ++i) {
            const float turn = 0.3F * static_cast<float>(i);
            bent.push_back({{std::cos(turn), static_cast<float>(row), std::sin(turn)}, 3});
        }
    says(sheet(bent, 9), "make_sheet: the sheet bends more sharply than half its thickness in row 0");
}

} // namespace shapes_test
