#ifndef INSONIFY_BVH_LEAF_TRIANGLES_HPP
#define INSONIFY_BVH_LEAF_TRIANGLES_HPP

#include <insonify/bvh/leaf.hpp>
#include <insonify/bvh/ray_packet.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

template <class Range>
concept triangle_range = primitive_range<Range> && std::same_as<range_primitive_t<Range>, triangle>;

/// Triangles in the sheared plane of a ray (see `sheared_ray`), side by side: several of one ray's, or one of several
/// rays'.
template <int N>
struct sheared_triangles {
    lanes<N> x[3], y[3], z[3]; ///< of the three corners; z not yet scaled
};

/// Which of them a ray meets, and where.
template <int N>
struct triangle_hits {
    lanes<N> u, v, w;      ///< twice the areas of the triangles that the ray's point makes with each edge
    lane_mask<N> possible; ///< set where it is met, as far as floats can tell ...
    lane_mask<N> certain;  ///< ... and where they are certain of it

    /// Along the ray; of those that are certain.
    INSONIFY_FN INSONIFY_INLINE lanes<N> distance(const sheared_triangles<N>& t, const lanes<N>& scale) const {
        // First, lest large numbers overflow, or small ones vanish. The others' sum may be 0: they divide by `scale`. Not by
        // 1, for clang inverts constants by itself, and then divides by 0 all the same.
        const lanes<N> share = lanes<N>(1.0F) / select(certain, u + v + w, scale);
        lanes<N> shares[3] = {u * share, v * share, w * share};
#if __FINITE_MATH_ONLY__ > 0 && !defined(__CUDACC__) // -ffast-math, or a part of it
        asm("" : "+m"(shares));                      // or the compiler changes the order back
#endif
        return multiply_add(shares[0], t.z[0], multiply_add(shares[1], t.z[1], shares[2] * t.z[2])) * scale;
    }
};

/// The watertight test of triangle.hpp, in floats. They tell the side of an edge but where the ray passes within
/// rounding of it; there `possible` and `certain` differ, and that triangle is to be asked again, exactly.
template <int N>
INSONIFY_FN INSONIFY_INLINE triangle_hits<N> meet(const sheared_triangles<N>& t) {
    using floats = lanes<N>;
    const floats u = difference_of_products(t.x[1], t.y[2], t.y[1], t.x[2]);
    const floats v = difference_of_products(t.x[2], t.y[0], t.y[2], t.x[0]);
    const floats w = difference_of_products(t.x[0], t.y[1], t.y[0], t.x[1]);
    const floats lowest = lesser(lesser(u, v), w), highest = greater(greater(u, v), w);
    const floats size = absolute(u + v + w);
    floats doubt(1e-35F);              // below it an underflow may have taken the sign
    auto told = size <= floats(1e37F); // beyond it has no precise inverse
    if constexpr (!has_fma) { // each product is at most |x| |y|: four roundings of half a unit each, doubled for safety
        const floats reach_x = greater(greater(absolute(t.x[0]), absolute(t.x[1])), absolute(t.x[2]));
        const floats reach_y = greater(greater(absolute(t.y[0]), absolute(t.y[1])), absolute(t.y[2]));
        doubt = reach_x * reach_y * floats(5e-7F) + doubt;
        told = told && reach_x * reach_y <= floats(3.0F) * size; // of slivers signs are certain before shares are
    }
    told = told && (doubt < lowest || highest < -doubt);
    return {u, v, w, !(lowest < -doubt && doubt < highest), told};
}

/// Four triangles, side by side.
struct four_triangles {
    four_points a, b, c;

    INSONIFY_FN INSONIFY_INLINE explicit four_triangles(const triangle (&t)[4])
        : a{t[0].a, t[1].a, t[2].a, t[3].a}, b{t[0].b, t[1].b, t[2].b, t[3].b}, c{t[0].c, t[1].c, t[2].c, t[3].c} {}

    INSONIFY_FN INSONIFY_INLINE four_points lower() const {
        return {lesser(lesser(a.x, b.x), c.x), lesser(lesser(a.y, b.y), c.y), lesser(lesser(a.z, b.z), c.z)};
    }
    INSONIFY_FN INSONIFY_INLINE four_points upper() const {
        return {greater(greater(a.x, b.x), c.x), greater(greater(a.y, b.y), c.y), greater(greater(a.z, b.z), c.z)};
    }
    /// Negative where one is not finite.
    INSONIFY_FN INSONIFY_INLINE bit_lanes<4> wild() const { return a.wild() | b.wild() | c.wild(); }
};

