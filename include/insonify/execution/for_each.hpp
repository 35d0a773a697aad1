#ifndef INSONIFY_EXECUTION_FOR_EACH_HPP
#define INSONIFY_EXECUTION_FOR_EACH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/policy.hpp>
#include <insonify/execution/thread_pool.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

namespace detail {
struct any_body {
    void operator()(std::size_t) const {}
};
} // namespace detail

namespace exec {

/// `for_each_index(policy, count, body)` calls body(i) once for each i below count.
///
/// A policy is a type with this function. To add your own, write one overload in the namespace of your type, where
/// argument-dependent lookup finds it, and specialise `is_unsequenced_v` if it permits SIMD. The library partitions
/// work by index, never by thread, so results do not depend on how a policy distributes the calls.
/// If calls of the body throw, the exception of the lowest index is rethrown; the policies of std::execution terminate.
/// @throws usage_error  for more than 1024 threads
/// @{
template <class Body>
void for_each_index(const sequenced_policy&, std::size_t count, const Body& body) {
    for (std::size_t i = 0; i < count; ++i) body(i);
}
template <class Body>
void for_each_index(const unsequenced_policy&, std::size_t count, const Body& body) {
    for (std::size_t i = 0; i < count; ++i) body(i);
}
template <class Body>
void for_each_index(const parallel_policy& policy, std::size_t count, const Body& body) {
    detail::thread_pool::instance().run(count, policy.participants, body);
}
template <class Body>
void for_each_index(const parallel_unsequenced_policy& policy, std::size_t count, const Body& body) {
    detail::thread_pool::instance().run(count, policy.participants, body);
}
template <class StandardPolicy, class Body, class Own = typename detail::own_policy<StandardPolicy>::type>
void for_each_index(const StandardPolicy&, std::size_t count, const Body& body) {
    for_each_index(Own{}, count, body);
}
/// @}

/// A type for which `for_each_index` is found.
template <class Policy>
concept policy = requires(const Policy& p, const detail::any_body& body) {
    for_each_index(p, std::size_t{0}, body);
};

/// Calls body(begin, end) for consecutive blocks of `block` indices, the last one shorter. Runs on the calling thread
/// where the whole takes less than the time in which a sleeping thread wakes up.
/// @param nanoseconds  estimated time per index; 1e6F if unknown
template <class Policy, class Body>
void for_each_block(const Policy& policy, std::size_t count, std::size_t block, float nanoseconds, const Body& body) {
    constexpr float worth_sharing = 80e3F; // nanoseconds; to wake a thread takes about 50 microseconds
    const std::size_t blocks = (count + block - 1) / block;
    const bool alone = static_cast<float>(count) * nanoseconds < worth_sharing;
    const std::size_t together = alone && blocks > 0 ? blocks : 1; // blocks per call of the policy
    for_each_index(policy, (blocks + together - 1) / together, [&](std::size_t first) {
        for (std::size_t i = first * together; i < (first + 1) * together; ++i)
            body(i * block, i + 1 < blocks ? (i + 1) * block : count);
    });
}

} // namespace exec

using exec::for_each_index;

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
