#ifndef INSONIFY_TRACING_FIND_SLICE_FINDER_HPP
#define INSONIFY_TRACING_FIND_SLICE_FINDER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/large_array.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/signal/kernel/elevation_plane.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI::detail {

/// Finds the crossings of all lines of a frame at once: cuts the scene by the slices that contain the lines and distributes
/// the segments over the lines. Keeps its memory from frame to frame.
class slice_finder {
  public:
    static constexpr int block = static_cast<int>(lines_per_block);
    static_assert(block % simd_width == 0);

    /// The crossings of the lines of one block, by slice and line, nearly sorted.
    struct block_crossings {
        std::vector<std::uint32_t> ends{}; ///< of each slice and line, in `crossings`
        std::vector<crossing> crossings{};
    };
    /// The same in flat arrays.
    struct block_view {
        view<const std::uint32_t> ends{};
        view<const crossing> crossings{};

        /// Calls visit(crossing) for every crossing in front of the probe, of a line in a slice.
        INSONIFY_VISITS
        template <class Visit>
        INSONIFY_FN void find(std::uint32_t line, std::uint32_t slice, const Visit& visit) const {
            const std::size_t slot = std::size_t{slice} * block + line % block;
            for (std::size_t i = slot == 0 ? 0 : ends[slot - 1]; i < ends[slot]; ++i)
                if (crossings[i].distance >= 0) visit(crossings[i]);
        }
    };

    /// Takes over the lines of a probe. @return false where they are not a `line_fan`: then nothing can be cut
    template <transducer Probe>
    bool assign(const Probe& probe) {
        return fan_.assign(probe);
    }

    /// Chooses the objects to be cut, after `assign`: all, or those whose trees are out of date and those for which slicing
    /// is faster than rays:
    ///
    ///     1 + log2(faces)^2 / 3  <=  lines near the object + all lines / 20        in units of a ray near the object
    ///
    /// Fitted to cubes and organs of 12 to 1.3 million faces, 1 to 64 of them, and 16 to 512 lines; a wrong choice costs a
    /// factor of at most 1.2, or of 2 for many crossings on few lines. The costs of both are proportional to the number of
    /// slices. The choice for an object does not depend on other objects, so its echoes are bit-equal whatever these are.
    /// @param all         cut all objects
    /// @param directions  in which each line is traced
    /// @return whether any is cut
    bool choose(const scene_view& scene, const pose& at, view<const detail::elevation_plane> planes, bool all,
                std::uint32_t directions) {
        const slice_frame frame{at, planes, fan_.upright()};
        chosen_.resize(scene.objects.size());
        std::size_t cut = 0;
        for (std::size_t i = 0; i < chosen_.size(); ++i) {
            const object_view& one = scene.objects[i];
            chosen_[i] =
                all || !one.tree_is_current || (near_slices(one.box, frame) && worth_cutting(one, frame, directions));
            cut += chosen_[i];
        }
        leaves_rays_ = cut < chosen_.size();
        return cut > 0;
    }

    /// Whether an object is cut; rays find the crossings of the others.
    view<const std::uint8_t> chosen() const { return chosen_; }
    /// Whether there are others.
    bool leaves_rays() const { return leaves_rays_; }

    const line_fan& fan() const { return fan_; }
    /// The segments of the last `cut`.
    const slice_cut& segments() const { return cut_; }

    /// Nanoseconds to find the crossings of a line and turn them into layers, roughly.
    float search_time() const {
        const auto blocks = static_cast<float>(block_end_.size());
        return 150 + 70 * static_cast<float>(of_blocks_.size()) / blocks;
    }

