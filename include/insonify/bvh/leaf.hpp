#ifndef INSONIFY_BVH_LEAF_HPP
#define INSONIFY_BVH_LEAF_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/ray_packet.hpp>
#include <cstddef>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI::detail {

/// The box of a primitive in builders: [-lower, -, upper, -], so that the union of two is one maximum.
struct alignas(32) build_box {
    float row[8];

    build_box() = default; ///< uninitialised: arrays are filled later, in parallel
    explicit build_box(const aabb& box)
        : row{-box.lower.x, -box.lower.y, -box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, 0} {}
    INSONIFY_INLINE build_box(const lanes<4>& minus_lower, const lanes<4>& upper) {
        store(minus_lower, row);
        store(upper, row + 4);
    }

    /// Stores the index of the primitive in the spare lanes, in two halves that floats represent exactly.
    void name(std::uint32_t primitive) {
        row[3] = static_cast<float>(primitive >> 16U);
        row[7] = static_cast<float>(primitive & 0xFFFFU);
    }
    std::uint32_t primitive() const {
        return static_cast<std::uint32_t>(row[3]) << 16U | static_cast<std::uint32_t>(row[7]);
    }
    static build_box none() { return {lanes<4>(-FLT_MAX), lanes<4>(-FLT_MAX)}; }

    INSONIFY_INLINE void add(const build_box& other) {
        for (int k = 0; k < 8; k += simd_width)
            store(max(load<simd_width>(row + k), load<simd_width>(other.row + k)), row + k);
    }
    INSONIFY_INLINE lanes<4> minus_lower() const { return load<4>(row); }
    INSONIFY_INLINE lanes<4> upper() const { return load<4>(row + 4); }

    /// Half the centre: sorts like the centre, and differences of two do not overflow.
    INSONIFY_INLINE lanes<4> half_centre() const {
        return multiply_add(lanes<4>(-0.25F), minus_lower(), lanes<4>(0.25F) * upper());
    }
    float half_area() const { // 0 for an empty box
        const float x = max(row[4] + row[0], 0), y = max(row[5] + row[1], 0), z = max(row[6] + row[2], 0);
        return x * y + y * z + z * x;
    }
};

/// Bounds of the half centres of a group.
struct centre_range {
    float begin[4] = {FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX};
    float end[4] = {-FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};

    INSONIFY_INLINE void add(const lanes<4>& first, const lanes<4>& last) {
        store(min(load<4>(begin), first), begin);
        store(max(load<4>(end), last), end);
    }
    float widest() const { return max(end[0] - begin[0], max(end[1] - begin[1], end[2] - begin[2])); }
    bool holds(const centre_range& other) const {
        bool held = true;
        for (int k = 0; k < 3; ++k) held = held && begin[k] <= other.begin[k] && other.end[k] <= end[k];
        return held;
    }
    /// Extended on each side by a fraction of the widest extent.
    INSONIFY_INLINE centre_range widened(float fraction) const {
        const lanes<4> more(fraction * widest());
        centre_range wider;
        wider.add(load<4>(begin) - more, load<4>(end) + more);
        return wider;
    }
    /// Clipped to the box, which contains all centres.
    INSONIFY_INLINE centre_range within(const build_box& box) const {
        centre_range both;
        store(max(load<4>(begin), lanes<4>(-0.5F) * box.minus_lower()), both.begin);
        store(min(load<4>(end), lanes<4>(0.5F) * box.upper()), both.end);
        return both;
    }
};

/// The number of primitives from which faces and corners are prefetched. Smaller meshes, up to some 2 MB, are cached
/// (bench/bvh.cpp refits a small mesh and a large one).
inline constexpr std::size_t prefetch_threshold = std::size_t{1} << 17U;

/// The box of the first primitive that has one which is finite; where none has, a point in the origin.
template <class Range>
build_box first_box(const Range& range) {
    for (std::size_t i = 0; i < range.size(); ++i)
        if (const aabb found = bounds(range[i]); is_finite(found)) return build_box{found};
    return build_box{aabb{vec3{0}, vec3{0}}};
}

/// A leaf holds the indices of its primitives and reads them from the range. Triangles are stored in it: see below.
template <class Range, int Width>
struct leaf {
    std::uint32_t primitive[Width]; ///< `no_primitive` in empty slots, and where bounds are not finite

