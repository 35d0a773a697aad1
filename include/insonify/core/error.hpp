#ifndef INSONIFY_CORE_ERROR_HPP
#define INSONIFY_CORE_ERROR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <stdexcept>

namespace insonify::inline INSONIFY_ABI {

/// A file could not be read or written, or its content is invalid. The message names the file and the line or object.
struct io_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An invalid mesh, pose or primitive. `validate` reports the defects of a mesh.
struct geometry_error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A setting that is out of range, or a call out of order, such as tracing a scene that was not built.
struct usage_error : std::logic_error {
    using std::logic_error::logic_error;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
