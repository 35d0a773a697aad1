#ifndef INSONIFY_EXECUTION_POLICY_HPP
#define INSONIFY_EXECUTION_POLICY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cstdint>

#if defined(__GLIBCXX__) && __has_include(<pstl/execution_defs.h>)
#include <pstl/execution_defs.h> // the policy types alone: <execution> of libstdc++ costs seconds and pulls in TBB
#define INSONIFY_STANDARD_POLICIES __pstl::execution
#elif __has_include(<execution>)
#include <execution>
#if defined(__cpp_lib_execution)
#define INSONIFY_STANDARD_POLICIES std::execution
#endif
#endif

namespace insonify::inline INSONIFY_ABI {
namespace exec {

/// One thread; loops over samples are scalar.
struct sequenced_policy {};

/// One thread; loops over samples use SIMD.
struct unsequenced_policy {};

/// Several threads; loops over samples are scalar.
struct parallel_policy {
    std::uint32_t participants = 0; ///< threads including the caller; 0: one per processor

    /// Runs on exactly n threads, the caller being one.
    [[nodiscard]] constexpr parallel_policy threads(std::uint32_t n) const { return {n}; }
};

/// Several threads; loops over samples use SIMD.
struct parallel_unsequenced_policy {
    std::uint32_t participants = 0; ///< threads including the caller; 0: one per processor

    /// Runs on exactly n threads, the caller being one.
    [[nodiscard]] constexpr parallel_unsequenced_policy threads(std::uint32_t n) const { return {n}; }
};

inline constexpr sequenced_policy seq{};
inline constexpr parallel_policy par{};
inline constexpr unsequenced_policy unseq{};
inline constexpr parallel_unsequenced_policy par_unseq{};

/// Whether a policy permits SIMD across loop iterations. Specialise it for a policy of your own that does.
template <class Policy>
inline constexpr bool is_unsequenced_v = false;
template <>
inline constexpr bool is_unsequenced_v<unsequenced_policy> = true;
template <>
inline constexpr bool is_unsequenced_v<parallel_unsequenced_policy> = true;

} // namespace exec

namespace detail {

/// The library's policy for a policy of std::execution.
template <class Policy>
struct own_policy;

#if defined(INSONIFY_STANDARD_POLICIES)
namespace standard = INSONIFY_STANDARD_POLICIES;

template <>
struct own_policy<standard::sequenced_policy> {
    using type = exec::sequenced_policy;
};
template <>
struct own_policy<standard::parallel_policy> {
    using type = exec::parallel_policy;
};
template <>
struct own_policy<standard::unsequenced_policy> {
    using type = exec::unsequenced_policy;
};
template <>
struct own_policy<standard::parallel_unsequenced_policy> {
    using type = exec::parallel_unsequenced_policy;
};
#endif

} // namespace detail

#if defined(INSONIFY_STANDARD_POLICIES)
template <>
inline constexpr bool exec::is_unsequenced_v<detail::standard::unsequenced_policy> = true;
template <>
inline constexpr bool exec::is_unsequenced_v<detail::standard::parallel_unsequenced_policy> = true;
#undef INSONIFY_STANDARD_POLICIES
#endif

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
