#ifndef INSONIFY_EXECUTION_ANY_POLICY_HPP
#define INSONIFY_EXECUTION_ANY_POLICY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/for_each.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

/// Type-erased reference to a policy. Code written for it is compiled once for all policies that agree on SIMD, so
/// their results are bit-equal; separate instantiations may differ, since a compiler contracts a * b + c differently
/// from one to the next.
/// @tparam Unsequenced  whether the policy permits SIMD
template <bool Unsequenced>
class any_policy {
  public:
    /// Refers to the policy, which must outlive this object.
    template <exec::policy Policy>
    explicit any_policy(const Policy& policy) : policy_{&policy}, run_{&run<Policy>} {}

    /// Forwards to the policy.
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
any_policy(const Policy&) -> any_policy<exec::is_unsequenced_v<Policy>>;

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {
template <>
inline constexpr bool exec::is_unsequenced_v<detail::any_policy<true>> = true;
}

#include <insonify/core/restore_macros.hpp>

#endif
