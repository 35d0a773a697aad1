#ifndef INSONIFY_EXECUTION_POLICY_HPP
#define INSONIFY_EXECUTION_POLICY_HPP

#include <insonify/core/config.hpp>
#include <cstdint>
#include <type_traits>

#if __has_include(<pstl/execution_defs.h>)
#include <pstl/execution_defs.h> // libstdc++: the policy types alone; <execution> itself costs seconds and pulls in TBB
#elif __has_include(<execution>)
#include <execution>
#endif

namespace insonify::inline INSONIFY_ABI::exec {

/// One thread, no SIMD.
struct sequenced_policy {};

/// One thread, SIMD across the elements of a loop.
struct unsequenced_policy {};

/// Threads, no SIMD.
struct parallel_policy {
    std::uint32_t participants = 0; ///< the caller included; 0: one a processor

    /// Exactly n participants, the caller being one.
    [[nodiscard]] constexpr parallel_policy threads(std::uint32_t n) const { return {n}; }
};

/// Threads and SIMD.
struct parallel_unsequenced_policy {
    std::uint32_t participants = 0; ///< the caller included; 0: one a processor

    /// Exactly n participants, the caller being one.
    [[nodiscard]] constexpr parallel_unsequenced_policy threads(std::uint32_t n) const { return {n}; }
};

inline constexpr sequenced_policy seq{};
inline constexpr parallel_policy par{};
inline constexpr unsequenced_policy unseq{};
inline constexpr parallel_unsequenced_policy par_unseq{};

/// Whether a policy asks for SIMD. Specialise it for a policy of your own that does.
template <class Policy>
inline constexpr bool is_unsequenced_v = false;
template <>
inline constexpr bool is_unsequenced_v<unsequenced_policy> = true;
template <>
inline constexpr bool is_unsequenced_v<parallel_unsequenced_policy> = true;

/// The std::execution objects stand for the same four words; `own_policy` names ours for one of theirs.
#if __has_include(<pstl/execution_defs.h>)
namespace standard = __pstl::execution;
#define INSONIFY_STANDARD_POLICIES
#elif defined(__cpp_lib_execution)
namespace standard = std::execution;
#define INSONIFY_STANDARD_POLICIES
#endif

template <class Policy>
struct own_policy;

#if defined(INSONIFY_STANDARD_POLICIES)
#undef INSONIFY_STANDARD_POLICIES
template <>
struct own_policy<standard::sequenced_policy> {
    using type = sequenced_policy;
};
template <>
struct own_policy<standard::parallel_policy> {
    using type = parallel_policy;
};
template <>
struct own_policy<standard::unsequenced_policy> {
    using type = unsequenced_policy;
};
template <>
struct own_policy<standard::parallel_unsequenced_policy> {
    using type = parallel_unsequenced_policy;
};
template <>
inline constexpr bool is_unsequenced_v<standard::unsequenced_policy> = true;
template <>
inline constexpr bool is_unsequenced_v<standard::parallel_unsequenced_policy> = true;
#endif

} // namespace insonify::inline INSONIFY_ABI::exec
#endif
