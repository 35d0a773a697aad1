#ifndef INSONIFY_TRACING_FIND_SLICE_FINDER_HPP
#define INSONIFY_TRACING_FIND_SLICE_FINDER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/large_array.hpp>
#include <insonify/core/view.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <algorithm>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

/// Lists in one flat array, by a counting sort: the items of each list are counted, then added. Keeps its memory.
template <class T>
class counted_lists {
  public:
    /// Empties the lists, of which there are now so many; the next calls are those of `count`.
    void clear(std::size_t lists) {
        ends_.resize(lists + 1);
        std::fill(ends_.begin(), ends_.end(), 0);
    }
    void count(std::size_t list) { ++ends_[list + 1]; }
    /// After the last `count`, before the first `add`.
    void make_room() {
        for (std::size_t list = 1; list < ends_.size(); ++list) ends_[list] += ends_[list - 1];
        items_.resize(ends_[ends_.size() - 1]);
    }
    /// Until the last item, an entry of `ends_` is where the next item of its list goes.
    void add(std::size_t list, const T& item) { items_[ends_[list]++] = item; }

    /// One list, after the last `add`.
    view<const T> operator[](std::size_t list) const {
        return {items_.data() + begin(list), ends_[list] - begin(list)};
    }
    /// The same, to be sorted.
    view<T> editable(std::size_t list) { return {items_.data() + begin(list), ends_[list] - begin(list)}; }
    /// Items in all lists.
    std::size_t size() const { return items_.size(); }

  private:
    std::size_t begin(std::size_t list) const { return list == 0 ? 0 : ends_[list - 1]; }

    large_array<std::size_t> ends_; // in `items_`
    large_array<T> items_;
};

/// The crossings of many lines with segments of slices, by line. Those behind the origin of their line have negative
/// distances.
using crossing_lists = counted_lists<crossing>;

/// Cuts the scene by the slices that contain the lines of a frame and distributes the segments over the lines. Keeps
/// its memory from frame to frame.
class slice_finder {
  public:
    static constexpr int block = static_cast<int>(lines_per_block);
    static_assert(block % simd_width == 0);

    /// Takes over the lines of a probe. @return false where they are not a `line_fan`: then nothing can be cut
    bool assign(const probe_lines& probe) { return fan_.assign(probe); }

