#ifndef INSONIFY_EXECUTION_POLICY_HPP
#define INSONIFY_EXECUTION_POLICY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/execution/thread_pool.hpp>
#include <cstddef>
#include <cstdint>
#include <utility>

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

/// One thread.
/// @tparam Unsequenced  whether loops over samples use SIMD; else they are scalar
template <bool Unsequenced>
struct serial_policy {};

/// Several threads.
/// @tparam Unsequenced  whether loops over samples use SIMD; else they are scalar
template <bool Unsequenced>
struct threads_policy {
    std::uint32_t participants = 0; ///< threads including the caller; 0: one per processor

    /// Runs on exactly n threads, the caller being one.
    [[nodiscard]] constexpr threads_policy threads(std::uint32_t n) const { return {n}; }
};

using sequenced_policy = serial_policy<false>;
using unsequenced_policy = serial_policy<true>;
using parallel_policy = threads_policy<false>;
using parallel_unsequenced_policy = threads_policy<true>;

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

/// The library's policy for a policy of std::execution; declared only.
void own_policy();
#if defined(INSONIFY_STANDARD_POLICIES)
namespace standard = INSONIFY_STANDARD_POLICIES;
exec::sequenced_policy own_policy(const standard::sequenced_policy&);
exec::parallel_policy own_policy(const standard::parallel_policy&);
exec::unsequenced_policy own_policy(const standard::unsequenced_policy&);
exec::parallel_unsequenced_policy own_policy(const standard::parallel_unsequenced_policy&);
#endif

} // namespace detail

#if defined(INSONIFY_STANDARD_POLICIES)
template <>
inline constexpr bool exec::is_unsequenced_v<detail::standard::unsequenced_policy> = true;
template <>
inline constexpr bool exec::is_unsequenced_v<detail::standard::parallel_unsequenced_policy> = true;
#undef INSONIFY_STANDARD_POLICIES
#endif

namespace exec {

/// `for_each_index(policy, count, body)` calls body(i) once for each i below count.
///
/// A policy is a type with this function. To add your own, write one overload in the namespace of your type, where
/// argument-dependent lookup finds it, and specialise `is_unsequenced_v` if it permits SIMD. The library partitions
/// work by index, never by thread, so results do not depend on how a policy distributes the calls.
/// If calls of the body throw, the exception of the lowest index is rethrown; the policies of std::execution terminate.
/// @throws usage_error  for more than 1024 threads
/// @{
template <bool Unsequenced, class Body>
void for_each_index(const serial_policy<Unsequenced>&, std::size_t count, const Body& body) {
    for (std::size_t i = 0; i < count; ++i) body(i);
}
template <bool Unsequenced, class Body>
void for_each_index(const threads_policy<Unsequenced>& policy, std::size_t count, const Body& body) {
    detail::thread_pool::instance().run(count, policy.participants, body);
}
template <class StandardPolicy, class Body, class Own = decltype(detail::own_policy(std::declval<StandardPolicy>()))>
void for_each_index(const StandardPolicy&, std::size_t count, const Body& body) {
    for_each_index(Own{}, count, body);
}
/// @}

/// Threads on which a policy calls a body at the same time, at most; memory that each of them needs is counted with it.
/// Of a policy of your own it is one per processor, unless you write an overload in the namespace of your type.
/// @{
template <bool Unsequenced>
std::uint32_t max_threads(const serial_policy<Unsequenced>&) {
    return 1;
}
template <bool Unsequenced>
std::uint32_t max_threads(const threads_policy<Unsequenced>& policy) {
    return policy.participants != 0 ? policy.participants : detail::thread_pool::instance().processors();
}
template <class Policy>
std::uint32_t max_threads(const Policy&) {
    if constexpr (requires(const Policy& p) { detail::own_policy(p); })
        return max_threads(decltype(detail::own_policy(std::declval<Policy>())){});
    else
        return max_threads(par);
}
/// @}

/// A type for which `for_each_index` is found.
template <class Policy>
concept policy = requires(const Policy& p, void (*body)(std::size_t index)) {
    for_each_index(p, std::size_t{0}, body);
};

} // namespace exec

using exec::for_each_index;

namespace detail {

/// Type-erased reference to a policy. Code written for it is compiled once for all policies that agree on SIMD, so
/// their results are bit-equal whatever a compiler contracts.
/// @tparam Unsequenced  whether the policy permits SIMD
template <bool Unsequenced>
class any_policy {
  public:
    /// Refers to the policy, which must outlive this object.
    template <exec::policy Policy>
    explicit any_policy(const Policy& policy) : policy_{&policy}, run_{&run<Policy>} {}

    friend void for_each_index(const any_policy& policy, std::size_t count,
                               const function_ref<void(std::size_t index)>& body) {
        policy.run_(policy.policy_, count, body);
    }

  private:
    template <class Policy>
    static void run(const void* policy, std::size_t count, const function_ref<void(std::size_t index)>& body) {
        for_each_index(*static_cast<const Policy*>(policy), count, body);
    }

    const void* policy_;
    void (*run_)(const void* policy, std::size_t count, const function_ref<void(std::size_t index)>& body);
};
template <class Policy>
any_policy(const Policy&) -> any_policy<exec::is_unsequenced_v<Policy>>;

} // namespace detail

template <>
inline constexpr bool exec::is_unsequenced_v<detail::any_policy<true>> = true;

namespace detail {

/// `exec::for_each_block`, compiled once.
inline void run_blocks(const any_policy<false>& policy, std::size_t count, std::size_t block, float nanoseconds,
                       const function_ref<void(std::size_t begin, std::size_t end)>& body) {
    constexpr float worth_sharing = 80e3F; // nanoseconds; to wake a thread takes about 50 microseconds
    const std::size_t blocks = (count + block - 1) / block;
    const bool alone = static_cast<float>(count) * nanoseconds < worth_sharing;
    const std::size_t together = alone && blocks > 0 ? blocks : 1; // blocks per call of the policy
    for_each_index(policy, (blocks + together - 1) / together, [&](std::size_t first) {
        for (std::size_t i = first * together; i < (first + 1) * together; ++i)
            body(i * block, i + 1 < blocks ? (i + 1) * block : count);
    });
}

} // namespace detail

namespace exec {

/// Calls body(begin, end) for consecutive blocks of `block` indices, the last one shorter. Runs on the calling thread
/// where the whole takes less than the time in which a sleeping thread wakes up.
/// @param nanoseconds  estimated time per index; 1e6F if unknown
template <class Policy, class Body>
void for_each_block(const Policy& policy, std::size_t count, std::size_t block, float nanoseconds, const Body& body) {
    detail::run_blocks(detail::any_policy<false>{policy}, count, block, nanoseconds, body);
}

/// Calls body(i) for each i below `count`, in such blocks.
template <class Policy, class Body>
void for_each_in_blocks(const Policy& policy, std::size_t count, std::size_t block, float nanoseconds,
                        const Body& body) {
    for_each_block(policy, count, block, nanoseconds, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

} // namespace exec

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
