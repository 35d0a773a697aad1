#ifndef INSONIFY_CORE_VIEW_HPP
#define INSONIFY_CORE_VIEW_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <type_traits>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Prefetches a value into the cache. Callers must be inlined too: GCC discards calls of a function that does nothing
/// else.
INSONIFY_FN INSONIFY_INLINE void prefetch(const void* value) {
#if defined(__GNUC__) && !defined(__CUDA_ARCH__)
    __builtin_prefetch(value);
#else
    static_cast<void>(value);
#endif
}

template <class Signature>
class function_ref;

/// A reference to an object with operator(), which must outlive it: for parameters, so that what calls them is compiled
/// once.
template <class Result, class... Arguments>
class function_ref<Result(Arguments...)> {
  public:
    template <class Function>
    function_ref(const Function& function)
        : function_{&function}, call_{[](const void* called, Arguments... arguments) -> Result {
              return (*static_cast<const Function*>(called))(arguments...);
          }} {}

    Result operator()(Arguments... arguments) const { return call_(function_, arguments...); }

  private:
    const void* function_;
    Result (*call_)(const void*, Arguments...);
};

} // namespace detail

/// A pointer and a count, like std::span, but trivially copyable and usable in device code. It does not own the
/// elements.
template <class T>
struct view {
    T* first = nullptr;    ///< null if empty
    std::size_t count = 0; ///< number of elements

    view() = default;
    /// A view of `number` elements from `first_element` on.
    INSONIFY_FN constexpr view(T* first_element, std::size_t number) : first{first_element}, count{number} {}

    /// A view of a contiguous container of T; not of a temporary.
    template <class Container>
        requires(!std::same_as<std::remove_cv_t<Container>, view>)
    &&requires(Container& c) {
        { std::data(c) } -> std::convertible_to<T*>;
        { std::size(c) } -> std::convertible_to<std::size_t>;
    }
    constexpr view(Container& container) : first{std::data(container)}, count{std::size(container)} {}

    /// As in std::span; the index is not checked.
    /// @{
    INSONIFY_FN constexpr T& operator[](std::size_t index) const { return first[index]; }
    INSONIFY_FN constexpr T* begin() const { return first; }
    INSONIFY_FN constexpr T* end() const { return first + count; }
    INSONIFY_FN constexpr T* data() const { return first; }
    INSONIFY_FN constexpr std::size_t size() const { return count; }
    INSONIFY_FN constexpr bool empty() const { return count == 0; }
    /// @}
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
