#ifndef INSONIFY_TRACING_FIND_LINE_LAYERS_HPP
#define INSONIFY_TRACING_FIND_LINE_LAYERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/core/error.hpp>
#include <insonify/scene/layers.hpp>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

class layer_finder;

/// Number of lines in a block of work.
inline constexpr std::uint32_t lines_per_block = 8;

constexpr std::size_t blocks_of(std::uint32_t lines) { return (lines + lines_per_block - 1) / lines_per_block; }

/// The layers of a block of lines, by line and plane. Keeps its memory.
struct layer_block {
    struct line {
        line_frame frame{};
        std::size_t first_layer = 0, layers = 0;
        std::size_t first_object = 0, objects = 0; ///< that contain its origin, behind the face

        /// Of a `frame_lines`, made where it lies: a copy would wait for what has just been written.
        template <class Lines>
        line(const Lines& of, std::uint32_t number, std::uint32_t plane) : frame{of.line(number, plane)} {}
    };

    std::vector<line> lines{};
    std::vector<layer> layers{};
    std::vector<std::uint32_t> objects{}; ///< ranks
};

} // namespace detail

/// What lies along every line of every elevation plane, as `find_layers` found it. A value: the scene may change
/// afterwards.
class line_layers {
  public:
    std::uint32_t lines = 0;     ///< of the probe
    std::uint32_t planes = 0;    ///< elevation planes: the slice plane, then pairs to both sides of it
    std::vector<medium> media{}; ///< of the scene, the background first: what `layer::medium` is an index of

    /// A copy is a value of its own; nothing is left of what is moved from.
    /// @{
    line_layers() = default;
    line_layers(const line_layers&) = default;
    line_layers& operator=(const line_layers&) = default;
    line_layers(line_layers&& other) noexcept { *this = std::move(other); }
    line_layers& operator=(line_layers&& other) noexcept {
        lines = std::exchange(other.lines, 0);
        planes = std::exchange(other.planes, 0);
        media = std::exchange(other.media, {});
        blocks_ = std::exchange(other.blocks_, {});
        return *this;
    }
    /// @}

    /// From the probe face on, without gaps: each layer begins where the one before ends. The numbers are not checked.
    view<const layer> operator()(std::uint32_t line, std::uint32_t plane = 0) const {
        const detail::layer_block::line& own = line_of(line, plane);
        return {block_of(line).layers.data() + own.first_layer, own.layers};
    }
    /// Where a line runs, in the world: `frame(line).at(one.begin)` is the point at which a layer begins.
    const line_frame& frame(std::uint32_t line, std::uint32_t plane = 0) const { return line_of(line, plane).frame; }

    /// Ranks (numbers in `scene_view::objects`) of the objects that contain the origin of a line, just behind the face;
    /// ascending.
    view<const std::uint32_t> objects_behind_face(std::uint32_t line, std::uint32_t plane) const {
        const detail::layer_block::line& own = line_of(line, plane);
        return {block_of(line).objects.data() + own.first_object, own.objects};
    }

  private:
    friend class detail::layer_finder;

    // Forgets all lines, and keeps their memory: those of each block are then to be added, for each line those of all
    // planes. Until whoever adds them sets `lines`, there are none: an exception may end the frame.
    void begin(std::uint32_t new_lines, std::uint32_t new_planes, view<const medium> of_scene) {
        lines = 0;
        planes = new_planes;
        media.assign(of_scene.begin(), of_scene.end());
        if (blocks_.size() < detail::blocks_of(new_lines)) blocks_.resize(detail::blocks_of(new_lines));
    }
    detail::layer_block& block_at(std::size_t line) { return blocks_[line / detail::lines_per_block]; }

    const detail::layer_block& block_of(std::uint32_t line) const { return blocks_[line / detail::lines_per_block]; }
    const detail::layer_block::line& line_of(std::uint32_t line, std::uint32_t plane) const {
        return block_of(line).lines[std::size_t{line % detail::lines_per_block} * planes + plane];
    }

    std::vector<detail::layer_block> blocks_{};
};

namespace detail {

/// @throws usage_error  for layers that are not those of a probe with so many lines
inline void check_layers(const line_layers& found, std::uint32_t lines, const char* caller) {
    if (found.lines != lines)
        throw usage_error{caller,      ": the layers have ",
                          found.lines, " lines and the probe ",
                          lines,       "; give those that find_layers finds for this probe"};
}

} // namespace detail

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
