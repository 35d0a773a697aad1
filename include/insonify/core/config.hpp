#ifndef INSONIFY_CORE_CONFIG_HPP
#define INSONIFY_CORE_CONFIG_HPP

#include <insonify/core/version.hpp>

/// INSONIFY_FN marks what runs on a CUDA device as well as on the host.
/// INSONIFY_INLINE keeps helpers that take SIMD values inline, so that the values stay in registers.
/// INSONIFY_VISITS stands before such a template that calls what the user brings, which may be for the host alone.
/// INSONIFY_LAZY stands before a function that need not be a template, and makes it one: so it, and all of the standard
/// library that it instantiates, is compiled only in files that call it, though every user's file includes it. What
/// is constexpr there, it defers by `later<Later>(...)`: see later.hpp.
#define INSONIFY_LAZY                                                                                                  \
    template <class Later = void>                                                                                      \
    inline
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
#define INSONIFY_VISITS
#define INSONIFY_INLINE [[gnu::always_inline]] inline
#endif

/// INSONIFY_NO_SIMD, defined by the user before the first include, leaves <experimental/simd> out: `unseq` is scalar.
/// It is also set here where that header is missing or cannot be compiled (nvcc).
#if !defined(INSONIFY_NO_SIMD) && (defined(__CUDACC__) || !__has_include(<experimental/simd>))
#define INSONIFY_NO_SIMD
#endif

/// INSONIFY_ABI names the inline namespace that everything lives in: version, instruction set, SIMD or not.
///
/// Objects compiled with different flags thus have different types: handing one across is a link error, never a crash.
#if defined(__CUDACC__)
#define INSONIFY_ABI v0_cuda
#elif defined(INSONIFY_NO_SIMD)
#if defined(__AVX512F__)
#define INSONIFY_ABI v0_scalar_avx512
#elif defined(__AVX2__) && defined(__FMA__)
#define INSONIFY_ABI v0_scalar_avx2_fma
#elif defined(__AVX__)
#define INSONIFY_ABI v0_scalar_avx
#else
#define INSONIFY_ABI v0_scalar
#endif
#else
#if defined(__AVX512F__)
#define INSONIFY_ABI v0_avx512
#elif defined(__AVX2__) && defined(__FMA__)
#define INSONIFY_ABI v0_avx2_fma
#elif defined(__AVX__)
#define INSONIFY_ABI v0_avx
#elif defined(__SSE4_1__)
#define INSONIFY_ABI v0_sse4
#elif defined(__SSE2__)
#define INSONIFY_ABI v0_sse2
#elif defined(__ARM_NEON)
#define INSONIFY_ABI v0_neon
#else
#define INSONIFY_ABI v0_simd
#endif
#endif

namespace insonify::inline INSONIFY_ABI {

/// True where a fused multiply-add is one instruction; elsewhere it is a slow library call.
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__CUDACC__)
inline constexpr bool has_fma = true;
#else
inline constexpr bool has_fma = false;
#endif

} // namespace insonify::inline INSONIFY_ABI
#endif
