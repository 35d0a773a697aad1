#ifndef INSONIFY_EXECUTION_ANY_POLICY_HPP
#define INSONIFY_EXECUTION_ANY_POLICY_HPP

#include <insonify/execution/for_each.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::exec {

/// Any policy, in one of two types. What is written for these is compiled once for all policies, so that they agree bit for
/// bit: compiled for each, the same sums may be rounded differently, since a compiler merges products into them as suits
/// what stands around.
/// @tparam Unsequenced  whether it asks for SIMD
template <bool Unsequenced>
class any_policy {
  public:
    /// Refers to the policy, which must outlive it.
    template <policy Policy>
    explicit any_policy(const Policy& policy) : policy_{&policy}, run_{&run<Policy>} {}

    /// As the policy itself.
    template <class Body>
    friend void for_each_index(const any_policy& policy, std::size_t count, const Body& body) {
        policy.run_(policy.policy_, count, &body,
                    [](const void* called, std::size_t i) { (*static_cast<const Body*>(called))(i); });
    }

  private:
    using call = void (*)(const void* body, std::size_t index);

    template <class Policy>
    static void run(const void* policy, std::size_t count, const void* body, call one) {
        for_each_index(*static_cast<const Policy*>(policy), count, [body, one](std::size_t i) { one(body, i); });
    }

    const void* policy_;
    void (*run_)(const void* policy, std::size_t count, const void* body, call one);
};
template <class Policy>
any_policy(const Policy&) -> any_policy<is_unsequenced_v<Policy>>;

template <>
inline constexpr bool is_unsequenced_v<any_policy<true>> = true;

} // namespace insonify::inline INSONIFY_ABI::exec
#endif
