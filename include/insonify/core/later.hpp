#ifndef INSONIFY_CORE_LATER_HPP
#define INSONIFY_CORE_LATER_HPP

#include <insonify/core/config.hpp>

/// For templates that work on what does not depend on their parameters: vectors, and what holds them, spans, optionals. Such
/// a type is completed where a compiler reads the template, also one that nobody uses, and its constexpr functions, which
/// since C++20 those of std::vector are, are instantiated where it reads a call. Every file that includes this library
/// would pay for that. So types are told only when the template is used:
///
///     INSONIFY_LAZY void grow() { later<Later>(values_).push_back(1); }
///     INSONIFY_LAZY later_t<Later, std::span<float>> values() { return values_; }
namespace insonify::inline INSONIFY_ABI {

/// What `later_t` asks.
template <class Later, class T>
struct later_type {
    using type = T; ///< whatever Later is
};
/// T, as soon as Later is known.
template <class Later, class T>
using later_t = typename later_type<Later, T>::type;

/// The value itself, of a type that is told as soon as Later is known.
template <class Later, class T>
later_t<Later, T>& later(T& value) {
    return value;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
