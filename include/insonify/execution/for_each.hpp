#ifndef INSONIFY_EXECUTION_FOR_EACH_HPP
#define INSONIFY_EXECUTION_FOR_EACH_HPP

#include <insonify/execution/policy.hpp>
#include <insonify/execution/thread_pool.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::exec {

/// `for_each_index(policy, count, body)` calls body(i) once for each i below count.
///
/// This is all that a policy is. To add one of your own, write this one function beside your type (it is found by
/// argument-dependent lookup), and specialise `is_unsequenced_v` where it asks for SIMD. The library cuts its work by
/// index, never by thread, so results do not depend on how a policy spreads the calls.
/// An exception of the body leaves the call, the one of the lowest index (the standard's policies terminate).
/// @throws usage_error  where more than 1024 participants were asked for
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
    thread_pool::instance().run(count, policy.participants, body);
}
template <class Body>
void for_each_index(const parallel_unsequenced_policy& policy, std::size_t count, const Body& body) {
    thread_pool::instance().run(count, policy.participants, body);
}
template <class StandardPolicy, class Body, class Own = typename own_policy<StandardPolicy>::type>
void for_each_index(const StandardPolicy&, std::size_t count, const Body& body) {
    for_each_index(Own{}, count, body);
}

/// Something to call, for the check below.
struct any_body {
    /// Does nothing.
    void operator()(std::size_t) const {}
};

/// A type for which `for_each_index` is found.
template <class Policy>
concept policy = requires(const Policy& p, const any_body& body) {
    for_each_index(p, std::size_t{0}, body);
};

/// Calls body(begin, end) for consecutive blocks of `block` indices, the last one shorter.
template <class Policy, class Body>
void for_each_block(const Policy& policy, std::size_t count, std::size_t block, const Body& body) {
    for_each_index(policy, (count + block - 1) / block, [&](std::size_t i) {
        const std::size_t begin = i * block;
        body(begin, begin + block < count ? begin + block : count);
    });
}

} // namespace insonify::inline INSONIFY_ABI::exec

namespace insonify::inline INSONIFY_ABI {
using exec::for_each_index;
}
#endif
