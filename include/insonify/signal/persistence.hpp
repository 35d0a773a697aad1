#ifndef INSONIFY_SIGNAL_PERSISTENCE_HPP
#define INSONIFY_SIGNAL_PERSISTENCE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/probe/line_grid.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Temporal smoothing of a clip: brightness = p old + (1 - p) new, applied after `log_compress`.
class persistence {
  public:
    /// @param weight  p, the weight of the previous output, from 0 (no smoothing) to below 1
    /// @throws usage_error  for a weight out of range
    explicit persistence(float weight = 0) : weight_{weight} {
        if (!(weight >= 0 && weight < 1))
            throw usage_error{"persistence: the weight of the past must be at least 0 and below 1"};
    }

    /// Sets the weight, as the constructor does, for the frames to come.
    void weight(float of_past) { weight_ = persistence{of_past}.weight_; }

    /// Adds a frame. Restarts where the pose of the probe, the number of lines or samples, or the depth has changed
    /// since the previous frame. Call `reset` first where the probe or other settings have changed.
    /// @return the frame to show; valid until the next call
    template <exec::policy Policy>
    const scan_lines& add(const Policy& policy, const scan_lines& frame, const pose& at) {
        if (!(at == at_)) reset();
        at_ = at;
        return add(policy, frame);
    }
    /// The same, wherever the probe is.
    template <exec::policy Policy>
    const scan_lines& add(const Policy& policy, const scan_lines& frame) {
        const bool fades = !starts_ && frame.count == shown_.count && frame.samples == shown_.samples &&
                           frame.depth == shown_.depth && frame.values.size() == shown_.values.size();
        starts_ = false;
        if (!fades || weight_ == 0) return shown_ = frame;
        exec::for_each_in_blocks(policy, frame.values.size(), 4096, 0.5F, [&](std::size_t i) {
            shown_.values[i] = weight_ * shown_.values[i] + (1 - weight_) * frame.values[i];
        });
        return shown_;
    }

    /// Restarts with the next frame: for changes that neither the pose nor the grid shows.
    void reset() { starts_ = true; }

  private:
    float weight_ = 0;
    bool starts_ = true;
    pose at_;
    scan_lines shown_;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
