#ifndef INSONIFY_BVH_CONCEPTS_HPP
#define INSONIFY_BVH_CONCEPTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/aabb.hpp>
#include <insonify/geometry/hit.hpp>
#include <insonify/geometry/ray.hpp>
#include <concepts>
#include <cstddef>
#include <type_traits>

namespace insonify::inline INSONIFY_ABI {

/// A primitive has `bounds(p)` and `intersect(ray, p)`, found by argument-dependent lookup.
///
/// `intersect` returns at most one hit and may ignore the ray's limits: the BVH discards hits outside them, and sets
/// `hit::primitive`. Primitives whose bounds are empty or not finite are never hit.
template <class Primitive>
concept primitive = requires(const Primitive& p, const ray& r) {
    { bounds(p) } -> std::convertible_to<aabb>;
    { intersect(r, p) } -> std::convertible_to<hit>;
};

/// The element type of a range.
template <class Range>
using range_primitive_t = std::remove_cvref_t<decltype(std::declval<const Range&>()[std::size_t{}])>;

/// A copyable view of primitives with `size()` and `[]`, such as `view<T>` and `mesh_view`.
///
/// (std::copyable requires more and is slow to compile.)
template <class Range>
concept primitive_range = std::is_copy_constructible_v<Range> && std::is_copy_assignable_v<Range> &&
    primitive<range_primitive_t<Range>> && requires(const Range& range) {
    { range.size() } -> std::convertible_to<std::size_t>;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
