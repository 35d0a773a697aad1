#ifndef INSONIFY_CORE_CONFIG_HPP
#define INSONIFY_CORE_CONFIG_HPP

#include <insonify/core/version.hpp>
#include <version> // identifies the standard library

/// INSONIFY_FN marks functions that run on a CUDA device as well as on the host.
/// INSONIFY_INLINE forces inlining of functions that take SIMD values, so that the values stay in registers.
/// INSONIFY_VISITS precedes an INSONIFY_FN template that calls a user's function, which may exist for the host only.
#if defined(__CUDACC__)
#define INSONIFY_FN __host__ __device__
#define INSONIFY_INLINE __forceinline__
#define INSONIFY_VISITS _Pragma("nv_exec_check_disable")
#elif defined(_MSC_VER)
#define INSONIFY_FN
#define INSONIFY_INLINE __forceinline
#define INSONIFY_VISITS
#else
#define INSONIFY_FN
#define INSONIFY_INLINE [[gnu::always_inline]] inline
#define INSONIFY_VISITS
#endif

/// INSONIFY_NO_SIMD, defined by the user before the first include, selects scalar code for `lanes<N>` and for `unseq`.
/// It is also set here for compilers without vector types and for nvcc, which rejects them in device code.
#if !defined(INSONIFY_NO_SIMD) && (defined(__CUDACC__) || !(defined(__GNUC__) || defined(__clang__)))
#define INSONIFY_NO_SIMD
#endif

// The parts of INSONIFY_ABI: SIMD implementation, instruction set, fused multiply-add, standard library.
#if defined(__CUDACC__)
#define INSONIFY_ABI_SIMD _cuda
#elif defined(INSONIFY_NO_SIMD)
#define INSONIFY_ABI_SIMD _scalar
#elif defined(__GLIBCXX__) && __has_include(<experimental/simd>) // libc++ ships that header too, without the types
#define INSONIFY_STD_SIMD
#define INSONIFY_ABI_SIMD
#else
#define INSONIFY_ABI_SIMD _vector
#endif

#if defined(__AVX512VL__)
#define INSONIFY_ABI_SET _avx512vl
#elif defined(__AVX512F__)
#define INSONIFY_ABI_SET _avx512
#elif defined(__AVX2__)
#define INSONIFY_ABI_SET _avx2
#elif defined(__AVX__)
#define INSONIFY_ABI_SET _avx
#elif defined(__SSE4_1__)
#define INSONIFY_ABI_SET _sse4
#elif defined(__SSE2__)
#define INSONIFY_ABI_SET _sse2
#elif defined(__ARM_NEON)
#define INSONIFY_ABI_SET _neon
#elif defined(__wasm_simd128__)
#define INSONIFY_ABI_SET _wasm128
#else
#define INSONIFY_ABI_SET _generic
#endif

#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
#define INSONIFY_ABI_FMA _fma
#else
#define INSONIFY_ABI_FMA
#endif

#if defined(_LIBCPP_VERSION)
#define INSONIFY_ABI_LIBRARY _libcxx
#else
#define INSONIFY_ABI_LIBRARY
#endif

/// INSONIFY_ABI names the inline namespace of the library, such as `v0_sse2` or `v0_neon_fma_vector_libcxx`.
///
/// Objects compiled with different flags thus have different types, and no function of one replaces that of another:
/// passing such an object across is a link error.
#define INSONIFY_ABI_JOIN(set, fma, simd, library) v0##set##fma##simd##library
#define INSONIFY_ABI_NAME(set, fma, simd, library) INSONIFY_ABI_JOIN(set, fma, simd, library)
#define INSONIFY_ABI INSONIFY_ABI_NAME(INSONIFY_ABI_SET, INSONIFY_ABI_FMA, INSONIFY_ABI_SIMD, INSONIFY_ABI_LIBRARY)

namespace insonify::inline INSONIFY_ABI::detail {

/// True where a fused multiply-add is one instruction; elsewhere std::fma is a slow library call.
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__CUDACC__)
inline constexpr bool has_fma = true;
#else
inline constexpr bool has_fma = false;
#endif

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