/// A leaf of triangles: their corners side by side for SIMD, so that a ray meets all of them at once.
template <triangle_range Range, int Width>
struct alignas(64) leaf<Range, Width> {
    float corner[3][3][Width];      ///< [corner][axis][triangle]; after the last one, the first again
    std::uint32_t primitive[Width]; ///< `no_primitive` where none is, or one that is not finite

    /// A bit for each triangle that can be hit.
    INSONIFY_FN INSONIFY_INLINE std::uint32_t usable() const {
        return bits_of(lanes<Width>(0.0F) <= floats_of<Width>(load_bits<Width>(primitive)));
    }

    aabb fill(const Range& range, const std::uint32_t* slots) {
        using floats = lanes<4>; // four triangles at a time: no more corners fit into registers
        static_assert(Width % 4 == 0);
        floats low_x(FLT_MAX), low_y(FLT_MAX), low_z(FLT_MAX), high_x(-FLT_MAX), high_y(-FLT_MAX), high_z(-FLT_MAX);
        for (int first = 0; first < Width; first += 4) {
            const auto in = [&](int i) {
                return range[slots[first + i] != no_primitive ? slots[first + i] : slots[0]];
            };
            const four_triangles t{{in(0), in(1), in(2), in(3)}};
            const four_points lower = t.lower(), upper = t.upper();
            const bit_lanes<4> wild = t.wild();
            const auto finite = floats(0.0F) <= floats_of<4>(wild);
            low_x = lesser(low_x, select(finite, lower.x, floats(FLT_MAX)));
            low_y = lesser(low_y, select(finite, lower.y, floats(FLT_MAX)));
            low_z = lesser(low_z, select(finite, lower.z, floats(FLT_MAX)));
            high_x = greater(high_x, select(finite, upper.x, floats(-FLT_MAX)));
            high_y = greater(high_y, select(finite, upper.y, floats(-FLT_MAX)));
            high_z = greater(high_z, select(finite, upper.z, floats(-FLT_MAX)));
            t.a.put(corner[0], first);
            t.b.put(corner[1], first);
            t.c.put(corner[2], first);
            const bit_lanes<4> left_out = bit_lanes<4>{} - (wild >> 31); // all bits, or none
            store_bits<4>(load_bits<4>(slots + first) | left_out, primitive + first);
        }
        return {{least(low_x), least(low_y), least(low_z)}, {greatest(high_x), greatest(high_y), greatest(high_z)}};
    }

    static build_box box(const Range& range, std::size_t i) {
        const triangle t = range[i];
        const auto corner_of = [](const vec3& p) {
            return each_lane<4>([&p](int axis) { return axis < 3 ? p[axis] : 0.0F; });
        };
        const lanes<4> a = corner_of(t.a), b = corner_of(t.b), c = corner_of(t.c);
        const lanes<4> wild = floats_of<4>(not_finite<4>(a) | not_finite<4>(b) | not_finite<4>(c));
        if (bits_of(wild < lanes<4>(0.0F)) != 0) return build_box::none();
        return {-lesser(lesser(a, b), c), greater(greater(a, b), c)};
    }

    INSONIFY_INLINE static four_centres centres(const Range& range, std::size_t first, std::size_t last) {
        const four_triangles t{{range[first], range[std::min(first + 1, last)], range[std::min(first + 2, last)],
                                range[std::min(first + 3, last)]}};
        const four_points lower = t.lower(), upper = t.upper();
        return {{half_centre(lower.x, upper.x), half_centre(lower.y, upper.y), half_centre(lower.z, upper.z)},
                t.wild()};
    }

