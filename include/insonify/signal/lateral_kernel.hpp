#ifndef INSONIFY_SIGNAL_LATERAL_KERNEL_HPP
#define INSONIFY_SIGNAL_LATERAL_KERNEL_HPP

#include <insonify/core/later.hpp>
#include <insonify/core/view.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/signal/beam.hpp>
#include <insonify/signal/taps.hpp>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What a line takes from its neighbours at one depth: weights that sum to 1 over the lines that exist.
struct lateral_weights {
    view<const float> half{}; ///< by distance in lines, 0 to the reach; both sides together sum to 1
    std::uint32_t lines = 1;  ///< of the probe
    bool full_circle = false; ///< the last line is the neighbour of the first
    float spacing = 0;        ///< of the lines at this depth, metres

    INSONIFY_FN int reach() const { return static_cast<int>(half.size()) - 1; }

    /// Offsets of the first and of the last neighbour within reach that exist.
    INSONIFY_FN int first(std::uint32_t line) const {
        const int there = static_cast<int>(line);
        return full_circle || there > reach() ? -reach() : -there;
    }
    INSONIFY_FN int last(std::uint32_t line) const {
        const int there = static_cast<int>(lines - 1 - line);
        return full_circle || there > reach() ? reach() : there;
    }

    /// The sum of `half` over the lines that exist: 1 but near the ends, where the weights are divided by it.
    INSONIFY_FN float existing(std::uint32_t line) const {
        const int begin = first(line), end = last(line);
        if (begin == -reach() && end == reach()) return 1;
        float sum = 0;
        for (int offset = begin; offset <= end; ++offset) sum += weight(offset);
        return sum;
    }

    /// The power that independent echoes have on a line: sum_jk w_j g_j w_k g_k C(x_j - x_k).
    /// @param covariance  C(lag), of values on two lines that are so many lines apart; 1 at 0, and 0 from some lag on
    /// @param gain        g(line): the amplitude that the echoes of a line have before
    template <class Covariance, class Gain>
    INSONIFY_FN float power(std::uint32_t line, const Covariance& covariance, const Gain& gain) const {
        const int begin = first(line), end = last(line), here = static_cast<int>(line);
        const auto amplitude = [&](int offset) {
            const int count = static_cast<int>(lines);
            return weight(offset) * gain(static_cast<std::uint32_t>((here + offset + count) % count));
        };
        float sum = 0;
        for (int lag = 0; lag <= end - begin; ++lag) {
            const float alike = covariance(lag);
            if (lag > 0 && !(alike > 0)) break;
            float products = 0;
            for (int offset = begin; offset + lag <= end; ++offset)
                products += amplitude(offset) * amplitude(offset + lag);
            sum += (lag == 0 ? 1 : 2) * alike * products;
        }
        const float all = existing(line);
        return sum / (all * all);
    }

  private:
    INSONIFY_FN float weight(int offset) const { return half[static_cast<std::size_t>(offset < 0 ? -offset : offset)]; }
};

/// The weights of `convolve` at every depth of a grid of lines. Made by `make_lateral_kernel`.
///
/// Stated in the middle of every depth step, and linear between: steps in them would be heard as noise.
struct lateral_kernel {
    static constexpr std::uint32_t depth_step = 8; ///< samples

    /// Where the weights of a step begin in `weights`.
    struct entry {
        std::size_t begin = 0;
        std::size_t count = 0;
        float spacing = 0; ///< of the lines, metres
    };
    std::uint32_t lines = 1;
    bool full_circle = false; ///< the last line is the neighbour of the first
    std::vector<entry> entries;
    std::vector<float> weights;

    /// In the middle of the step that a sample belongs to.
    INSONIFY_LAZY lateral_weights at(std::uint32_t sample) const { return of(entries[sample / depth_step]); }

    /// At a sample itself, as `convolve` takes them: (1 - share) of one step's weights and `share` of another's.
    struct blend {
        view<const float> above{};
        view<const float> below{};
        float share = 0;
    };
    INSONIFY_LAZY blend blend_at(std::uint32_t sample) const {
        const auto last = static_cast<float>(entries.size() - 1);
        const float place = clamped((static_cast<float>(sample) + 0.5F) / depth_step - 0.5F, 0, last);
        const auto first = static_cast<std::size_t>(place);
        const entry &above = entries[first], &below = entries[first + (place < last ? 1 : 0)];
        return {.above = {weights.data() + above.begin, above.count},
                .below = {weights.data() + below.begin, below.count},
                .share = place - static_cast<float>(first)};
    }

    /// The furthest of all depths, in lines.
    INSONIFY_LAZY std::size_t reach() const {
        std::size_t most = 1;
        for (const entry& e : entries) most = e.count > most ? e.count : most;
        return most - 1;
    }

  private:
    INSONIFY_LAZY lateral_weights of(const entry& e) const {
        return {.half = {weights.data() + e.begin, e.count},
                .lines = lines,
                .full_circle = full_circle,
                .spacing = e.spacing};
    }
};

/// @param scan      depth and samples of the lines; `samples` must be stated
/// @param recycled  a kernel whose memory is used again
/// @throws usage_error  where the probe or the acquisition makes no sense
template <transducer Probe>
lateral_kernel make_lateral_kernel(const Probe& probe, const acquisition& scan, lateral_kernel recycled = {}) {
    const beam_model beam = beam_of(probe, scan.depth);
    if (scan.samples == 0) throw usage_error{"make_lateral_kernel: `samples` must be stated"};
    constexpr std::uint32_t step = lateral_kernel::depth_step;
    lateral_kernel kernel = std::move(recycled);
    kernel.lines = probe.lines;
    kernel.full_circle = is_full_circle(probe);
    auto& entries = later<Probe>(kernel.entries);
    auto& weights = later<Probe>(kernel.weights);
    entries.clear();
    weights.clear();
    const std::uint32_t most = kernel.full_circle ? (probe.lines - 1) / 2 : probe.lines - 1;
    for (std::uint32_t sample = 0; sample < scan.samples; sample += step) {
        const float depth = (static_cast<float>(sample) + 0.5F * step) * scan.depth / static_cast<float>(scan.samples);
        const float sigma = beam.lateral_sigma(depth);
        const float spacing = line_spacing(probe, depth);
        const std::size_t begin = weights.size();
        double sum = 0;
        for (std::uint32_t offset = 0; offset <= most; ++offset) {
            const float sigmas = static_cast<float>(offset) * spacing / sigma;
            if (sigmas > kernel_sigmas) break;
            weights.push_back(std::exp(-0.5F * sigmas * sigmas));
            sum += (offset == 0 ? 1 : 2) * static_cast<double>(weights.back());
        }
        const std::size_t end = weights.size();
        for (std::size_t i = begin; i < end; ++i)
            weights[i] = static_cast<float>(static_cast<double>(weights[i]) / sum);
        entries.push_back({.begin = begin, .count = end - begin, .spacing = spacing});
    }
    return kernel;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
