#ifndef INSONIFY_TRACING_FIND_LINE_MEMORY_HPP
#define INSONIFY_TRACING_FIND_LINE_MEMORY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/scene/crossings.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Memory in which the layers of one line are found: grows until they fit.
struct line_memory {
    std::vector<crossing> crossings = std::vector<crossing>(64);
    std::vector<std::uint32_t> inside = std::vector<std::uint32_t>(16);
    std::vector<layer> layers = std::vector<layer>(32);

    /// Room for the crossings, without any.
    line_crossings found() { return {.room = crossings, .inside = {.ranks = inside}}; }
    void grow() {
        crossings.resize(2 * crossings.size());
        inside.resize(2 * inside.size());
        layers.resize(2 * layers.size());
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
