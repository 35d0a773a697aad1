#ifndef INSONIFY_TRACING_SLICE_LINES_HPP
#define INSONIFY_TRACING_SLICE_LINES_HPP

#include <insonify/bvh/large_array.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/scene/line_layers.hpp>
#include <insonify/scene/slice_cut.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Finds the crossings of all lines of a frame at once: cuts the scene by the slices that they lie in, and hands the
/// segments out to the lines. Keeps its memory from frame to frame.
class slice_lines {
  public:
    /// Lines that are handed their segments together, by one thread.
    static constexpr int block = 8;
    static_assert(block % simd_width == 0);

    /// The crossings of the lines of one block, by slice and line, nearly ascending.
    struct block_crossings {
        std::vector<std::uint32_t> end; ///< of each slice and line, in `crossings`
        std::vector<crossing> crossings;
    };

    /// @return false where the lines are no `line_fan`: then nothing is found
    template <transducer Probe>
    bool take(const Probe& probe) {
        return fan_.assign(probe);
    }

    /// Chooses the objects to be cut, after `take`: all, or those whose trees wait and those of which rays would find the
    /// crossings later:
    ///
    ///     1 + log2(faces)^2 / 3  <=  lines near the object + all lines / 20        in units of a ray that comes near
    ///
    /// Fitted to cubes and organs of 12 to 1.3 million faces, 1 to 64 of them, and 16 to 512 lines: where it errs, the
    /// slower way takes up to 1.2 times the time of the faster, but for many crossings on a few lines, which slices would
    /// find twice as fast. Both grow alike with the number of slices. Nothing else in the scene matters to the choice, so
    /// that what comes and goes changes no bit of its neighbours.
    /// @return whether any is cut
    INSONIFY_LAZY bool choose(const scene& body, const pose& at, bool all) {
        const float middle = 0;
        const slice_frame frame{at * fan_.upright(), {&middle, 1}};
        chosen_.assign(body.objects().size(), 1);
        left_.clear();
        for (std::uint32_t i = 0; i < chosen_.size() && !all; ++i) {
            const object& one = body.objects()[i];
            if (!one.tree_follows) continue;
            const std::uint32_t near_ones = one.box.empty() ? 0 : lines_near(one.box, frame);
            const float doublings = near_ones == 0 ? 0.0F : std::log2(static_cast<float>(one.surface.faces.size()));
            const float rays = static_cast<float>(near_ones) + 0.05F * static_cast<float>(fan_.size());
            if (1 + 0.32F * doublings * doublings <= rays) continue;
            chosen_[i] = 0;
            left_.push_back(i);
        }
        return left_.size() < chosen_.size();
    }

    /// The objects that are not cut: indices into `scene::objects`.
    INSONIFY_LAZY view<const std::uint32_t> left_to_rays() const { return left_; }

    /// About what the crossings of a line take to be found and made layers of, where they were cut; nanoseconds.
    INSONIFY_LAZY float search_time() const {
        const auto blocks = static_cast<float>(block_end_.size());
        return 150 + 70 * static_cast<float>(of_blocks_.size()) / blocks;
    }

    /// Cuts the objects that were chosen, of the same scene, by the slices of the probe that was taken; see
    /// `slice_cut::cut`.
    template <exec::policy Policy>
    void cut(const Policy& policy, const scene& body, const pose& at, view<const float> offsets, float reach) {
        body_ = &body;
        slices_ = offsets.size();
        reach_ = reach;
        cut_.cut(policy, body, view<const std::uint8_t>{chosen_}, fan_, at, offsets, reach);
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

    /// Finds where lines `begin` to `begin + block` cross their segments.
    INSONIFY_LAZY void start(std::size_t begin, block_crossings& own) {
        const std::size_t b = begin / block;
        waiting* const first = of_blocks_.data() + (b == 0 ? 0 : block_end_[b - 1]);
        waiting* const last = of_blocks_.data() + block_end_[b];
        // By depth, once for the block: so that its lines get theirs nearly sorted.
        std::sort(first, last, [](const waiting& one, const waiting& other) { return one.depth < other.depth; });

        own.end.assign(block * slices_ + 1, 0);
        const auto each_segment = [&](const auto& visit) {
            for (auto i = first; i != last; ++i) {
                const cut_segment& segment = *i->segment;
                visit(segment, std::max<std::size_t>(segment.first, begin) - begin,
                      std::min<std::size_t>(segment.last, begin + block) - begin);
            }
        };
        each_segment([&](const cut_segment& segment, std::size_t from, std::size_t to) {
            for (std::size_t line = from; line < to; ++line) ++own.end[std::size_t{segment.slice} * block + line + 1];
        });
        for (std::size_t slot = 0; slot < block * slices_; ++slot) own.end[slot + 1] += own.end[slot];
        own.crossings.resize(own.end[block * slices_]);
        line_fan::neighbours<simd_width> lines[block / simd_width];
        for (std::size_t i = 0; i < block; i += simd_width) lines[i / simd_width] = fan_.from<simd_width>(begin + i);
        each_segment([&](const cut_segment& segment, std::size_t from, std::size_t to) {
            float distance[block];
            for (std::size_t i = 0; i < block; i += simd_width)
                store(lines[i / simd_width].meet(segment.from, segment.to), distance + i);
            const std::uint32_t rank = body_->objects()[segment.object].rank;
            std::uint32_t* const end = own.end.data() + std::size_t{segment.slice} * block;
            for (std::size_t line = from; line < to; ++line)
                own.crossings[end[line]++] = {distance[line], rank, segment.primitive};
        });
    }

    /// The same as `find_crossings` in the chosen objects for the ray that leaves `origin`, in the world, as this line of
    /// this slice; to be sorted.
    INSONIFY_LAZY void find(std::size_t line, std::size_t slice, vec3 origin, const block_crossings& own,
                            line_crossings& found) const {
        found.clear(*body_);
        const std::size_t slot = slice * block + line % block;
        std::uint32_t rank = ~0U; // of the crossing before, for neighbours mostly belong to the same object
        bool around = false;
        for (std::size_t i = slot == 0 ? 0 : own.end[slot - 1]; i < own.end[slot]; ++i) {
            const crossing& one = own.crossings[i];
            if (!(one.distance >= 0)) continue;
            if (one.rank != rank) rank = one.rank, around = body_->ranked(rank).box.contains(origin);
            if (around) found.inside.toggle(rank);
            if (one.distance <= reach_) found.crossings.push_back(one);
        }
    }

  private:
    // A segment that a block waits for.
    struct waiting {
        float depth = 0; // the sum of its ends'
        const cut_segment* segment = nullptr;
    };

    // How many lines may meet a box.
    INSONIFY_LAZY std::uint32_t lines_near(const aabb& box, const slice_frame& frame) const {
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

    const scene* body_ = nullptr;
    std::size_t slices_ = 0;
    float reach_ = 0;
    line_fan fan_;
    std::vector<std::uint8_t> chosen_; // of each object, whether it is cut
    std::vector<std::uint32_t> left_;  // the others
    slice_cut cut_;
    large_array<std::size_t> block_end_; // where the segments of each block end, in `of_blocks_`
    large_array<waiting> of_blocks_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