    /// Chooses the objects to be cut, after `assign`: all, or those whose trees are out of date and those for which
    /// slicing is faster than rays:
    ///
    ///     1 + log2(faces)^2 / 3  <=  directions * (lines near the object + all lines / 20)
    ///
    /// Fitted to cubes and organs of 12 to 1.3 million faces, and 16 to 512 lines; a wrong choice costs a factor of at
    /// most 1.2, or of 2 for many crossings on few lines. It does not depend on other objects, so the echoes of one are
    /// bit-equal whatever these are.
    /// @param all         cut all objects
    /// @param directions  in which each line is traced
    /// @return whether any is cut
    bool choose(const scene_view& scene, const pose& at, view<const elevation_plane> planes, bool all,
                std::uint32_t directions) {
        slice_region slices;
        const slice_frame& frame = slices.frame = {at, planes, fan_.upright()};
        chosen_.resize(scene.objects.size());
        std::size_t cut = 0;
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            const object_view& one = scene.objects[i];
            chosen_[i] =
                all || !one.tree_is_current || (overlaps(slices, one.box) && worth_cutting(one, frame, directions));
            cut += chosen_[i];
        }
        leaves_rays_ = cut < chosen_.size();
        return cut > 0;
    }

    /// Where the crossings of a line come from, of which slices have found these.
    crossing_source source(view<const crossing> sliced) const { return {sliced, chosen_, leaves_rays_}; }
    /// Whether rays find the crossings with some objects.
    bool leaves_rays() const { return leaves_rays_; }

    const line_fan& fan() const { return fan_; }
    /// The segments of the last `cut`.
    const slice_cut& segments() const { return cut_; }

    /// Nanoseconds to find the crossings of a line and turn them into layers, roughly.
    float search_time() const {
        return 150 + 70 * static_cast<float>(of_blocks_.size()) / static_cast<float>(blocks() + 1);
    }

    /// Cuts the objects that were chosen, of the same scene: see `slice_cut::cut`.
    template <exec::policy Policy>
    void cut(const Policy& policy, const scene_view& scene, const pose& at, view<const elevation_plane> planes,
             float depth, const outer_lines& beyond = {}) {
        slices_ = planes.size();
        cut_.cut(policy, scene, view<const std::uint8_t>{chosen_}, fan_, at, planes, depth, beyond);
        const auto each_block = [&](const auto& visit) {
            cut_.for_each_segment([&](const cut_segment& segment) {
                for (std::size_t b = segment.first / block; b * block < segment.last; ++b) visit(b, segment);
            });
        };
        of_blocks_.clear(blocks());
        each_block([&](std::size_t b, const cut_segment&) { of_blocks_.count(b); });
        of_blocks_.make_room();
        each_block([&](std::size_t b, const cut_segment& segment) { of_blocks_.add(b, deep_segment{segment}); });
    }

    /// Finds where the lines from `begin` to before `begin + block` cross their segments.
    /// @param found  nearly sorted lists: see `list_of`
    void find_block(std::size_t begin, crossing_lists& found) {
        const view<deep_segment> segments = of_blocks_.editable(begin / block);
        std::sort(segments.begin(), segments.end());
        const auto each_segment = [&](const auto& visit) {
            for (const deep_segment& one : segments) {
                const cut_segment& segment = *one.segment;
                visit(segment, std::max<std::size_t>(segment.first, begin) - begin,
                      std::min<std::size_t>(segment.last, begin + block) - begin);
            }
        };
        found.clear(block * slices_);
        each_segment([&](const cut_segment& segment, std::size_t from, std::size_t to) {
            for (std::size_t line = from; line < to; ++line) found.count(list_of(line, segment.slice));
        });
        found.make_room();
        line_fan::neighbours lines[block / simd_width];
        for (std::size_t i = 0; i < block; i += simd_width) lines[i / simd_width] = fan_.from(begin + i);
        each_segment([&](const cut_segment& segment, std::size_t from, std::size_t to) {
            float distance[block];
            for (std::size_t i = 0; i < block; i += simd_width)
                store(lines[i / simd_width].intersect(segment.from, segment.to), distance + i);
            for (std::size_t line = from; line < to; ++line)
                found.add(list_of(line, segment.slice), {distance[line], segment.object, segment.primitive});
        });
    }
    /// Of a line in a slice, among the lists of its block.
    static std::size_t list_of(std::size_t line, std::uint32_t slice) {
        return std::size_t{slice} * block + line % block;
    }

  private:
    std::size_t blocks() const { return (fan_.size() + block - 1) / block; }

    bool worth_cutting(const object_view& one, const slice_frame& frame, std::uint32_t directions) const {
        const std::uint32_t near_lines = one.box.empty() ? 0 : lines_near(one.box, frame);
        const float doublings = near_lines == 0 ? 0.0F : std::log2(static_cast<float>(one.surface.faces.size()));
        const float rays = static_cast<float>(near_lines) + 0.05F * static_cast<float>(fan_.size());
        return 1 + 0.32F * doublings * doublings <= static_cast<float>(directions) * rays;
    }

    // An upper bound of the number of lines that intersect a box.
    std::uint32_t lines_near(const aabb& box, const slice_frame& frame) const {
        if (!fan_.is_wedge()) return fan_.size();
        std::uint32_t first = fan_.size(), last = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const vec2 place = frame.place_of({(corner & 1U) != 0 ? box.upper.x : box.lower.x,
                                               (corner & 2U) != 0 ? box.upper.y : box.lower.y,
                                               (corner & 4U) != 0 ? box.upper.z : box.lower.z});
            if (!fan_.parallel() && !(place.y > 0)) return fan_.size();
            if (!is_finite(place.x) || !is_finite(place.y)) return fan_.size();
            const std::uint32_t gap = fan_.gap(place);
            first = std::min(first, gap);
            last = std::max(last, gap);
        }
        return last - first;
    }

    std::size_t slices_ = 0;
    line_fan fan_;
    std::vector<std::uint8_t> chosen_; // of each object, by rank
    bool leaves_rays_ = true;
    slice_cut cut_;
    counted_lists<deep_segment> of_blocks_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