    /// Reads the primitives from the range. @return their box
    aabb fill(const Range& range, const std::uint32_t* slots) {
        aabb whole;
        for (int i = 0; i < Width; ++i) {
            primitive[i] = no_primitive;
            if (slots[i] == no_primitive) continue;
            const aabb box = bounds(range[slots[i]]);
            if (!is_finite(box)) continue;
            primitive[i] = slots[i];
            whole = merged(whole, box);
        }
        return whole;
    }

    /// Finds the box of a primitive; where that is empty or not finite, the box stays as it is.
    static void bound(const Range& range, std::size_t i, build_box& box) {
        if (const aabb found = bounds(range[i]); is_finite(found)) box = build_box{found};
    }

    /// Calls visit(hit) for every hit between min_distance and max_distance, which visit may lower.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void intersect_all(const prepared_ray<Width>& r, const float& max_distance, const Range& range,
                                   Visit&& visit) const {
        for (const std::uint32_t one : primitive) {
            if (one == no_primitive) continue;
            hit found = intersect(r.source, range[one]);
            if (!(found.distance >= r.source.min_distance && found.distance <= max_distance && found)) continue;
            found.primitive = one;
            visit(found);
        }
    }
};

template <class Range>
concept triangle_range = primitive_range<Range> && std::same_as<range_primitive_t<Range>, triangle>;

/// Triangles in the sheared space of rays (see `sheared_ray`): N triangles for one ray, or one triangle for N rays.
template <int N>
struct sheared_triangles {
    lanes<N> x[3], y[3], z[3]; ///< of the corners; z is not scaled
};

/// The result of N edge tests.
template <int N>
struct triangle_hits {
    lanes<N> u, v, w;      ///< scaled barycentric coordinates
    lane_mask<N> possible; ///< hit, as far as single precision can tell ...
    lane_mask<N> certain;  ///< ... and where it is conclusive

    /// The distances along the rays, where `certain`.
    INSONIFY_FN INSONIFY_INLINE lanes<N> distance(const sheared_triangles<N>& t, const lanes<N>& scale) const {
        // Divides first, to avoid overflow and underflow. Lanes that are not certain divide by `scale`, since their sum
        // may be 0; not by a constant 1: clang would fold the select and divide by 0.
        const lanes<N> inverse_area = lanes<N>(1.0F) / select(certain, u + v + w, scale);
        lanes<N> fractions[3] = {u * inverse_area, v * inverse_area, w * inverse_area};
#if __FINITE_MATH_ONLY__ > 0 && !defined(__CUDACC__) // parts of -ffast-math
        asm("" : "+m"(fractions));                   // keeps the order of the operations
#endif
        return multiply_add(fractions[0], t.z[0], multiply_add(fractions[1], t.z[1], fractions[2] * t.z[2])) * scale;
    }
};

/// The watertight edge tests of triangle.hpp in single precision. Where a ray passes an edge within rounding,
/// `possible` and `certain` differ: such triangles are tested again in double precision.
template <int N>
INSONIFY_FN INSONIFY_INLINE triangle_hits<N> test_edges(const sheared_triangles<N>& t) {
    using floats = lanes<N>;
    const floats u = difference_of_products(t.x[1], t.y[2], t.y[1], t.x[2]);
    const floats v = difference_of_products(t.x[2], t.y[0], t.y[2], t.x[0]);
    const floats w = difference_of_products(t.x[0], t.y[1], t.y[0], t.x[1]);
    const floats lowest = min(min(u, v), w), highest = max(max(u, v), w);
    const floats size = abs(u + v + w);
    floats doubt(1e-35F);                    // below it, an underflow may change the sign
    auto conclusive = size <= floats(1e37F); // beyond it, the inverse is not precise
    if constexpr (!has_fma) {
        // products are at most |x| |y|: four roundings of half an ulp each, doubled for safety
        const floats max_x = max(max(abs(t.x[0]), abs(t.x[1])), abs(t.x[2]));
        const floats max_y = max(max(abs(t.y[0]), abs(t.y[1])), abs(t.y[2]));
        doubt = max_x * max_y * floats(5e-7F) + doubt;
        // For slivers, signs are certain earlier than barycentric coordinates.
        conclusive = conclusive && max_x * max_y <= floats(3.0F) * size;
    }
    conclusive = conclusive && (doubt < lowest || highest < -doubt);
    return {u, v, w, !(lowest < -doubt && doubt < highest), conclusive};
}

