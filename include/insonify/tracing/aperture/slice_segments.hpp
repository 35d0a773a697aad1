#ifndef INSONIFY_TRACING_APERTURE_SLICE_SEGMENTS_HPP
#define INSONIFY_TRACING_APERTURE_SLICE_SEGMENTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/aperture/turned_fan.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The segments of one slice by the sum of the depths of their ends, which lie in flat arrays so that a register takes several.
/// Keeps its memory from frame to frame.
class slice_segments {
  public:
    static constexpr int width = simd_width;

    void clear() { order_.clear(); }
    void add(const cut_segment& one) { order_.push_back({one.from.y + one.to.y, &one}); }
    /// Sorts the segments, after the last was added.
    void sort() {
        std::sort(order_.begin(), order_.end(), [](const deep& a, const deep& b) { return a.depth < b.depth; });
        const std::size_t padded = (order_.size() + width - 1) / width * width;
        for (std::vector<float>& ends : ends_) ends.assign(padded, 0);
        for (std::size_t i = 0; i < order_.size(); ++i) {
            const cut_segment& one = *order_[i].segment;
            ends_[0][i] = one.from.x, ends_[1][i] = one.from.y, ends_[2][i] = one.to.x, ends_[3][i] = one.to.y;
        }
    }

    std::size_t size() const { return order_.size(); }
    const cut_segment& operator[](std::size_t i) const { return *order_[i].segment; }

    /// The ends of `width` segments from the i-th on; behind the last, 0.
    point_lanes from(std::size_t i) const { return {load<width>(&ends_[0][i]), load<width>(&ends_[1][i])}; }
    point_lanes to(std::size_t i) const { return {load<width>(&ends_[2][i]), load<width>(&ends_[3][i])}; }

  private:
    struct deep {
        float depth = 0;
        const cut_segment* segment = nullptr;
    };
    std::vector<deep> order_{};
    std::vector<float> ends_[4] = {};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
