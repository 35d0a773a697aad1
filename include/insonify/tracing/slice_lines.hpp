#ifndef INSONIFY_TRACING_SLICE_LINES_HPP
#define INSONIFY_TRACING_SLICE_LINES_HPP

#include <insonify/scene/line_layers.hpp>
#include <insonify/scene/slice_cut.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Finds the crossings of all lines of a frame at once: cuts the scene by the slices that they lie in, and hands the
/// segments out to the lines. Keeps its memory from frame to frame.
class slice_lines {
  public:
    /// Lines that are handed their segments together, by one thread.
    static constexpr std::size_t block = 8;

    /// The segments of one block, by line and slice.
    struct block_segments {
        std::vector<std::uint32_t> end; ///< of each line and slice, in `segments`
        std::vector<const cut_segment*> segments;
    };

    /// @return false where the lines are no `line_fan`: then nothing is found
    template <transducer Probe>
    bool take(const Probe& probe) {
        return fan_.assign(probe);
    }

    /// Whether cutting the scene is faster than tracing rays; always where a tree waits.
    ///
    /// Cutting costs as much as 100 faces before the first one, and a slice goes through about 2 sqrt(faces) of an object;
    /// a ray costs about as much as 1.6 of them for each object that it comes near. So cutting pays for coarse meshes and
    /// many objects, rays for few lines and meshes finer than their spacing (where packets of rays are slower than single
    /// ones). Both grow alike with the number of slices.
    INSONIFY_LAZY bool pays(const scene& body, const pose& at) const {
        const float middle = 0;
        const slice_frame frame{at * fan_.upright(), {&middle, 1}};
        float rays = 0, cuts = 100;
        for (const object& one : body.objects()) {
            if (!one.tree_follows) return true;
            const std::uint32_t lines = one.box.empty() ? 0 : lines_near(one.box, frame);
            if (lines == 0) continue;
            rays += static_cast<float>(lines);
            cuts += 2 * std::sqrt(static_cast<float>(one.surface.faces.size()));
        }
        return cuts <= 1.6F * rays;
    }

    /// Cuts the scene by the slices of the probe that was taken; see `slice_cut::cut`.
    template <exec::policy Policy>
    void cut(const Policy& policy, const scene& body, const pose& at, view<const float> offsets, float reach) {
        body_ = &body;
        slices_ = offsets.size();
        reach_ = reach;
        cut_.cut(policy, body, fan_, at, offsets, reach);
        const std::size_t blocks = (fan_.size() + block - 1) / block;
        block_end_.assign(blocks + 1, 0);
        const auto each_block = [&](const auto& visit) {
            cut_.for_each_segment([&](const cut_segment& segment) {
                for (std::size_t b = segment.first / block; b * block < segment.last; ++b) visit(b, segment);
            });
        };
        each_block([&](std::size_t b, const cut_segment&) { ++block_end_[b + 1]; });
        for (std::size_t b = 0; b < blocks; ++b) block_end_[b + 1] += block_end_[b];
        of_blocks_.resize(block_end_[blocks]);
        each_block([&](std::size_t b, const cut_segment& segment) { of_blocks_[block_end_[b]++] = &segment; });
    }

    /// Sorts the segments of lines `begin` to `begin + block` by line and slice.
    INSONIFY_LAZY void start(std::size_t begin, block_segments& own) {
        const std::size_t b = begin / block;
        const std::size_t first = b == 0 ? 0 : block_end_[b - 1], last = block_end_[b];
        // By depth, once for the block: so that its lines get theirs nearly sorted.
        const auto at = [&](std::size_t i) { return of_blocks_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::sort(at(first), at(last), [](const cut_segment* one, const cut_segment* other) {
            return one->from.y + one->to.y < other->from.y + other->to.y;
        });
        own.end.assign(block * slices_ + 1, 0);
        const auto each_slot = [&](const auto& visit) {
            for (std::size_t i = first; i < last; ++i) {
                const cut_segment& segment = *of_blocks_[i];
                const std::size_t end = std::min<std::size_t>(segment.last, begin + block);
                for (std::size_t line = std::max<std::size_t>(segment.first, begin); line < end; ++line)
                    visit((line - begin) * slices_ + segment.slice, &segment);
            }
        };
        each_slot([&](std::size_t slot, const cut_segment*) { ++own.end[slot + 1]; });
        for (std::size_t slot = 0; slot < block * slices_; ++slot) own.end[slot + 1] += own.end[slot];
        own.segments.resize(own.end[block * slices_]);
        each_slot([&](std::size_t slot, const cut_segment* segment) { own.segments[own.end[slot]++] = segment; });
    }

    /// The same as `find_crossings` for the ray that leaves `origin`, in the world, as this line of this slice.
    INSONIFY_LAZY void find(std::size_t line, std::size_t slice, vec3 origin, const block_segments& own,
                            line_crossings& found) const {
        found.crossings.clear();
        found.inside.clear(body_->objects().size());
        const std::size_t slot = line % block * slices_ + slice;
        const line_fan::line& way = fan_[line];
        const object* one = nullptr; // of the segment before, for neighbours mostly belong to the same
        bool around = false;
        for (std::size_t i = slot == 0 ? 0 : own.end[slot - 1]; i < own.end[slot]; ++i) {
            const cut_segment& segment = *own.segments[i];
            const float distance = way.meet(segment.from, segment.to);
            if (!(distance >= 0)) continue;
            const object* owner = body_->objects().data() + segment.object;
            if (owner != one) around = owner->box.contains(origin), one = owner;
            if (around) found.inside.toggle(one->rank);
            if (distance <= reach_) found.crossings.push_back({distance, one->rank, segment.primitive});
        }
        if (!std::is_sorted(found.crossings.begin(), found.crossings.end()))
            std::sort(found.crossings.begin(), found.crossings.end());
    }

  private:
    // How many lines may meet a box.
    INSONIFY_LAZY std::uint32_t lines_near(const aabb& box, const slice_frame& frame) const {
        if (!fan_.is_wedge()) return fan_.size();
        std::uint32_t first = fan_.size(), last = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const vec2 place = frame.place_of({(corner & 1U) != 0 ? box.upper.x : box.lower.x,
                                               (corner & 2U) != 0 ? box.upper.y : box.lower.y,
                                               (corner & 4U) != 0 ? box.upper.z : box.lower.z});
            if (!fan_.parallel() && !(place.y > 0)) return fan_.size();
            first = std::min(first, fan_.gap(place));
            last = std::max(last, fan_.gap(place));
        }
        return last - first;
    }

    const scene* body_ = nullptr;
    std::size_t slices_ = 0;
    float reach_ = 0;
    line_fan fan_;
    slice_cut cut_;
    std::vector<std::size_t> block_end_;
    std::vector<const cut_segment*> of_blocks_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
