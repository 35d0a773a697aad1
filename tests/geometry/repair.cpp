#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/geometry/repair.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/geometry/validate.hpp>
#include "meshes.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <limits>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;
using namespace mesh_test;

namespace repair_test {
namespace {

constexpr double exact_pi = 3.14159265358979323846;

void turn(uvec3& face) { std::swap(face.y, face.z); }

std::string all_notes(const repaired_mesh& one) {
    std::string text;
    for (const std::string& note : one.notes) text += note + '\n';
    return text;
}
bool says(const repaired_mesh& one, const std::string& part) { return all_notes(one).find(part) != std::string::npos; }

/// The result is closed, outwards, without any defect that `validate` knows, and has a volume.
void check_closed(const repaired_mesh& one, double volume, double epsilon = 1e-5) {
    INFO(all_notes(one));
    const mesh_report report = validate(one.surface);
    INFO(explain(report));
    CHECK(report.closed());
    CHECK(report.duplicate_faces == 0);
    CHECK(report.volume == doctest::Approx(volume).scale(1e-30).epsilon(epsilon));
    for (const uvec3 f : one.surface.faces) {
        REQUIRE(std::max({f.x, f.y, f.z}) < one.surface.positions.size());
        CHECK((f.x != f.y && f.y != f.z && f.z != f.x));
    }
}

/// A prism over a polygon of the plane z = 0, which may be concave, without its lid at z = height. The floor is a fan
/// from the origin, which sees all corners.
mesh open_prism(const std::vector<vec2>& polygon, float height) {
    mesh m;
    const auto count = static_cast<std::uint32_t>(polygon.size());
    for (const float z : {0.0F, height})
        for (const vec2 p : polygon) m.positions.emplace_back(p.x, p.y, z);
    m.positions.emplace_back(0, 0, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t next = (i + 1) % count;
        m.faces.insert(m.faces.end(), {{i, next, count + next}, {i, count + next, count + i}, {2 * count, next, i}});
    }
    return m;
}
double area_of(const std::vector<vec2>& polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const vec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        twice += static_cast<double>(a.x) * b.y - static_cast<double>(a.y) * b.x;
    }
    return twice / 2;
}
/// Corners at radii that alternate.
std::vector<vec2> star(std::uint32_t corners, double outer, double inner) {
    std::vector<vec2> polygon;
    for (std::uint32_t i = 0; i < corners; ++i) {
        const double angle = 2 * exact_pi * i / corners, radius = i % 2 == 0 ? outer : inner;
        polygon.emplace_back(static_cast<float>(radius * std::cos(angle)),
                             static_cast<float>(radius * std::sin(angle)));
    }
    return polygon;
}
/// Area of the faces in the plane z = height.
double lid_area(const mesh& m, float height, bool& all_upwards) {
    double area = 0;
    all_upwards = true;
    for (std::size_t i = 0; i < m.faces.size(); ++i) {
        const triangle t = mesh_view{m}[i];
        if (t.a.z != height || t.b.z != height || t.c.z != height) continue;
        area += static_cast<double>(length(area_vector(t))) / 2;
        all_upwards = all_upwards && area_vector(t).z >= 0;
    }
    return area;
}

} // namespace

TEST_CASE("a mesh without defects stays as it is, and nothing is said") {
    for (const mesh& m :
         std::vector<mesh>{make_sphere({1, 2, 3}, 1, 3), make_box({0, 0, 0}, {1, 1, 1}, 2), make_needle(1_mm, 30_mm)}) {
        const repaired_mesh same = repair(m);
        CHECK(same.notes.empty());
        CHECK(same.surface.positions == m.positions);
        CHECK(same.surface.faces == m.faces);
    }
}

