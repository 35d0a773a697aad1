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

/// Work that threads share, nanoseconds: a thread that sleeps takes some 50 microseconds to come, so that less is done
/// sooner by one.
inline constexpr float worth_sharing = 80e3F;

/// Calls body(begin, end) for consecutive blocks of `block` indices, the last one shorter; on one thread where all of it
/// is less than `worth_sharing`.
/// @param nanoseconds  about what one index takes; 1e6F where nothing is known of it
template <class Policy, class Body>
void for_each_block(const Policy& policy, std::size_t count, std::size_t block, float nanoseconds, const Body& body) {
    const std::size_t blocks = (count + block - 1) / block;
    const bool alone = static_cast<float>(count) * nanoseconds < worth_sharing;
    const std::size_t together = alone && blocks > 0 ? blocks : 1; // that one call does
    for_each_index(policy, (blocks + together - 1) / together, [&](std::size_t first) {
        for (std::size_t i = first * together; i < (first + 1) * together; ++i)
            body(i * block, i + 1 < blocks ? (i + 1) * block : count);
    });
}

} // namespace insonify::inline INSONIFY_ABI::exec

namespace insonify::inline INSONIFY_ABI {
using exec::for_each_index;
}
#endif
