#ifndef INSONIFY_TESTS_SLAB_HPP
#define INSONIFY_TESTS_SLAB_HPP

#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/shapes.hpp>
#include <cmath>

/// A square slab behind a point, whose front faces along a normal.
inline insonify::mesh slab(insonify::vec3 centre, insonify::vec3 normal, float width, float thickness) {
    const insonify::vec3 across = std::fabs(normal.y) < std::fabs(normal.z) + std::fabs(normal.x)
                                      ? insonify::vec3{0, 1, 0}
                                      : insonify::vec3{1, 0, 0};
    const insonify::pose at = insonify::look_at(centre, centre + normal, across);
    insonify::mesh made = insonify::make_box({-width / 2, -width / 2, -thickness}, {width / 2, width / 2, 0});
    for (insonify::vec3& p : made.positions) p = at.point(p);
    return made;
}

#endif