TEST_CASE("holes of 3 to 1000 edges are closed by flat lids that do not overlap") {
    for (const std::uint32_t edges : {3U, 4U, 5U, 8U, 13U, 40U, 100U, 199U, 200U, 201U, 300U, 1000U}) {
        CAPTURE(edges);
        for (const double inner : {1.0, 0.4}) { // convex, and a star
            if (inner < 1 && edges % 2 != 0) continue;
            const std::vector<vec2> polygon = star(edges, 0.02, 0.02 * inner);
            const repaired_mesh closed = repair(open_prism(polygon, 0.01F));
            check_closed(closed, 0.01 * area_of(polygon));
            REQUIRE(closed.notes.size() == 1);
            CHECK(says(closed, "Closed 1 hole along " + std::to_string(edges) + " edges with "));
            bool all_upwards = false;
            CHECK(lid_area(closed.surface, 0.01F, all_upwards) ==
                  doctest::Approx(area_of(polygon)).scale(1e-30).epsilon(1e-5));
            CHECK(all_upwards); // with the right sum of areas: no face lies on another
        }
    }
}

TEST_CASE("a large hole of any outline is closed by a flat lid that does not overlap") {
    for (const std::uint32_t edges : {150U, 250U, 700U}) {
        CAPTURE(edges);
        std::vector<vec2> polygon = star(edges, 0.02, 0.02);
        for (std::uint32_t i = 0; i < edges; ++i) polygon[i] *= 0.3F + 0.7F * hash_uniform(edges, i);
        const repaired_mesh closed = repair(open_prism(polygon, 0.01F));
        check_closed(closed, 0.01 * area_of(polygon));
        bool all_upwards = false;
        CHECK(lid_area(closed.surface, 0.01F, all_upwards) ==
              doctest::Approx(area_of(polygon)).scale(1e-30).epsilon(1e-5));
        CHECK(all_upwards);
    }
}

TEST_CASE("a hemisphere and a tube that is open at both ends enclose what their lids close") {
    mesh half = make_sphere({0, 0, 0}, 10_mm, 5);
    std::erase_if(half.faces, [&](const uvec3& f) {
        return half.positions[f.x].z + half.positions[f.y].z + half.positions[f.z].z < 0;
    });
    check_closed(repair(half), 2 * exact_pi / 3 * 1e-6, 0.02); // the rim is jagged

    mesh tube = make_cylinder({0, 0, 0}, {0, 0, 200_mm}, 1_mm, 48, 30);
    std::erase_if(tube.faces, [&](const uvec3& f) {
        const float z = tube.positions[f.x].z;
        return tube.positions[f.y].z == z && tube.positions[f.z].z == z;
    });
    const repaired_mesh closed = repair(tube);
    check_closed(closed, 24 * std::sin(2 * exact_pi / 48) * 1e-6 * 0.2);
    CHECK(says(closed, "Closed 2 holes along 96 edges with 92 faces; the largest is 2.8"));
}

TEST_CASE("holes that touch at a vertex are closed one by one") {
    mesh ball = make_sphere({0, 0, 0}, 10_mm, 3);
    const double whole = enclosed_volume(ball);
    const std::uint32_t shared = ball.faces[500].x; // two faces at a vertex that have no side in common
    std::vector<std::size_t> around;
    for (std::size_t i = 0; i < ball.faces.size(); ++i)
        for (int k = 0; k < 3; ++k)
            if (ball.faces[i][k] == shared) around.push_back(i);
    REQUIRE(around.size() >= 5);
    const uvec3 first = ball.faces[around[0]];
    for (std::size_t i = 1; i < around.size(); ++i) {
        const uvec3 other = ball.faces[around[i]];
        int common = 0;
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) common += first[a] == other[b] ? 1 : 0;
        if (common != 1) continue;
        ball.faces.erase(ball.faces.begin() + static_cast<std::ptrdiff_t>(around[i]));
        ball.faces.erase(ball.faces.begin() + static_cast<std::ptrdiff_t>(around[0]));
        break;
    }
    REQUIRE(ball.faces.size() == 1278);
    const repaired_mesh closed = repair(ball);
    check_closed(closed, whole);
    CHECK(says(closed, "Closed 2 holes along 6 edges with 2 faces"));
}

