#ifndef INSONIFY_TRACING_PATHS_PATH_ESTIMATE_HPP
#define INSONIFY_TRACING_PATHS_PATH_ESTIMATE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The mean of independent random estimates of the same lines, with its standard error.
///
///     path_estimate echoes;
///     for (std::uint64_t frame = 0; frame < 50; ++frame)
///         echoes.add(policy, trace_paths(..., {.paths_per_line = 40, .seed = frame}));
///
/// Source of the update: Welford 1962.
class path_estimate {
  public:
    /// @throws usage_error  where the shape of the lines differs from the former ones
    template <exec::policy Policy>
    void add(const Policy& policy, const iq_lines& lines) {
        if (frames_ == 0) {
            mean_ = iq_lines{lines.count, lines.samples, lines.depth};
            squares_.assign(lines.values.size(), 0);
        } else if (lines.count != mean_.count || lines.samples != mean_.samples || lines.depth != mean_.depth)
            throw usage_error{"path_estimate: all frames must have the same lines, samples and depth"};
        ++frames_;
        exec::for_each_block(policy, lines.values.size(), 4096, 2, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const vec2 before = lines.values[i] - mean_.values[i];
                mean_.values[i] += before / static_cast<float>(frames_);
                squares_[i] += dot(before, lines.values[i] - mean_.values[i]);
            }
        });
    }

    /// Number of estimates.
    std::uint32_t frames() const { return frames_; }
    /// Their mean, sample by sample.
    const iq_lines& mean() const { return mean_; }

    /// Standard error of the mean of each sample: the standard deviation of the complex value over the square root of the
    /// number of frames; 0 before two frames.
    scan_lines standard_error() const {
        scan_lines error{mean_.count, mean_.samples, mean_.depth};
        if (frames_ > 1)
            for (std::size_t i = 0; i < squares_.size(); ++i)
                error.values[i] =
                    std::sqrt(squares_[i] / static_cast<float>(frames_ - 1) / static_cast<float>(frames_));
        return error;
    }

  private:
    std::uint32_t frames_ = 0;
    iq_lines mean_;
    std::vector<float> squares_;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
