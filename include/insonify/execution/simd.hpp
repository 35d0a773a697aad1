#ifndef INSONIFY_EXECUTION_SIMD_HPP
#define INSONIFY_EXECUTION_SIMD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/execution/simd_scalar.hpp>
#include <insonify/execution/simd_std.hpp>
#include <insonify/execution/simd_vector.hpp>

namespace insonify::inline INSONIFY_ABI {

/// `lanes<N>` holds N floats, `lane_mask<N>` N truth values; arithmetic and comparisons act lane by lane.
///
/// One of three headers defines them: simd_std.hpp over std::experimental::simd (libstdc++), simd_vector.hpp over the
/// compiler's vector types (other standard libraries), simd_scalar.hpp over arrays (INSONIFY_NO_SIMD, nvcc). Each
/// provides `simd_width`, `load`, `store`, `each_lane`, `bits_of`, `min`, `max`, `abs`, `sqrt`, `multiply_add`,
/// `select`, `reduce_min`, `reduce_max` and `sum`.

/// 1 / a, correctly rounded also under -ffast-math.
template <class Lanes>
    requires requires { Lanes::size(); }
INSONIFY_FN INSONIFY_INLINE Lanes inverse(const Lanes& a) {
#if __FINITE_MATH_ONLY__ > 0 && !defined(__CUDACC__) // -ffast-math, or a part of it
    constexpr int n = static_cast<int>(Lanes::size());
    float each[n];
    store(a, each);
    for (float& one : each) {
        one = 1 / one;
        asm("" : "+m"(one)); // prevents a vector division, which is approximate here
    }
    return load<n>(each);
#else
    return Lanes(1.0F) / a;
#endif
}

/// a * b - c * d with an exact sign, independent of the order of the factors, where the result is not tiny: a fused
/// multiply-add recovers the rounding error of one product. Without that instruction, the difference of two rounded
/// products.
///
/// Source: Kahan; error below 1.5 units in the last place: Jeannerod, Louvet & Muller 2013, Mathematics of Computation.
template <class Lanes>
INSONIFY_FN INSONIFY_INLINE Lanes difference_of_products(const Lanes& a, const Lanes& b, const Lanes& c,
                                                         const Lanes& d) {
    const Lanes product = c * d;
    if constexpr (!detail::has_fma) return a * b - product;
    return multiply_add(a, b, -product) - multiply_add(c, d, -product);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