TEST_CASE("triangle soup, slits and vertices apart by rounding are welded") {
    const mesh ball = make_sphere({0.3F, 0, 1.4F}, 40_mm, 3);
    const double volume = enclosed_volume(ball);
    const repaired_mesh welded = repair(unwelded(ball));
    check_closed(welded, volume);
    CHECK(welded.surface.positions.size() == ball.positions.size());
    REQUIRE(welded.notes.size() == 1);
    CHECK(welded.notes[0] == "Merged 3198 vertices with another one at the same point."); // 3 * 1280 - 642

    mesh shaken = unwelded(ball);
    for (std::uint32_t i = 0; i < shaken.positions.size(); ++i)
        for (int k = 0; k < 3; ++k)
            shaken.positions[i][k] += 20e-6F * (hash_uniform(7, 3 * i + static_cast<std::uint32_t>(k)) - 0.5F);
    check_closed(repair(shaken, {.weld_distance = 0.1_mm}), volume, 1e-3);
    CHECK_FALSE(validate(repair(shaken, {.weld_distance = 0}).surface).closed());

    const mesh fine = make_sphere({0, 0, 0}, 10e-6F, 4); // closed, and finer than the distance
    const repaired_mesh same = repair(fine, {.weld_distance = 0.01F});
    CHECK(same.notes.empty());
    CHECK(same.surface.faces == fine.faces);

    mesh slit = make_cylinder({0, 0, 0}, {0, 0, 40_mm}, 10_mm, 64, 20); // along a seam of the side
    const double inside = enclosed_volume(slit);
    std::vector<std::uint32_t> twin(slit.positions.size());
    for (std::uint32_t i = 0; i < twin.size(); ++i) {
        const vec3 p = slit.positions[i];
        twin[i] = i;
        if (p.x > 9.99_mm && p.z > 5_mm && p.z < 35_mm) {
            twin[i] = static_cast<std::uint32_t>(slit.positions.size());
            slit.positions.push_back(p + vec3{0, 50e-6F, 0});
        }
    }
    for (uvec3& f : slit.faces) {
        const float middle = slit.positions[f.x].y + slit.positions[f.y].y + slit.positions[f.z].y;
        if (middle > 0) f = {twin[f.x], twin[f.y], twin[f.z]};
    }
    REQUIRE(validate(slit).boundary_edges > 20);
    check_closed(repair(slit, {.weld_distance = 0.1_mm}), inside, 1e-4); // sewn
    const repaired_mesh filled = repair(slit);
    check_closed(filled, inside, 1e-3);
    CHECK(says(filled, "Closed 1 hole along"));
}

TEST_CASE("copies of faces and walls between parts that touch are removed") {
    mesh twice = make_box({0, 0, 0}, {1, 1, 1}, 1);
    append(twice, mesh{twice});
    const repaired_mesh once = repair(twice);
    check_closed(once, 1);
    CHECK(says(once, "Removed 48 copies of faces."));

    mesh both_sides = make_box({0, 0, 0}, {1, 1, 1}, 1); // as some programs export it
    append(both_sides, turned_inside_out(mesh{both_sides}));
    check_closed(repair(both_sides), 1);

    mesh pair = make_box({0, 0, 0}, {1, 1, 1}, 1); // with a wall of 8 faces of each
    append(pair, make_box({1, 0, 0}, {2, 1, 1}, 1));
    const repaired_mesh one = repair(pair);
    check_closed(one, 2);
    CHECK(says(one, "Removed 16 faces of walls between parts that touch."));
    CHECK(validate(one.surface).components == 1);

    mesh flat = make_box({0, 0, 0}, {1, 1, 1});
    flat.positions.push_back(vec3{flat.positions[flat.faces[0].x]});
    flat.faces.push_back({flat.faces[0].x, flat.faces[0].y, 8});
    const repaired_mesh without = repair(flat);
    check_closed(without, 1);
    CHECK(says(without, "Removed 1 face with two corners at the same point."));
}

