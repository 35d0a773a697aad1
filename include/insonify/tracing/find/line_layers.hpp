#ifndef INSONIFY_TRACING_FIND_LINE_LAYERS_HPP
#define INSONIFY_TRACING_FIND_LINE_LAYERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/scene/layers.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Where the crossings of a line come from: slices have found those with some objects, rays find those with the others.
struct crossing_source {
    view<const crossing> sliced{};  ///< at any distances
    view<const std::uint8_t> cut{}; ///< of each object, by rank, whether slices have cut it; empty: none
    bool rays = true;               ///< whether there are others

    /// Calls visit(crossing) for those in front of the origin.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each(const crossing_collector& collector, const Visit& visit) const {
        for (const crossing& one : sliced)
            if (one.distance >= 0) visit(one);
        if (rays) collector.trace(cut, visit);
    }
};

/// Memory of fixed capacity in which the layers of one line are found.
struct line_room {
    line_crossings found{};            ///< its crossings, and the objects that contain its origin
    view<layer> layers{};              ///< room for its layers
    view<std::uint32_t> behind_face{}; ///< room for ranks of objects
};

/// The same on the stack, for most lines.
struct short_line_memory {
    static constexpr std::size_t size = 8;
    crossing crossings[2 * size];
    std::uint32_t inside[size], behind_face[size];
    layer layers[size];

    line_room room() {
        return {
            {.room = {crossings, 2 * size}, .inside = {.ranks = {inside, size}}}, {layers, size}, {behind_face, size}};
    }
};

/// The same on the heap: allocated when it is first needed, and grows until the line fits.
struct line_memory {
    std::vector<crossing> crossings{};
    std::vector<std::uint32_t> inside{}, behind_face{};
    std::vector<layer> layers{};

    line_room room() { return {{.room = crossings, .inside = {.ranks = inside}}, layers, behind_face}; }

    void grow() {
        const std::size_t size = std::max(short_line_memory::size, 2 * layers.size());
        crossings.resize(2 * size);
        inside.resize(size);
        behind_face.resize(size);
        layers.resize(size);
    }

    /// Calls attempt(room), in larger and larger memory, until it returns true.
    template <class Attempt>
    void fit(const Attempt& attempt) {
        if (layers.empty()) grow();
        while (!attempt(room())) grow();
    }
    /// The same, first in memory of the caller, until a line has not fitted there.
    template <class Attempt>
    void fit(const line_room& first, const Attempt& attempt) {
        if (layers.empty() && attempt(first)) return;
        fit(attempt);
    }
};

/// What lies along a line, in the memory in which it was found.
struct found_line {
    view<const layer> layers{}; ///< none: the memory was too small
    view<const std::uint32_t>
        behind_face{}; ///< ranks of the objects that contain its origin, behind the face; ascending
};

/// Finds what lies along a straight line.
/// @param max_depth  how far it is followed, metres
/// @param incident   whether to compute how it intersects surfaces: see `stack_layers`
INSONIFY_FN inline found_line find_line(const scene_view& scene, const line_frame& line, float max_depth, bool incident,
                                        const crossing_source& from, line_room room) {
    room.found.clear();
    const crossing_collector collector{scene, {line.origin, line.path(), 0, max_depth}, max_depth, room.found};
    from.for_each(collector, [&](const crossing& one) { collector.add(one); });
    room.found.sort();
    if (!room.found.complete()) return {};
    media_stack behind_face{.ranks = room.behind_face};
    behind_face.assign(room.found.inside);
    for (const crossing& one : room.found.sorted()) {
        if (one.distance > touching_distance) break;
        behind_face.toggle(one.rank);
    }
    if (behind_face.overflow) return {};
    return {stack_layers(scene, line, max_depth, room.found, room.layers, incident),
            {behind_face.ranks.data(), behind_face.count}};
}

class layer_finder;

/// Number of lines in a block of work.
inline constexpr std::uint32_t lines_per_block = 8;

constexpr std::size_t blocks_of(std::uint32_t lines) { return (lines + lines_per_block - 1) / lines_per_block; }

/// The layers of a block of lines, by line and plane. Keeps its memory.
class layer_block {
  public:
    /// @param lines  that are then added
    void clear(std::size_t lines) {
        lines_.clear();
        layers_.clear();
        objects_.clear();
        lines_.reserve(lines);
        layers_.reserve(4 * lines);
    }
    /// Adds the next line.
    void add(const line_frame& frame, view<const layer> layers, view<const std::uint32_t> objects) {
        lines_.push_back({frame, layers_.size(), layers.size(), objects_.size(), objects.size()});
        layers_.insert(layers_.end(), layers.begin(), layers.end());
        objects_.insert(objects_.end(), objects.begin(), objects.end());
    }

    view<const layer> layers(std::size_t number) const {
        const line& own = lines_[number];
        return {layers_.data() + own.first_layer, own.layers};
    }
    view<const std::uint32_t> objects(std::size_t number) const {
        const line& own = lines_[number];
        return {objects_.data() + own.first_object, own.objects};
    }
    const line_frame& frame(std::size_t number) const { return lines_[number].frame; }

  private:
    struct line {
        line_frame frame;
        std::size_t first_layer, layers, first_object, objects;
    };

    std::vector<line> lines_{};
    std::vector<layer> layers_{};
    std::vector<std::uint32_t> objects_{}; // ranks
};

} // namespace detail

/// What lies along every line of every elevation plane, as `find_layers` found it. A value: the scene may change
/// afterwards.
///
///     const line_layers found = find_layers(exec::par_unseq, body, probe, at, {.depth = 40_mm, .planes = 5});
///     float in_bone = 0; // metres, on line 32 of the slice plane
///     for (const layer& one : found(32))
///         if (one.object == static_cast<label_id>(bone)) in_bone += one.end - one.begin;
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
        return block_of(line).layers(number_in_block(line, plane));
    }
    /// Where a line runs, in the world: `frame(line).at(one.begin)` is the point at which a layer begins.
    const line_frame& frame(std::uint32_t line, std::uint32_t plane = 0) const {
        return block_of(line).frame(number_in_block(line, plane));
    }

    /// Ranks (numbers in `scene_view::objects`) of the objects that contain the origin of a line, just behind the face;
    /// ascending.
    view<const std::uint32_t> objects_behind_face(std::uint32_t line, std::uint32_t plane) const {
        return block_of(line).objects(number_in_block(line, plane));
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
    std::size_t number_in_block(std::uint32_t line, std::uint32_t plane) const {
        return std::size_t{line % detail::lines_per_block} * planes + plane;
    }

    std::vector<detail::layer_block> blocks_{};
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
