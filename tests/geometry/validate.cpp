#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/geometry/validate.hpp>
#include "meshes.hpp"
#include <array>
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;
using namespace mesh_test;

namespace validate_test {
namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

bool says(const mesh_report& report, const char* part) { return explain(report).find(part) != std::string::npos; }

} // namespace

TEST_CASE("closed shapes are reported without defects and with their volume") {
    const mesh_report box = validate(make_box({-1, -2, 3}, {1, 2, 6}, 3));
    CHECK(box == mesh_report{.vertices = 386, .faces = 768, .components = 1, .volume = box.volume});
    CHECK(box.volume == doctest::Approx(24).scale(1e-30).epsilon(1e-12));
    CHECK(box.closed());
    CHECK(explain(box).empty());

    const mesh_report cylinder = validate(make_cylinder({0, 0, 0}, {0, 0, 40_mm}, 0.5_mm, 24));
    CHECK(cylinder.closed());
    const double polygon = 12 * std::sin(2 * 3.14159265358979323846 / 24) * 0.25e-6;
    CHECK(cylinder.volume == doctest::Approx(polygon * 0.04).scale(1e-30).epsilon(1e-6));

    const mesh_report sphere = validate(make_sphere({0, 0, 30}, 10_mm, 6)); // far out: rounding moves the vertices
    CHECK(sphere.closed());
    CHECK(sphere.volume == doctest::Approx(4.0 / 3 * 3.14159265358979323846 * 1e-6).scale(1e-30).epsilon(1e-2));
}

TEST_CASE("a missing face leaves three boundary edges") {
    mesh open = make_sphere({0, 0, 0}, 1_mm, 2);
    open.faces.pop_back();
    const mesh_report report = validate(open);
    CHECK(report.boundary_edges == 3);
    CHECK(report.non_manifold_edges == 0);
    CHECK(report.components == 1);
    CHECK(!report.closed());
    CHECK(explain(report) ==
          "The surface is open along 3 edges: fill the hole in a mesh editor, or the medium leaks out.");
}

TEST_CASE("vertices repeated for every face do not open a mesh") {
    const mesh soup = unwelded(make_sphere({0, 0, 0}, 1_mm, 3));
    const mesh_report report = validate(soup);
    CHECK(report.vertices == 3 * 1280);
    CHECK(report.closed());
    CHECK(report.components == 1);
}