TEST_CASE("faces are turned until neighbours agree and the body is inside") {
    const mesh ball = make_sphere({0, 0, 0}, 10_mm, 3);
    const double volume = enclosed_volume(ball);
    mesh flipped = ball;
    for (std::size_t i = 0; i < flipped.faces.size(); i += 7) turn(flipped.faces[i]);
    const repaired_mesh agreed = repair(flipped);
    check_closed(agreed, volume);
    REQUIRE(agreed.notes.size() == 1);
    CHECK(says(agreed, "Turned 183 faces that disagreed"));

    const repaired_mesh outwards = repair(turned_inside_out(ball));
    check_closed(outwards, volume);
    REQUIRE(outwards.notes.size() == 1);
    CHECK(says(outwards, "Turned 1 part that faced inwards."));

    mesh shell = ball; // the wall of its cavity faces outwards
    append(shell, make_sphere({0, 0, 0}, 5_mm, 3));
    append(shell, make_sphere({0, 0, 0}, 2_mm, 3)); // a ball in the cavity
    append(shell, make_sphere({30_mm, 0, 0}, 5_mm, 3));
    const repaired_mesh hollow = repair(shell);
    check_closed(hollow, volume * (1 - 0.125 + 0.008 + 0.125), 1e-4);
    REQUIRE(hollow.notes.size() == 1);
    CHECK(says(hollow, "Turned 1 wall of a cavity inwards."));
    CHECK(validate(hollow.surface).inside_out_components == 1);
}

TEST_CASE("bodies that touch at an edge or a vertex are separated") {
    mesh at_edge = make_box({0, 0, 0}, {1, 1, 1}, 1);
    append(at_edge, turned_inside_out(make_box({1, 1, 0}, {2, 2, 1}, 1)));
    const repaired_mesh two = repair(at_edge);
    check_closed(two, 2);
    CHECK(says(two, "Separated surfaces that touched along 2 edges."));
    CHECK(says(two, "Turned 1 part that faced inwards."));
    CHECK(validate(two.surface).components == 2);
    CHECK(two.surface.positions.size() == at_edge.positions.size());

    mesh at_vertex = make_box({0, 0, 0}, {1, 1, 1});
    append(at_vertex, make_box({1, 1, 1}, {2, 2, 2}));
    const repaired_mesh apart = repair(at_vertex);
    check_closed(apart, 2);
    CHECK(says(apart, "Separated surfaces that touched at 1 vertex."));

    // Unit cubes of a grid, each with its own faces, that touch in all ways.
    mesh cells;
    double count = 0;
    for (std::uint32_t i = 0; i < 216; ++i) {
        if (hash_uniform(5, i) > 0.5F) continue;
        const vec3 low{static_cast<float>(i % 6), static_cast<float>(i / 6 % 6), static_cast<float>(i / 36)};
        append(cells, make_box(low, low + vec3{1}));
        ++count;
    }
    const repaired_mesh joined = repair(cells);
    check_closed(joined, count);
    CHECK(says(joined, "Separated surfaces that touched along"));
}

TEST_CASE("what encloses nothing is left open, and said") {
    mesh strip; // of Moebius
    constexpr std::uint32_t count = 40;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 2 * exact_pi * i / count;
        for (const double side : {-0.2, 0.2}) {
            const double radius = 1 + side * std::cos(angle / 2);
            strip.positions.emplace_back(static_cast<float>(radius * std::cos(angle)),
                                         static_cast<float>(radius * std::sin(angle)),
                                         static_cast<float>(side * std::sin(angle / 2)));
        }
        const bool last = i + 1 == count;
        const std::uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
        strip.faces.insert(strip.faces.end(), {{a, c, b}, {b, c, d}});
    }
    const repaired_mesh one_sided = repair(strip);
    CHECK(one_sided.surface.faces == strip.faces);
    CHECK(says(one_sided, "Left 1 part with 80 faces as before: the surface has one side only"));
    CHECK(validate(one_sided.surface).boundary_edges == 80);

    mesh sheets;
    for (const float z : {0.0F, 1.0F}) {
        mesh sheet = make_box({0, 0, z}, {10, 10, z + 1}, 3);
        std::erase_if(sheet.faces, [&](const uvec3& f) {
            return sheet.positions[f.x].z != z || sheet.positions[f.y].z != z || sheet.positions[f.z].z != z;
        });
        append(sheets, sheet);
    }
    const repaired_mesh open = repair(sheets);
    CHECK(open.surface.faces.size() == sheets.faces.size());
    CHECK(says(open, "Left 2 sheets with 256 faces open"));
    CHECK_FALSE(validate(open.surface).closed());

    mesh with_crumb = make_sphere({0, 0, 0}, 1, 3);
    append(with_crumb, {{{2, 0, 0}, {2.1F, 0, 0}, {2, 0.1F, 0}}, {{0, 1, 2}}});
    const repaired_mesh clean = repair(with_crumb);
    check_closed(clean, enclosed_volume(make_sphere({0, 0, 0}, 1, 3)));
    CHECK(says(clean, "Removed 1 loose sheet with 1 face."));
}