/// A leaf of triangles, stored as structure of arrays: a ray is tested against all of them at once.
template <triangle_range Range, int Width>
struct alignas(64) leaf<Range, Width> {
    float corner[3][3][Width];      ///< [corner][axis][triangle]; empty slots repeat the first one
    std::uint32_t primitive[Width]; ///< `no_primitive` in empty slots, and where a triangle is not finite

    /// A bit for each triangle that can be hit.
    INSONIFY_FN INSONIFY_INLINE std::uint32_t usable() const {
        return bits_of(lanes<Width>(0.0F) <= floats_of<Width>(load_bits<Width>(primitive)));
    }

    aabb fill(const Range& range, const std::uint32_t* slots) {
        triangle t[Width];
        for (int i = 0; i < Width; ++i) t[i] = range[slots[i] != no_primitive ? slots[i] : slots[0]];
        lanes<Width> low[3], high[3];
        bit_lanes<Width> wild{};
        for (int axis = 0; axis < 3; ++axis) {
            const auto put = [&](vec3 triangle::*which, int c) {
                const auto row = each_lane<Width>([&](int i) { return (t[i].*which)[axis]; });
                store(row, corner[c][axis]);
                wild = wild | not_finite<Width>(row);
                return row;
            };
            const auto a = put(&triangle::a, 0), b = put(&triangle::b, 1), c = put(&triangle::c, 2);
            low[axis] = min(min(a, b), c);
            high[axis] = max(max(a, b), c);
        }
        const auto finite = lanes<Width>(0.0F) <= floats_of<Width>(wild);
        aabb whole;
        for (int axis = 0; axis < 3; ++axis) {
            whole.lower[axis] = reduce_min(select(finite, low[axis], lanes<Width>(FLT_MAX)));
            whole.upper[axis] = reduce_max(select(finite, high[axis], lanes<Width>(-FLT_MAX)));
        }
        const bit_lanes<Width> left_out = bit_lanes<Width>{} - (wild >> 31); // a full mask
        store_bits<Width>(load_bits<Width>(slots) | left_out, primitive);
        return whole;
    }

    INSONIFY_INLINE static void bound(const Range& range, std::size_t i, build_box& box) {
        const triangle t = range[i];
        const auto corner_of = [](const vec3& p) {
            return each_lane<4>([&p](int axis) { return axis < 3 ? p[axis] : 0.0F; });
        };
        const lanes<4> a = corner_of(t.a), b = corner_of(t.b), c = corner_of(t.c);
        const lanes<4> wild = floats_of<4>(not_finite<4>(a) | not_finite<4>(b) | not_finite<4>(c));
        if (bits_of(wild < lanes<4>(0.0F)) == 0) box = {-min(min(a, b), c), max(max(a, b), c)};
    }