    /// Cuts the objects that were chosen, of the same scene: see `slice_cut::cut`.
    template <exec::policy Policy>
    void cut(const Policy& policy, const scene_view& scene, const pose& at, view<const detail::elevation_plane> planes,
             float depth, bool keep_all, const outer_lines& beyond = {}) {
        slices_ = planes.size();
        cut_.cut(policy, scene, view<const std::uint8_t>{chosen_}, fan_, at, planes, depth, keep_all, beyond);
        const std::size_t blocks = (fan_.size() + block - 1) / block;
        block_end_.resize(blocks + 1);
        std::fill(block_end_.begin(), block_end_.end(), 0);
        const auto each_block = [&](const auto& visit) {
            cut_.for_each_segment([&](const cut_segment& segment) {
                for (std::size_t b = segment.first / block; b * block < segment.last; ++b) visit(b, segment);
            });
        };
        each_block([&](std::size_t b, const cut_segment&) { ++block_end_[b + 1]; });
        for (std::size_t b = 0; b < blocks; ++b) block_end_[b + 1] += block_end_[b];
        of_blocks_.resize(block_end_[blocks]);
        each_block([&](std::size_t b, const cut_segment& segment) {
            of_blocks_[block_end_[b]++] = {segment.from.y + segment.to.y, &segment};
        });
    }

    /// Finds where the lines from `begin` to before `begin + block` cross their segments.
    void find_block(std::size_t begin, block_crossings& own) {
        const std::size_t b = begin / block;
        block_segment* const first = of_blocks_.data() + (b == 0 ? 0 : block_end_[b - 1]);
        block_segment* const last = of_blocks_.data() + block_end_[b];
        // By depth, once for the block, so that the crossings of each line are nearly sorted.
        std::sort(first, last,
                  [](const block_segment& one, const block_segment& other) { return one.depth < other.depth; });

        own.ends.assign(block * slices_ + 1, 0);
        const auto each_segment = [&](const auto& visit) {
            for (auto i = first; i != last; ++i) {
                const cut_segment& segment = *i->segment;
                visit(segment, std::max<std::size_t>(segment.first, begin) - begin,
                      std::min<std::size_t>(segment.last, begin + block) - begin);
            }
        };
        each_segment([&](const cut_segment& segment, std::size_t from, std::size_t to) {
            for (std::size_t line = from; line < to; ++line) ++own.ends[std::size_t{segment.slice} * block + line + 1];
        });
        for (std::size_t slot = 0; slot < block * slices_; ++slot) own.ends[slot + 1] += own.ends[slot];
        own.crossings.resize(own.ends[block * slices_]);
        line_fan::neighbours<simd_width> lines[block / simd_width];
        for (std::size_t i = 0; i < block; i += simd_width) lines[i / simd_width] = fan_.from<simd_width>(begin + i);
        each_segment([&](const cut_segment& segment, std::size_t from, std::size_t to) {
            float distance[block];
            for (std::size_t i = 0; i < block; i += simd_width)
                store(lines[i / simd_width].intersect(segment.from, segment.to), distance + i);
            std::uint32_t* const end = own.ends.data() + std::size_t{segment.slice} * block;
            for (std::size_t line = from; line < to; ++line)
                own.crossings[end[line]++] = {distance[line], segment.object, segment.primitive};
        });
    }

    block_view view_of(const block_crossings& own) const { return {own.ends, own.crossings}; }

  private:
    // A segment that lines of a block cross.
    struct block_segment {
        float depth = 0; // the sum of its ends'
        const cut_segment* segment = nullptr;
    };

    bool worth_cutting(const object_view& one, const slice_frame& frame, std::uint32_t directions) const {
        const std::uint32_t near_lines = one.box.empty() ? 0 : lines_near(one.box, frame);
        const float doublings = near_lines == 0 ? 0.0F : std::log2(static_cast<float>(one.surface.faces.size()));
        const float rays = static_cast<float>(near_lines) + 0.05F * static_cast<float>(fan_.size());
        return 1 + 0.32F * doublings * doublings <= static_cast<float>(directions) * rays;
    }

    // Whether a box may reach into one of the slices.
    static bool near_slices(const aabb& box, const slice_frame& frame) {
        if (box.empty()) return false;
        for (std::uint32_t i = 0; i < frame.count; ++i) {
            const float height = dot(frame.normal[i], box.centre() - frame.origin) - frame.height[i];
            const float half_thickness = dot(abs(frame.normal[i]), 0.5F * box.size());
            if (std::fabs(height) <= 1.001F * half_thickness + 1e-5F * length(frame.origin) + 1e-9F) return true;
        }
        return false;
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
    large_array<std::size_t> block_end_; // where the segments of each block end, in `of_blocks_`
    large_array<block_segment> of_blocks_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