TEST_CASE("two loose sheets that touch along an edge are removed") {
    mesh with_crumb = make_sphere({0, 0, 0}, 1, 3);
    mesh crumb{{{2, 0, 0}, {2, 0, 0.1F}}, {{1, 0, 2}, {0, 1, 3}, {1, 0, 4}, {0, 1, 5}}};
    for (const double angle : {0.0, 179.0, 181.0, 359.0}) // two sheets, each nearly flat
        crumb.positions.emplace_back(static_cast<float>(2 + 0.1 * std::cos(exact_pi / 180 * angle)),
                                     static_cast<float>(0.1 * std::sin(exact_pi / 180 * angle)), 0.0F);
    append(with_crumb, crumb);
    const repaired_mesh clean = repair(with_crumb);
    check_closed(clean, enclosed_volume(make_sphere({0, 0, 0}, 1, 3)));
    REQUIRE(clean.notes.size() == 1);
    CHECK(clean.notes[0] == "Removed 2 loose sheets with 4 faces.");
}

TEST_CASE("edges of three faces are left to validate") {
    mesh finned = make_box({0, 0, 0}, {1, 1, 1});
    const uvec3 f = finned.faces[0];
    finned.positions.emplace_back(3, 3, 3);
    finned.faces.push_back({f.x, f.y, 8});
    const repaired_mesh same = repair(finned);
    CHECK(same.surface.faces == finned.faces);
    CHECK(validate(same.surface).non_manifold_edges == 1);
}

TEST_CASE("a sphere of which faces were lost at random is closed again, or says why not") {
    const mesh ball = make_sphere({0, 0, 0}, 10_mm, 3);
    const double whole = enclosed_volume(ball);
    for (std::uint32_t trial = 0; trial < 300; ++trial) {
        CAPTURE(trial);
        const float lost = 0.9F * static_cast<float>(trial) / 300;
        mesh holed = trial % 2 == 0 ? ball : unwelded(ball);
        std::vector<uvec3> kept;
        for (std::uint32_t i = 0; i < holed.faces.size(); ++i) {
            if (hash_uniform(10 * trial + 1, i) < lost) continue;
            kept.push_back(holed.faces[i]);
            if (trial % 3 == 0 && hash_uniform(10 * trial + 2, i) < 0.3F) turn(kept.back());
            if (trial % 5 == 0 && hash_uniform(10 * trial + 3, i) < 0.1F) kept.push_back(kept.back());
        }
        holed.faces = kept;
        const repaired_mesh mended = repair(holed);
        const mesh_report report = validate(mended.surface);
        INFO(all_notes(mended));
        INFO(explain(report));
        CHECK(report.faces_out_of_range == 0);
        CHECK(report.misoriented_edges == 0);
        CHECK(report.non_manifold_edges == 0);
        CHECK((report.closed() || says(mended, "Left ")));
        if (lost < 0.15F) CHECK(report.closed());
        if (lost < 0.05F) CHECK(report.volume == doctest::Approx(whole).scale(1e-30).epsilon(0.02));
        CHECK(repair(mended.surface).surface.faces.size() == mended.surface.faces.size()); // nothing more to do
    }
}

TEST_CASE("any triangles on a small lattice give a mesh whose faces agree, whatever they touch") {
    for (std::uint32_t trial = 0; trial < 3000; ++trial) {
        CAPTURE(trial);
        mesh tangle;
        const auto side = 2 + trial % 3;
        for (std::uint32_t i = 0; i < side * side * side; ++i)
            tangle.positions.emplace_back(static_cast<float>(i % side), static_cast<float>(i / side % side),
                                          static_cast<float>(i / side / side));
        const auto corner = [&](std::uint32_t i) {
            return static_cast<std::uint32_t>(hash_uniform(trial, i) * static_cast<float>(tangle.positions.size()));
        };
        for (std::uint32_t i = 0; i < 1 + trial % 60; ++i)
            tangle.faces.emplace_back(corner(3 * i), corner(3 * i + 1), corner(3 * i + 2));
        const repaired_mesh mended = repair(tangle);
        INFO(all_notes(mended));
        for (const uvec3 f : mended.surface.faces) REQUIRE(std::max({f.x, f.y, f.z}) < mended.surface.positions.size());
        const mesh_report report = validate(mended.surface);
        INFO(explain(report));
        if (!says(mended, "one side only")) CHECK(report.misoriented_edges == 0);
    }
}