TEST_CASE("zero and minus zero are the same position, the next float is another") {
    const mesh signed_zero = {{{0.0F, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-0.0F, -0.0F, 0}},
                              {{4, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    CHECK(validate(signed_zero).closed());
    CHECK(validate(signed_zero).volume == doctest::Approx(1.0 / 6).scale(1e-30));
    mesh apart = signed_zero;
    apart.positions[4].x = std::numeric_limits<float>::min();
    CHECK(validate(apart).boundary_edges == 4);
    CHECK(detail::weld(signed_zero.positions)[4] == detail::weld(signed_zero.positions)[0]);
}

TEST_CASE("a flipped face makes three misoriented edges") {
    mesh m = make_sphere({0, 0, 0}, 1_mm, 2);
    std::swap(m.faces[7].x, m.faces[7].y);
    const mesh_report report = validate(m);
    CHECK(report.misoriented_edges == 3);
    CHECK(report.boundary_edges == 0);
    CHECK(!report.closed());
    CHECK(says(report, "Neighbouring faces have opposite orientations at 3 edges"));
}

TEST_CASE("two boxes that share the vertices of an edge make it non-manifold") {
    mesh m = make_box({0, 0, 0}, {1, 1, 1});
    append(m, make_box({1, 1, 0}, {2, 2, 1}));
    CHECK(m.positions[8] == m.positions[3]); // both ends of the common edge
    CHECK(m.positions[12] == m.positions[7]);
    CHECK(validate(m).closed()); // touching bodies with separate vertices remain separate
    CHECK(validate(m).components == 2);

    for (uvec3& f : m.faces)
        for (int i = 0; i < 3; ++i) f[i] = f[i] == 8 ? 3 : f[i] == 12 ? 7 : f[i];
    const mesh_report report = validate(m);
    CHECK(report.non_manifold_edges == 1);
    CHECK(report.components == 1);
    CHECK(report.volume == doctest::Approx(2).scale(1e-30));
    CHECK(!report.closed());
    CHECK(says(report, "Three faces or more meet at 1 edge:"));
    CHECK(validate(unwelded(m)).non_manifold_edges == 1);
}

TEST_CASE("boxes that share only a corner are two closed components") {
    mesh m = make_box({0, 0, 0}, {1, 1, 1});
    append(m, make_box({1, 1, 1}, {2, 2, 2}));
    CHECK(validate(m).closed());
    CHECK(validate(m).components == 2);
}

TEST_CASE("inside-out components are counted, and a cavity is subtracted from the volume") {
    const mesh flipped = turned_inside_out(make_box({0, 0, 0}, {1, 2, 3}));
    CHECK(validate(flipped).inside_out_components == 1);
    CHECK(validate(flipped).volume == doctest::Approx(-6).scale(1e-30));
    CHECK(validate(flipped).closed());
    CHECK(says(validate(flipped), "The faces point inwards on 1 closed part:"));

    mesh hollow = make_box({0, 0, 0}, {4, 4, 4});
    append(hollow, turned_inside_out(make_box({1, 1, 1}, {2, 2, 2})));
    append(hollow, make_box({10, 0, 0}, {11, 1, 1}));
    const mesh_report report = validate(hollow);
    CHECK(report.components == 3);
    CHECK(report.inside_out_components == 1);
    CHECK(report.volume == doctest::Approx(64 - 1 + 1).scale(1e-30));
}

TEST_CASE("faces without area are counted whether corners coincide or lie on a line") {
    mesh m = make_box({0, 0, 0}, {1, 1, 1});
    m.faces.push_back({0, 0, 1});
    m.positions.push_back(m.positions[0]);
    m.faces.push_back({0, 3, 8}); // another index, the same position
    const mesh_report report = validate(m);
    CHECK(report.degenerate_faces == 2);
    CHECK(report.closed()); // they bound nothing
    CHECK(says(report, "The mesh has 2 faces without area"));

    const mesh line{{{0.1F, 0.1F, 0.1F}, {0.2F, 0.2F, 0.2F}, {0.3F, 0.3F, 0.3F}, {0, 0, 1}}, {{0, 1, 2}, {0, 1, 3}}};
    CHECK(validate(line).degenerate_faces == 1);
    const mesh sliver{{{0, 0, 0}, {1, 0, 0}, {0, 1e-5F, 0}}, {{0, 1, 2}}};
    CHECK(validate(sliver).degenerate_faces == 0);
}

TEST_CASE("duplicate faces are counted, whatever the order of their corners") {
    mesh m = make_box({0, 0, 0}, {1, 1, 1});
    const uvec3 f = m.faces[0], g = m.faces[5];
    m.faces.insert(m.faces.end(), {f, {f.y, f.z, f.x}, {g.x, g.z, g.y}});
    const mesh_report report = validate(m);
    CHECK(report.duplicate_faces == 3);
    CHECK(report.non_manifold_edges > 0);
    CHECK(says(report, "has 3 duplicate faces"));
}

TEST_CASE("indices out of range and non-finite coordinates are counted and never dereferenced") {
    mesh m = make_box({0, 0, 0}, {1, 1, 1});
    m.faces[0].x = 8;
    m.faces[1].z = ~0U;
    mesh_report report = validate(m);
    CHECK(report.faces_out_of_range == 2);
    CHECK(report.boundary_edges == 4);
    CHECK(!report.closed());
    CHECK(says(report, "Vertex indices are out of range in 2 faces"));

    m = make_box({0, 0, 0}, {1, 1, 1});
    m.positions[2].y = not_a_number;
    m.positions[5] = vec3{std::numeric_limits<float>::infinity()};
    report = validate(m);
    CHECK(report.non_finite_vertices == 2);
    CHECK(!report.closed());
    CHECK(std::isfinite(report.volume));
    CHECK(says(report, "A coordinate is NaN or infinite in 2 vertices"));

    for (vec3& p : m.positions) p = vec3{not_a_number};
    CHECK(validate(m).non_finite_vertices == 8);
    CHECK(std::isfinite(validate(m).volume));

    m = make_box({0, 0, 0}, {1, 1, 1});
    for (vec3& p : m.positions) p *= 3.4e38F;
    CHECK(validate(m).closed());
    CHECK(validate(m).volume == doctest::Approx(std::pow(static_cast<double>(3.4e38F), 3)).scale(1e-30));

    m.positions.clear();
    CHECK(validate(m).faces_out_of_range == 12);
}

TEST_CASE("an empty mesh is a legal input and explains itself") {
    CHECK(validate(mesh{}) == mesh_report{});
    CHECK(explain(validate(mesh{})).find("no faces") != std::string::npos);
    CHECK(validate(mesh{{{0, 0, 0}}, {}}).vertices == 1);
}

TEST_CASE("edge counts of random triangle soups equal those of a std::map") {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        INFO("seed " << seed);
        std::uint64_t next = 0;
        const auto pick = [&](std::uint32_t below) {
            return static_cast<std::uint32_t>(hash_uniform(seed, next++) * static_cast<float>(below));
        };
        mesh m;
        const std::uint32_t vertices = 3 + pick(12);
        for (std::uint32_t i = 0; i < vertices; ++i) // a small lattice, so that positions repeat
            m.positions.push_back(
                {static_cast<float>(pick(3)), static_cast<float>(pick(3)), static_cast<float>(pick(2))});
        for (std::uint32_t i = pick(60); i > 0; --i)
            m.faces.push_back({pick(vertices), pick(vertices), pick(vertices)});

        using point = std::array<float, 3>;
        const auto at = [&](std::uint32_t i) { return point{m.positions[i].x, m.positions[i].y, m.positions[i].z}; };
        std::map<std::set<std::uint32_t>, std::vector<std::pair<point, point>>> by_vertices;
        std::map<std::set<point>, std::vector<std::pair<point, point>>> by_place;
        std::set<std::set<point>> distinct;
        std::uint32_t whole = 0;
        for (const uvec3 f : m.faces) {
            const std::set<point> corners{at(f.x), at(f.y), at(f.z)};
            if (corners.size() < 3) continue;
            ++whole;
            distinct.insert(corners);
            for (int i = 0; i < 3; ++i) by_vertices[{f[i], f[(i + 1) % 3]}].emplace_back(at(f[i]), at(f[(i + 1) % 3]));
        }
        mesh_report expected;
        const auto judge = [&](const std::vector<std::pair<point, point>>& walks) {
            if (walks.size() > 2) ++expected.non_manifold_edges;
            if (walks.size() == 2 && walks[0] == walks[1]) ++expected.misoriented_edges;
        };
        for (const auto& [ends, walks] : by_vertices) {
            judge(walks);
            if (walks.size() == 1) by_place[{walks[0].first, walks[0].second}].push_back(walks[0]);
        }
        for (const auto& [ends, walks] : by_place) {
            judge(walks);
            if (walks.size() == 1) ++expected.boundary_edges;
        }
        const mesh_report found = validate(m);
        CHECK(found.boundary_edges == expected.boundary_edges);
        CHECK(found.misoriented_edges == expected.misoriented_edges);
        CHECK(found.non_manifold_edges == expected.non_manifold_edges);
        CHECK(found.duplicate_faces == whole - distinct.size());
        CHECK(found.degenerate_faces >= m.faces.size() - whole);
    }
}

} // namespace validate_test
