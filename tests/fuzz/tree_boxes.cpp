// Trees over arbitrary boxes answer as going through all of them does: however built, refitted, one by one or in batches.
#include <insonify/bvh/bvh.hpp>
#include "input.hpp"
#include <algorithm>
#include <vector>

using namespace insonify;

namespace {

struct crate {
    aabb box{};
};
aabb bounds(const crate& c) { return c.box; }

/// Where the ray comes in, or 0 where it begins inside; in double, so that rounding is not what is tested.
hit intersect(const ray& r, const crate& c) {
    double in = 0, out = DBL_MAX;
    for (int axis = 0; axis < 3; ++axis) {
        const double origin = r.origin[axis], along = r.direction[axis];
        double low = c.box.lower[axis] - origin, high = c.box.upper[axis] - origin;
        if (along == 0) {
            if (low > 0 || high < 0) return {};
            continue;
        }
        low /= along;
        high /= along;
        if (low > high) std::swap(low, high);
        in = std::max(in, low);
        out = std::min(out, high);
    }
    if (in > out || in > static_cast<double>(FLT_MAX)) return {};
    hit found;
    found.distance = static_cast<float>(in);
    return found;
}

std::vector<hit> all_of(const std::vector<crate>& crates, ray r) {
    std::vector<hit> hits;
    if (!fuzz::legal(r)) return hits;
    for (std::uint32_t i = 0; i < crates.size(); ++i) {
        if (!is_finite(crates[i].box)) continue;
        hit found = intersect(r, crates[i]);
        if (!(found.distance >= r.min_distance && found.distance <= r.max_distance && found)) continue;
        found.primitive = i;
        hits.push_back(found);
    }
    std::sort(hits.begin(), hits.end(), [](const hit& a, const hit& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.primitive < b.primitive;
    });
    return hits;
}

enum class asked { one_by_one, at_once };

template <class Builder>
void check(const bvh<view<const crate>, simd_width, Builder>& tree, const std::vector<crate>& crates,
           const std::vector<ray>& rays, asked how) {
    std::vector<hit> closest(rays.size());
    std::vector<std::vector<hit>> all(rays.size());
    std::vector<std::uint8_t> any(rays.size());
    if (how == asked::at_once) {
        tree.closest(exec::unseq, rays, closest);
        tree.any(exec::unseq, rays, any);
        tree.all(exec::unseq, rays, all);
    } else {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            closest[i] = tree.closest(rays[i]);
            any[i] = tree.any(rays[i]);
            tree.all(rays[i], all[i]);
        }
    }
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::vector<hit> expected = all_of(crates, rays[i]);
        fuzz::require(all[i] == expected, "all hits of a ray are found, nearest first");
        fuzz::require(closest[i] == (expected.empty() ? hit{} : expected.front()),
                      "the closest hit is the first of all");
        fuzz::require((any[i] != 0) == !expected.empty(), "something is hit where anything is");
    }
}

template <class Builder>
void check_builder(std::vector<crate> crates, const std::vector<crate>& moved, const std::vector<ray>& rays,
                   const aabb& region, asked how) {
    bvh<view<const crate>, simd_width, Builder> tree{exec::seq, crates};
    check(tree, crates, rays, how);
    const bvh_statistics about = tree.statistics();
    fuzz::require(about.bytes <= 2048 + 512 * crates.size(), "a tree takes at most 2 KiB and 512 bytes a primitive");
    std::vector<std::uint32_t> near_by, expected;
    tree.overlapping(region, near_by);
    for (std::uint32_t i = 0; i < crates.size(); ++i)
        if (is_finite(crates[i].box) && overlaps(region, crates[i].box)) expected.push_back(i);
    fuzz::require(near_by == expected, "all boxes that overlap another are found");
    if (moved.empty()) return;
    std::copy(moved.begin(), moved.end(), crates.begin()); // some are finite now, and others no more
    tree.refit(exec::seq);
    check(tree, crates, rays, how);
    tree.update(exec::seq);
    check(tree, crates, rays, how);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    const auto box = [&] {
        const vec3 a = in.point(), b = in.point();
        return in.below(8) == 0 ? aabb{a, b} : aabb{min(a, b), max(a, b)}; // some empty
    };
    const std::uint32_t way = in.byte();
    std::vector<ray> rays(1 + in.below(4));
    for (ray& r : rays) {
        r = {.origin = in.point(), .direction = in.point()};
        if (in.below(2) != 0) r.min_distance = in.number();
        if (in.below(2) != 0) r.max_distance = in.number();
    }
    const aabb region = box();
    std::vector<crate> crates, moved;
    const std::uint32_t moving = in.below(4);
    while (!in.empty() && crates.size() < 40) (moved.size() < moving ? moved : crates).push_back({box()});
    if (moved.size() > crates.size()) moved.resize(crates.size());
    const asked how = (way & 1U) != 0 ? asked::at_once : asked::one_by_one;
    if ((way & 2U) != 0)
        check_builder<build_morton>(crates, moved, rays, region, how);
    else
        check_builder<build_sah>(crates, moved, rays, region, how);
    return 0;
}
