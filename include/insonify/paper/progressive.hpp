#ifndef INSONIFY_PAPER_PROGRESSIVE_HPP
#define INSONIFY_PAPER_PROGRESSIVE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/policy.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/image/image.hpp>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Mean of the frames since the probe last moved.
///
/// Eq. 7 of the paper: the f-th frame c and the mean c' of those before it give c / f + (f - 1) / f c'. In double
/// precision, so that it remains the arithmetic mean over many frames.
class progressive {
  public:
    /// Adds a frame. Restarts where the pose of the probe or the size has changed since the previous frame.
    /// @return `picture()`
    template <exec::policy Policy>
    const image& add(const Policy& policy, const image& frame, const pose& at) {
        if (at != at_ || frame.size != picture_.size || frame.pixels.size() != mean_.size()) reset();
        if (frames_ == 0) {
            at_ = at;
            picture_ = frame;
            mean_.assign(frame.pixels.size(), 0.0);
        }
        ++frames_;
        const double f = frames_;
        exec::for_each_block(policy, mean_.size(), 4096, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                mean_[i] = static_cast<double>(frame.pixels[i]) / f + (f - 1) / f * mean_[i];
                picture_.pixels[i] = static_cast<float>(mean_[i]);
            }
        });
        return picture_;
    }

    /// The mean after the last `add`.
    const image& picture() const { return picture_; }

    /// Number of frames in the mean.
    std::uint32_t frames() const { return frames_; }

    /// Restarts with the next frame: for changes that the pose does not show.
    void reset() { frames_ = 0; }

  private:
    pose at_;
    image picture_;
    std::vector<double> mean_;
    std::uint32_t frames_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