TEST_CASE("invalid input is refused") {
    const auto complaint = [](const mesh& m, const repair_settings& settings = {}) -> std::string {
        try {
            repair(m, settings);
        } catch (const geometry_error& refused) {
            return refused.what();
        } catch (const usage_error& refused) {
            return refused.what();
        }
        return "accepted";
    };
    CHECK(complaint({}) == "repair: the mesh has no faces; check that the right file or object was read");
    mesh box = make_box({0, 0, 0}, {1, 1, 1});
    box.faces[3].y = 8;
    CHECK(complaint(box) == "repair: a face names vertex 8, but the mesh has 8; indices start at 0");
    box = make_box({0, 0, 0}, {1, 1, 1});
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        box.positions[5].y = bad;
        CHECK(complaint(box) == "repair: vertex 5 is not finite; check the computation or file it comes from");
    }
    for (const float bad : {-1e-6F, 0.011F, std::numeric_limits<float>::quiet_NaN()})
        CHECK(complaint(make_box({0, 0, 0}, {1, 1, 1}), {.weld_distance = bad}).find("must be from 0 to 0.01 m") !=
              std::string::npos);

    const repaired_mesh nothing = repair(mesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 0, 1}}}); // no face is left
    CHECK(nothing.surface.faces.empty());
    CHECK(nothing.surface.positions.empty());
    const float huge = 3e38F;
    const repaired_mesh large =
        repair(mesh{{{-huge, 0, 0}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}}});
    CHECK(validate(large.surface).boundary_edges == 0);
}

} // namespace repair_test

TEST_CASE("a hole beside the wall between two parts is closed, and the wall removed, wherever it is") {
    mesh whole = make_box({0, 0, 0}, {10_mm, 10_mm, 10_mm});
    mesh_test::append(whole, make_box({10_mm, 0, 0}, {20_mm, 10_mm, 10_mm}));
    const auto on_wall = [&](const uvec3& f) {
        return whole.positions[f.x].x == 10_mm && whole.positions[f.y].x == 10_mm && whole.positions[f.z].x == 10_mm;
    };
    for (std::size_t i = 0; i < whole.faces.size(); ++i) {
        mesh lacking = whole;
        lacking.faces.erase(lacking.faces.begin() + static_cast<std::ptrdiff_t>(i));
        if (on_wall(whole.faces[i])) continue;
        const repaired_mesh mended = repair(lacking);
        INFO("without face ", i);
        CHECK(validate(mended.surface).closed());
        CHECK(enclosed_volume(mended.surface) == doctest::Approx(2e-6).scale(1e-30));
        CHECK(repair_test::says(mended, " faces of walls between parts that touch."));
        CHECK(std::none_of(mended.surface.faces.begin(), mended.surface.faces.end(), [&](const uvec3& f) {
            const std::vector<vec3>& at = mended.surface.positions;
            return at[f.x].x == 10_mm && at[f.y].x == 10_mm && at[f.z].x == 10_mm;
        }));
    }
}

TEST_CASE("what is left because faces are missing where more than two meet is told") {
    mesh book; // three pages at one edge
    book.positions = {{0, 0, 0}, {0, 10_mm, 0}, {10_mm, 0, 0}, {-10_mm, 0, 5_mm}, {-10_mm, 0, -5_mm}};
    book.faces = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
    const repaired_mesh kept = repair(book);
    REQUIRE(kept.notes.size() == 1);
    CHECK(kept.notes[0] ==
          "Left 3 parts with 3 faces as before: faces are missing or too many at edges where more than two meet.");
}
