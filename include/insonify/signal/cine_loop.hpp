#ifndef INSONIFY_SIGNAL_CINE_LOOP_HPP
#define INSONIFY_SIGNAL_CINE_LOOP_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// The last frames of a clip, in memory that is reused.
/// @tparam Frame  default-constructible
template <class Frame>
class cine_loop {
  public:
    /// Adds a frame.
    /// @param length  number of frames to keep, at least 1; the oldest are dropped
    /// @param fill    fill(frame) overwrites the frame, which holds an old one; if it throws, the frame is not added
    template <class Fill>
    void add(std::uint32_t length, const Fill& fill) {
        fit(std::max(length, 1U));
        if (count_ == frames_.size()) --count_; // the oldest is overwritten
        const std::size_t place = (newest_ + 1) % frames_.size();
        fill(frames_[place]);
        newest_ = place;
        ++count_;
    }

    /// Number of frames.
    std::uint32_t size() const { return static_cast<std::uint32_t>(count_); }
    /// Whether there is none.
    bool empty() const { return count_ == 0; }

    /// A frame; not checked. @param back  0: the newest, `size()` - 1: the oldest
    const Frame& operator[](std::uint32_t back) const {
        return frames_[(newest_ + frames_.size() - back) % frames_.size()];
    }

    /// Forgets all frames, and keeps the memory.
    void clear() { count_ = 0; }

  private:
    void fit(std::size_t length) {
        if (frames_.size() == length) return;
        // From the oldest to the newest, and the unused ones after these.
        if (!frames_.empty())
            std::rotate(frames_.begin(), frames_.begin() + static_cast<std::ptrdiff_t>((newest_ + 1) % frames_.size()),
                        frames_.end());
        if (frames_.size() > length)
            frames_.erase(frames_.begin(), frames_.end() - static_cast<std::ptrdiff_t>(length));
        else
            frames_.insert(frames_.begin(), length - frames_.size(), Frame{});
        newest_ = length - 1;
        count_ = std::min(count_, length);
    }

    std::vector<Frame> frames_{};
    std::size_t newest_ = 0;
    std::size_t count_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