    /// Calls visit(hit) for every triangle that the ray hits between its limits.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void intersect_all(const prepared_ray<Width>& r, const float& max_distance, const Range&,
                                   Visit&& visit) const {
        using floats = lanes<Width>;
        const sheared_ray& shear = r.sheared;
        const floats origin_x(shear.begin.x), origin_y(shear.begin.y), origin_z(shear.begin.z);
        const floats minus_shear_x(-shear.shear.x), minus_shear_y(-shear.shear.y);
        sheared_triangles<Width> t;
        for (int c = 0; c < 3; ++c) {
            t.z[c] = load<Width>(corner[c][shear.z]) - origin_z;
            t.x[c] = multiply_add(minus_shear_x, t.z[c], load<Width>(corner[c][shear.x]) - origin_x);
            t.y[c] = multiply_add(minus_shear_y, t.z[c], load<Width>(corner[c][shear.y]) - origin_y);
        }
        const triangle_hits<Width> hits = test_edges(t);
        const std::uint32_t possible = bits_of(hits.possible) & usable();
        if (possible == 0) return;
        const std::uint32_t certain = bits_of(hits.certain);
        float distance[Width];
        store(hits.distance(t, floats(shear.shear.z)), distance);
        for (std::uint32_t left = possible; left != 0; left &= left - 1) {
            const std::uint32_t i = lowest_bit(left);
            const bool conclusive = (certain >> i & 1U) != 0 && is_finite(distance[i]);
            const float found = conclusive ? distance[i] : intersect(shear, corners(i)).distance;
            if (found >= r.source.min_distance && found <= max_distance && found < FLT_MAX)
                visit(hit{.distance = found, .primitive = primitive[i]});
        }
    }

    /// Calls visit(group, index of its first ray, primitive, distances) for every triangle that a ray of the group may
    /// hit; visit returns 0 if it lowered no limit. Uses the arithmetic of `intersect_all`, so that a ray has the same
    /// hits alone and in a packet.
    template <class Visit>
    void intersect_packet(ray_packet<Width>& p, const Visit& visit) const {
        using floats = lanes<Width>;
        const int x = p.axes[0], y = p.axes[1], z = p.axes[2];
        floats along[3], depth[3]; // of the corners: along the row, and along z
        floats from_low(-FLT_MAX), to_high(FLT_MAX), nearest(FLT_MAX);
        for (int c = 0; c < 3; ++c) {
            const floats at_x = load<Width>(corner[c][x]), at_y = load<Width>(corner[c][y]);
            const floats across = multiply_add(floats(p.row[0]), at_y, floats(-p.row[1]) * at_x);
            along[c] = multiply_add(floats(p.row[0]), at_x, floats(p.row[1]) * at_y);
            depth[c] = load<Width>(corner[c][z]);
            from_low = max(from_low, multiply_add(floats(-p.across.min_slope), depth[c], across));
            to_high = min(to_high, multiply_add(floats(-p.across.max_slope), depth[c], across));
            nearest = min(nearest, floats(p.forward) * depth[c]);
        }
        const std::uint32_t across =
            usable() & bits_of(floats(p.across.low) <= from_low && to_high <= floats(p.across.high));
        if (across == 0) return;
        static_assert(ray_packet<Width>::max_rays <= 32);
        std::uint32_t inside = 0; // a bit per group and triangle
        for (std::uint32_t g = 0; g < p.groups; ++g) {
            const packet_wedge& own = p.of[g].along;
            from_low = floats(-FLT_MAX), to_high = floats(FLT_MAX);
            for (int c = 0; c < 3; ++c) {
                from_low = max(from_low, multiply_add(floats(-own.min_slope), depth[c], along[c]));
                to_high = min(to_high, multiply_add(floats(-own.max_slope), depth[c], along[c]));
            }
            const auto met =
                nearest <= floats(p.of[g].end) && floats(own.low) <= from_low && to_high <= floats(own.high);
            inside |= (across & bits_of(met)) << (g * Width);
        }
        std::uint32_t lowered = 0;
        for (; inside != 0; inside &= inside - 1) {
            const std::uint32_t g = lowest_bit(inside) / Width, i = lowest_bit(inside) % Width;
            lowered |= visit(p.of[g], g * Width, primitive[i], intersect_group(p, g, i));
        }
        if (lowered != 0) p.shorten();
    }

    INSONIFY_FN triangle corners(std::uint32_t i) const {
        return {{corner[0][0][i], corner[0][1][i], corner[0][2][i]},
                {corner[1][0][i], corner[1][1][i], corner[1][2][i]},
                {corner[2][0][i], corner[2][1][i], corner[2][2][i]}};
    }

  private:
    // The distances at which the rays of a group hit triangle i; FLT_MAX for misses.
    INSONIFY_INLINE lanes<Width> intersect_group(const ray_packet<Width>& p, std::size_t g, std::uint32_t i) const {
        using floats = lanes<Width>;
        const int x = p.axes[0], y = p.axes[1], z = p.axes[2];
        const auto& group = p.of[g];
        const floats minus_shear_x = -load<Width>(group.shear[0]), minus_shear_y = -load<Width>(group.shear[1]);
        sheared_triangles<Width> t;
        for (int c = 0; c < 3; ++c) {
            t.z[c] = floats(corner[c][z][i]) - load<Width>(group.origin[2]);
            t.x[c] = multiply_add(minus_shear_x, t.z[c], floats(corner[c][x][i]) - load<Width>(group.origin[0]));
            t.y[c] = multiply_add(minus_shear_y, t.z[c], floats(corner[c][y][i]) - load<Width>(group.origin[1]));
        }
        const triangle_hits<Width> hits = test_edges(t);
        const floats distance = select(hits.possible, hits.distance(t, load<Width>(group.shear[2])), floats(FLT_MAX));
        std::uint32_t doubtful = bits_of(hits.possible) & ~bits_of(hits.certain && abs(distance) <= floats(FLT_MAX));
        if (doubtful == 0) return distance;
        alignas(sizeof(floats)) float exact[Width];
        store(distance, exact);
        for (; doubtful != 0; doubtful &= doubtful - 1) {
            const std::uint32_t k = lowest_bit(doubtful);
            exact[k] = intersect(p.one(g, k), corners(i)).distance;
        }
        return load<Width>(exact);
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
