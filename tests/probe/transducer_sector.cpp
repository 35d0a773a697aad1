#include <insonify/probe/transducer.hpp>
#include <doctest/doctest.h>
#include <initializer_list>

using namespace insonify;

namespace sector_test {

TEST_CASE("sector: locate is the inverse of beam, all the way round") {
    for (const float radius : {0.0F, 0.010F, 0.060F})
        for (const float field : {0.5F, 1.5F, 3.1F, 6.2F}) {
            const detail::sector fan{.lines = 64, .radius = radius, .field_of_view = field};
            for (float line = -0.5F; line <= 63.5F; line += 1.75F)
                for (const float depth : {0.001F, 0.04F, 0.2F}) {
                    const ray beam = fan.beam(line);
                    const vec3 point = beam.at(depth);
                    CHECK(length(beam.direction) == doctest::Approx(1).scale(1e-30));
                    const vec2 back = fan.locate({point.x, point.z});
                    CHECK(back.x == doctest::Approx(line).epsilon(2e-3).scale(1e-30));
                    CHECK(back.y == doctest::Approx(depth).epsilon(1e-4).scale(1e-30));
                }
        }
}

TEST_CASE("sector: all lines, extended backwards, intersect in the apex behind the face") {
    const detail::sector fan{.lines = 32, .radius = 0.05F, .field_of_view = 1.2F};
    for (float line = 0; line < 32; line += 1) {
        const vec3 apex = fan.beam(line).at(-0.05F);
        CHECK(length(apex - vec3{0, 0, -0.05F}) < 1e-7F);
    }
}

} // namespace sector_test
