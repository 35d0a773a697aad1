#ifndef INSONIFY_BVH_CONCEPTS_HPP
#define INSONIFY_BVH_CONCEPTS_HPP

#include <insonify/geometry/aabb.hpp>
#include <insonify/geometry/hit.hpp>
#include <insonify/geometry/ray.hpp>
#include <concepts>
#include <cstddef>
#include <type_traits>

namespace insonify::inline INSONIFY_ABI {

/// What a tree can hold: anything with `bounds(p)` and `intersect(ray, p)`, found by argument-dependent lookup.
///
/// `intersect` gives at most one hit, and may answer outside the ray's limits: the tree discards what lies there, and
/// sets the hit's `primitive` itself. A primitive whose bounds are empty or not finite is never hit.
template <class Primitive>
concept primitive = requires(const Primitive& p, const ray& r) {
    { bounds(p) } -> std::convertible_to<aabb>;
    { intersect(r, p) } -> std::convertible_to<hit>;
};

/// What `[]` of a range gives.
template <class Range>
using range_primitive_t = std::remove_cvref_t<decltype(std::declval<const Range&>()[std::size_t{}])>;

/// A copyable handle to primitives that somebody else owns: `size()` and `[]`. `view<T>` and `mesh_view` are such.
///
/// (std::copyable asks for more, and takes a compiler long to find out.)
template <class Range>
concept primitive_range = std::is_copy_constructible_v<Range> && std::is_copy_assignable_v<Range> &&
    primitive<range_primitive_t<Range>> && requires(const Range& range) {
    { range.size() } -> std::convertible_to<std::size_t>;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
