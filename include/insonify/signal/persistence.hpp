#ifndef INSONIFY_SIGNAL_PERSISTENCE_HPP
#define INSONIFY_SIGNAL_PERSISTENCE_HPP

#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/probe/line_grid.hpp>
#include <cstddef>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// Lets the frames of a clip fade into each other: grey = p old + (1 - p) new, on the grey of `log_compress`.
class persistence {
  public:
    /// @param share  p of what was shown before: 0 shows every frame as it is, and below 1
    /// @throws usage_error  where the share makes no sense
    INSONIFY_LAZY explicit persistence(float share = 0) : share_{share} {
        if (!(share >= 0 && share < 1))
            throw usage_error{"persistence: the share of the past must be from 0 to below 1"};
    }

    /// Takes in one more frame. The past is forgotten where the pose of the probe, the number of lines or of samples, or
    /// the depth differs from the frame before. Call `reset` first where another probe or other settings made the frame.
    /// @return what is to be shown; good until the next call
    template <exec::policy Policy>
    const scan_lines& add(const Policy& policy, scan_lines frame, const pose& at) {
        const bool fades = at == at_ && frame.count == shown_.count && frame.samples == shown_.samples &&
                           frame.depth == shown_.depth && frame.values.size() == shown_.values.size();
        if (fades && share_ > 0)
            exec::for_each_block(policy, frame.values.size(), 4096, 0.5F, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i)
                    frame.values[i] = share_ * shown_.values[i] + (1 - share_) * frame.values[i];
            });
        at_ = at;
        std::swap(later<Policy>(shown_), later<Policy>(frame));
        return shown_;
    }

    /// Forgets the past, so that the next frame stands alone: for changes that neither the pose nor the grid tells of.
    INSONIFY_LAZY void reset() { shown_ = {}; }

  private:
    float share_ = 0;
    pose at_;
    scan_lines shown_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
