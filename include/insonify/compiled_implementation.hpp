/// The file that defines INSONIFY_IMPLEMENTATION compiles what `compiled.hpp` declares.
#if defined(INSONIFY_IMPLEMENTATION) && defined(INSONIFY_COMPILED) && !defined(INSONIFY_COMPILED_IMPLEMENTATION_HPP)
#define INSONIFY_COMPILED_IMPLEMENTATION_HPP

namespace insonify::inline INSONIFY_ABI {

INSONIFY_COMPILED_TEMPLATES()

} // namespace insonify::inline INSONIFY_ABI
#endif
