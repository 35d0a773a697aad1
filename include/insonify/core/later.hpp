#ifndef INSONIFY_CORE_LATER_HPP
#define INSONIFY_CORE_LATER_HPP

#include <insonify/core/config.hpp>

/// For templates that work on what does not depend on their parameters, std::vectors above all. A constexpr function is
/// instantiated where a compiler reads a call of it, also in a template that nobody uses, and since C++20 those of
/// std::vector are constexpr. A tenth of what including this library costs clang is saved where types are known only
/// when the template is used:
///
///     INSONIFY_LAZY void grow() { later<Later>(values_).push_back(1); }
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
