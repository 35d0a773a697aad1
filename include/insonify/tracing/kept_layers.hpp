#ifndef INSONIFY_TRACING_KEPT_LAYERS_HPP
#define INSONIFY_TRACING_KEPT_LAYERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The layers of the lines of a block, kept from one pass over the lines to the next.
class kept_layers {
  public:
    void clear() {
        layers_.clear();
        ends_.clear();
    }
    void add(view<const layer> of_line) {
        layers_.insert(layers_.end(), of_line.begin(), of_line.end());
        ends_.push_back(static_cast<std::uint32_t>(layers_.size()));
    }

    /// The same in flat arrays. Trivially copyable.
    struct kept_view {
        view<const layer> layers{};
        view<const std::uint32_t> ends{}; ///< of each line, in `layers`

        INSONIFY_FN bool empty() const { return ends.empty(); }
        /// The layers that were added as this number.
        INSONIFY_FN view<const layer> operator[](std::size_t number) const {
            const std::uint32_t begin = number == 0 ? 0 : ends[number - 1];
            return {layers.data() + begin, ends[number] - begin};
        }
    };
    kept_view view_of() const { return {layers_, ends_}; }

  private:
    std::vector<layer> layers_{};
    std::vector<std::uint32_t> ends_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
