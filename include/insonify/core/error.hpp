#ifndef INSONIFY_CORE_ERROR_HPP
#define INSONIFY_CORE_ERROR_HPP

#include <insonify/core/config.hpp>
#include <stdexcept>

namespace insonify::inline INSONIFY_ABI {

/// A file could not be read or written, or what it holds makes no sense. The sentence names file and line or object.
struct io_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A mesh, a pose or a primitive that cannot be used. `validate` tells more about a mesh.
struct geometry_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A setting out of its range, or a call out of order (tracing a scene that was not built).
struct usage_error : std::logic_error {
    using std::logic_error::logic_error;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
