// The BVH holds any primitive with `bounds` and `intersect`, found by argument-dependent lookup. Here: the nylon wires
// of a test phantom, as exact circles.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <cstdio>

namespace phantom {

/// An infinite cylinder along y.
struct wire {
    insonify::vec2 centre{};
    float radius = 0;
};

INSONIFY_FN inline insonify::aabb bounds(const wire& w) {
    return {{w.centre.x - w.radius, -1, w.centre.y - w.radius}, {w.centre.x + w.radius, 1, w.centre.y + w.radius}};
}

INSONIFY_FN inline insonify::hit intersect(const insonify::ray& r, const wire& w) {
    const insonify::vec2 o = insonify::vec2{r.origin.x, r.origin.z} - w.centre, d{r.direction.x, r.direction.z};
    const float a = dot(d, d), b = dot(o, d), discriminant = b * b - a * (dot(o, o) - w.radius * w.radius);
    if (!(a > 0) || discriminant < 0) return {};
    return {.distance = (-b - std::sqrt(discriminant)) / a};
}

} // namespace phantom

static_assert(insonify::primitive<phantom::wire>);

int main() {
    using namespace insonify;

    std::vector<phantom::wire> wires; // in rows of increasing depth
    for (int row = 1; row <= 8; ++row)
        for (int column = 0; column < 5; ++column)
            wires.push_back(
                {{(2.0F * static_cast<float>(column * column) - 15) * 1_mm, static_cast<float>(row) * 5_mm}, 0.5_mm});
    const bvh tree{exec::par, wires};

    // An image from the BVH alone: every wire that each line of a probe hits.
    const linear_array probe{.lines = 380, .width = 38_mm};
    scan_lines echoes{probe.lines, 450, 45_mm};
    for_each_index(exec::par, probe.lines, [&](std::size_t line) {
        std::vector<hit> hits;
        tree.all(probe.beam(static_cast<float>(line)), hits); // nearest first
        for (const hit& each : hits)
            echoes(static_cast<std::uint32_t>(line), static_cast<std::uint32_t>(each.distance / 0.1_mm)) = 1;
    });
    write_png("own_primitive.png", scan_convert(exec::par, echoes, probe));

    std::vector<hit> hits;
    tree.all({.origin = {-15_mm, 0, 0}}, hits);
    const hit first = tree.closest({.origin = {-15_mm, 0, 0}});
    const bool blocked = tree.any({.origin = {0, 0, 0}, .direction = {0, 1, 0}});
    std::printf("%zu wires under the first column, the nearest at %g mm\n", hits.size(), first.distance / 1_mm);
    return hits.size() == 8 && first.primitive == 0 && std::fabs(first.distance - 4.5_mm) < 1e-6F && !blocked ? 0 : 1;
}
