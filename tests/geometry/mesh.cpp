#include <insonify/geometry/shapes.hpp>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("a closed mesh encloses its volume, negative where it is inside out, wherever it lies") {
    for (const float offset : {0.0F, 30.0F}) {
        mesh box = make_box({offset, 0, 0}, {offset + 0.5F, 0.25F, 2});
        CHECK(enclosed_volume(box) == doctest::Approx(0.25).scale(1e-30));
        for (uvec3& face : box.faces) std::swap(face.x, face.y);
        CHECK(enclosed_volume(box) == doctest::Approx(-0.25).scale(1e-30));
    }
    CHECK(enclosed_volume(mesh{}) == 0);
}

TEST_CASE("a vertex index out of range is refused with its number") {
    mesh box = make_box({0, 0, 0}, {1, 1, 1});
    CHECK_NOTHROW(detail::check_faces(box, "box: "));
    CHECK_NOTHROW(detail::check_faces(mesh{}, ""));
    for (int corner = 0; corner < 3; ++corner) {
        mesh wrong = box;
        wrong.faces.back()[corner] = 8;
        CHECK_THROWS_WITH_AS(detail::check_faces(wrong, "box: "),
                             "box: a face names vertex 8, but the mesh has 8; indices start at 0", geometry_error);
        wrong.faces[3][2 - corner] = 9;
        CHECK_THROWS_WITH_AS(detail::check_faces(wrong, "box: "),
                             "box: a face names vertex 9, but the mesh has 8; indices start at 0", geometry_error);
    }
}

TEST_CASE("a mesh view is a range of triangles") {
    const mesh m{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .faces = {{2, 0, 1}}};
    const mesh_view seen{m};
    CHECK(seen.size() == 1);
    CHECK(seen[0].a == vec3{0, 1, 0});
    CHECK(seen[0].b == vec3{0, 0, 0});
    CHECK(seen[0].c == vec3{1, 0, 0});
}