    /// Calls visit(hit) for every triangle that the ray meets.
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
        const triangle_hits<Width> met = meet(t);
        const std::uint32_t possible = bits_of(met.possible) & usable();
        if (possible == 0) return;
        const std::uint32_t certain = bits_of(met.certain);
        float distance[Width];
        store(met.distance(t, floats(shear.shear.z)), distance);
        for (std::uint32_t left = possible; left != 0; left &= left - 1) {
            const std::uint32_t i = lowest_bit(left);
            const bool told = (certain >> i & 1U) != 0 && is_finite(distance[i]);
            const float found = told ? distance[i] : intersect(shear, corners(i)).distance;
            if (found >= r.source.min_distance && found <= max_distance && found < FLT_MAX)
                visit(hit{.distance = found, .primitive = primitive[i]});
        }
    }

    /// Calls visit(group, its first ray, primitive, distances) for every triangle that one of a group's rays may meet; a
    /// visit returns 0 where it has lowered no limit. The same arithmetic as above, so that a ray gets the same answer alone
    /// and in a packet.
    template <class Visit>
    void intersect_packet(ray_packet<Width>& p, const Visit& visit) const {
        using floats = lanes<Width>;
        const int x = p.axes[0], y = p.axes[1], z = p.axes[2];
        floats inwards[3], width[3]; // in the row
        floats from_low(-FLT_MAX), to_high(FLT_MAX), nearest(FLT_MAX);
        for (int c = 0; c < 3; ++c) {
            const floats at_x = load<Width>(corner[c][x]), at_y = load<Width>(corner[c][y]);
            const floats at_z = load<Width>(corner[c][z]);
            const floats along_row = multiply_add(floats(p.row[0]), at_x, floats(p.row[1]) * at_y);
            const floats across_row = multiply_add(floats(p.row[0]), at_y, floats(-p.row[1]) * at_x);
            inwards[c] = p.places.inwards(along_row, at_z);
            width[c] = p.places.width(at_z);
            from_low = greater(from_low, multiply_add(floats(-p.across.slowest), at_z, across_row));
            to_high = lesser(to_high, multiply_add(floats(-p.across.fastest), at_z, across_row));
            nearest = lesser(nearest, floats(p.forward) * at_z);
        }
        const std::uint32_t across =
            usable() & bits_of(floats(p.across.low) <= from_low && to_high <= floats(p.across.high));
        if (across == 0) return;
        floats first(FLT_MAX), last(-FLT_MAX); // places of corners
        for (int c = 0; c < 3; ++c) {
            const floats place = p.places.place(inwards[c], width[c]);
            first = lesser(first, place);
            last = greater(last, place);
        }
        const auto unknown = nearest < floats(p.places.valid_from);
        if ((bits_of(unknown) & across) != 0) { // anywhere, unless they lie beyond a side of the whole row
            const floats zero(0.0F);
            const floats after = greater(greater(inwards[0], inwards[1]), inwards[2]);
            const floats before = greater(greater(width[0] - inwards[0], width[1] - inwards[1]), width[2] - inwards[2]);
            const auto within = zero <= after && zero <= before;
            first = select(unknown, select(within, floats(-FLT_MAX), floats(FLT_MAX)), first);
            last = select(unknown, floats(FLT_MAX), last);
        }
        static_assert(ray_packet<Width>::most_rays <= 32);
        std::uint32_t inside = 0; // a bit for each group and triangle
        for (std::uint32_t g = 0; g < p.groups; ++g) {
            const auto& group = p.of[g];
            const std::uint32_t met = across & bits_of(nearest <= floats(group.end) && floats(group.first) <= last &&
                                                       first <= floats(group.last));
            inside |= met << (g * Width);
        }
        std::uint32_t lowered = 0;
        for (; inside != 0; inside &= inside - 1) {
            const std::uint32_t g = lowest_bit(inside) / Width, i = lowest_bit(inside) % Width;
            lowered |= visit(p.of[g], g * Width, primitive[i], meet_group(p, g, i));
        }
        if (lowered != 0) p.shorten();
    }

    INSONIFY_FN triangle corners(std::uint32_t i) const {
        return {{corner[0][0][i], corner[0][1][i], corner[0][2][i]},
                {corner[1][0][i], corner[1][1][i], corner[1][2][i]},
                {corner[2][0][i], corner[2][1][i], corner[2][2][i]}};
    }

  private:
    // How far along each ray of a group triangle i is met, FLT_MAX where it is not.
    INSONIFY_INLINE lanes<Width> meet_group(const ray_packet<Width>& p, std::size_t g, std::uint32_t i) const {
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
        const triangle_hits<Width> met = meet(t);
        const floats distance = select(met.possible, met.distance(t, load<Width>(group.shear[2])), floats(FLT_MAX));
        std::uint32_t doubtful = bits_of(met.possible) & ~bits_of(met.certain && absolute(distance) <= floats(FLT_MAX));
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

} // namespace insonify::inline INSONIFY_ABI
#endif
