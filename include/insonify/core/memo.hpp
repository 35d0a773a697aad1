#ifndef INSONIFY_CORE_MEMO_HPP
#define INSONIFY_CORE_MEMO_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <concepts>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

namespace insonify::inline INSONIFY_ABI::detail {

/// Converts to T only, not to a base of T.
template <class T>
struct exactly {
    template <std::same_as<T> U>
    operator const U&() const;
};

/// T has an == of its own that is not a template. A type derived from one with == only inherits the comparison of its
/// base, which does not see the members that the derived type adds.
template <class T>
concept comparable = std::equality_comparable<T> &&
    (!std::is_class_v<T> || requires(const T& value, const exactly<T>& other) { value == other; });

/// A count or flag that becomes 0 in what it is moved from, as containers beside it become empty.
template <class T>
class cleared_by_move {
  public:
    cleared_by_move(T value = {}) : value_{value} {}
    cleared_by_move(const cleared_by_move&) = default;
    cleared_by_move(cleared_by_move&& other) noexcept : value_{std::exchange(other.value_, T{})} {}
    cleared_by_move& operator=(const cleared_by_move&) = default;
    cleared_by_move& operator=(cleared_by_move&& other) noexcept {
        value_ = std::exchange(other.value_, T{});
        return *this;
    }
    ~cleared_by_move() = default;

    operator const T&() const { return value_; }

  private:
    T value_;
};

/// Caches one value, computed from its inputs, until these change. Inputs that are not comparable count as changed.
template <class Value, class... Inputs>
class memo {
  public:
    /// The value for these inputs.
    /// @param compute  compute(value) overwrites the old value, whose memory it may reuse
    template <class Compute>
    const Value& operator()(const Compute& compute, const Inputs&... inputs) {
        constexpr bool compares = (comparable<Inputs> && ...);
        if constexpr (compares)
            if (valid_ && *inputs_ == std::tie(inputs...)) return value_;
        valid_ = false; // an exception in compute leaves no valid value
        compute(value_);
        if constexpr ((std::is_copy_assignable_v<Inputs> && ...))
            inputs_ = std::tie(inputs...); // in the same memory
        else
            inputs_.emplace(inputs...);
        valid_ = compares;
        return value_;
    }
    /// The value that was returned last.
    const Value& value() const { return value_; }

  private:
    std::optional<std::tuple<Inputs...>> inputs_{};
    Value value_{};
    cleared_by_move<bool> valid_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
