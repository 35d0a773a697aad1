#ifndef INSONIFY_EXECUTION_VECTOR_TYPE_HPP
#define INSONIFY_EXECUTION_VECTOR_TYPE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cstdint>

#if !defined(INSONIFY_NO_SIMD)
namespace insonify::inline INSONIFY_ABI::detail {

template <class T, int N>
struct vector_type {
    using type __attribute__((vector_size(sizeof(T) * N))) = T;
};

/// N values in the compiler's own vector type, with the operators of T lane by lane.
template <class T, int N>
using vector = typename vector_type<T, N>::type;

} // namespace insonify::inline INSONIFY_ABI::detail
#endif

#include <insonify/core/restore_macros.hpp>

#endif
