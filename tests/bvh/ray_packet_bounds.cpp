#include <insonify/bvh/ray_packet.hpp>
#include <insonify/core/random.hpp>
#include <cstddef>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace ray_packet_bounds_test {

using namespace insonify::detail;

TEST_CASE("a thin packet enters a box exactly where its rays do, in every direction") {
    constexpr int width = simd_width;
    const auto uniform = [](std::uint64_t i) { return 2 * hash_uniform(21, i) - 1; };
    const aabb scene{vec3{-2}, vec3{2}};
    int lost = 0, entered = 0, kept = 0, missed = 0;
    for (std::uint64_t k = 0; k < 20'000; ++k) {
        const std::uint64_t i = 16 * k;
        const vec3 origin = 3.0F * vec3{uniform(i), uniform(i + 1), uniform(i + 2)};
        const vec3 direction{uniform(i + 3), uniform(i + 4), uniform(i + 5)};
        std::vector<ray> rays(width, ray{.origin = origin, .direction = direction});
        for (std::size_t r = 0; r < width; ++r) rays[r].origin.x += 1e-4F * static_cast<float>(r);
        ray_packet<width> packet;
        if (packet.prepare(rays.data(), width, scene, 2, 1) == 0) continue;
        tree_node<width> node{};
        for (int c = 0; c < width; ++c) {
            const std::uint64_t b = i + 6 + static_cast<std::uint64_t>(c);
            const vec3 lower = 1.5F * vec3{uniform(b), uniform(b + 100), uniform(b + 200)};
            node.set_box(c, {lower, lower + vec3{0.5F}});
        }
        lanes<width> entry(0.0F);
        const std::uint32_t found = enter(node, packet, entry);
        for (int c = 0; c < width; ++c) {
            const bool enters = (found >> static_cast<unsigned>(c) & 1U) != 0;
            bool some = false, some_nearly = false;
            for (const ray& one : rays) {
                const aabb box = node.box(c);
                double in = 0, out = 1e9, in_nearly = 0, out_nearly = 1e9;
                for (int axis = 0; axis < 3; ++axis) {
                    const double o = one.origin[axis], d = one.direction[axis], margin = 0.01;
                    const double a = (box.lower[axis] - o) / d, b = (box.upper[axis] - o) / d;
                    in = std::max(in, std::min(a, b)), out = std::min(out, std::max(a, b));
                    const double c1 = (box.lower[axis] - margin - o) / d, c2 = (box.upper[axis] + margin - o) / d;
                    in_nearly = std::max(in_nearly, std::min(c1, c2));
                    out_nearly = std::min(out_nearly, std::max(c1, c2));
                }
                some = some || in <= out;
                some_nearly = some_nearly || in_nearly <= out_nearly;
            }
            lost += some && !enters;
            entered += some;
            kept += !some_nearly && enters;
            missed += !some_nearly;
        }
    }
    CHECK(lost == 0);
    CHECK(entered > 300);
    CHECK(missed > 10'000);
    CHECK(kept * 100 < missed); // where two slabs are nearly parallel to the rays
}

} // namespace ray_packet_bounds_test
