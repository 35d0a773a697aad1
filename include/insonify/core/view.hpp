#ifndef INSONIFY_CORE_VIEW_HPP
#define INSONIFY_CORE_VIEW_HPP

#include <insonify/core/config.hpp>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <type_traits>

namespace insonify::inline INSONIFY_ABI {

/// Asks for the memory of a value long before it is looked at, where the compiler knows how. What calls it should be
/// inlined likewise: GCC takes a function that does nothing else for one that does nothing.
INSONIFY_FN INSONIFY_INLINE void prefetch(const void* value) {
#if defined(__GNUC__) && !defined(__CUDA_ARCH__)
    __builtin_prefetch(value);
#else
    static_cast<void>(value);
#endif
}

/// Pointer and count: what std::span is, but usable on a device and trivially copyable by contract.
///
/// It owns nothing; what it points to must outlive it.
template <class T>
struct view {
    T* first = nullptr;    ///< null where it is empty
    std::size_t count = 0; ///< elements

    view() = default;
    /// Of `number` elements from `first_element` on.
    INSONIFY_FN constexpr view(T* first_element, std::size_t number) : first{first_element}, count{number} {}

    /// Of any contiguous container (lvalue) whose elements are T.
    template <class Container>
        requires(!std::same_as<std::remove_cv_t<Container>, view>)
    &&requires(Container& c) {
        { std::data(c) } -> std::convertible_to<T*>;
        { std::size(c) } -> std::convertible_to<std::size_t>;
    }
    constexpr view(Container& container) : first{std::data(container)}, count{std::size(container)} {}

    /// What std::span has under the same names; the index is not checked.
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
#endif
