#ifndef INSONIFY_TESTS_TRACING_RANDOM_SCENES_HPP
#define INSONIFY_TESTS_TRACING_RANDOM_SCENES_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <utility>

/// Scenes, probes and planes that are drawn at random.
namespace slice_test {

using namespace insonify;

inline vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

// Balls, boxes and cylinders in random poses: they nest, overlap and hold the probe.
inline scene random_scene(std::uint64_t seed) {
    scene body{tissue::water};
    const auto objects = 2 + hash_bits(seed, 1) % 6;
    for (std::uint64_t i = 0; i < objects; ++i) {
        const std::uint64_t own = hash_bits(seed, 100 + i);
        const float size = 4_mm + 20_mm * hash_uniform(own, 0);
        mesh surface = own % 3 == 0 ? make_sphere({0, 0, 0}, size, 3)
                       : own % 3 == 1
                           ? make_box(-vec3{size, 0.7F * size, 0.5F * size}, {size, 0.7F * size, 0.5F * size}, 2)
                           : make_cylinder({0, 0, -size}, {0, 0, size}, 0.6F * size, 20);
        const vec3 centre = vec3{0, 0, 30_mm} + 25_mm * random_point(own, 3);
        body.add(std::move(surface), tissue::fat,
                 {.at = look_at(centre, centre + random_point(own, 4), random_point(own, 5))});
    }
    body.add(make_sphere({0, 0, 0}, 12_mm, 3), tissue::muscle); // the probe stands in it
    body.add(mesh{}, tissue::bone);                             // an empty one as well
    body.build(exec::par);
    return body;
}

// The same, its trees out of date.
inline scene treeless_scene(std::uint64_t seed) {
    scene body = random_scene(seed);
    for (const object& one : body.objects()) body.positions(one.id);
    body.update(exec::par);
    return body;
}

// Parallel lines that leave the face at an angle.
struct steered_array : linear_array {
    float angle = 20_deg;
    ray beam(float line) const {
        return {.origin = linear_array::beam(line).origin, .direction = {std::sin(angle), 0, std::cos(angle)}};
    }
};

// Lines from a flat face, as if they came from a point behind it; before it, they would run towards that point.
struct trapezoid : linear_array {
    float behind = 30_mm;
    ray beam(float line) const {
        const vec3 origin = linear_array::beam(line).origin;
        return {.origin = origin, .direction = (behind > 0 ? 1.0F : -1.0F) * normalize(origin + vec3{0, 0, behind})};
    }
};

template <class Body>
void with_every_probe(const Body& body) {
    body(linear_array{.lines = 61, .width = 30_mm});
    body(steered_array{{.lines = 47, .width = 30_mm}});
    body(trapezoid{{.lines = 50, .width = 20_mm}});
    body(convex_array{.lines = 53, .radius = 20_mm, .field_of_view = 70_deg});
    body(convex_array{.lines = 64, .radius = 9_mm, .field_of_view = 300_deg});
    body(phased_array{.lines = 48, .width = 10_mm, .field_of_view = 90_deg});
    body(radial_array{.lines = 99, .radius = 2_mm});
    body(linear_array{.lines = 1, .width = 1_mm});
}

} // namespace slice_test

#endif
