#ifndef INSONIFY_SIGNAL_KERNEL_CONVOLVE_HPP
#define INSONIFY_SIGNAL_KERNEL_CONVOLVE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/text.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/kernel/axial_kernel.hpp>
#include <insonify/signal/kernel/lateral_kernel.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Options of `convolve`.
struct convolve_settings {
    std::uint32_t decimation = 1; ///< samples per result; a divisor of the number of samples
};

namespace detail {

/// `for_each_block` with scratch memory for each block: body(begin, end, memory).
template <exec::policy Policy, class Body>
void for_each_block_with_memory(const Policy& policy, std::size_t count, std::size_t block, float nanoseconds,
                                std::vector<std::vector<vec2>>& memory, const Body& body) {
    memory.resize(std::max(memory.size(), (count + block - 1) / block));
    exec::for_each_block(policy, count, block, nanoseconds,
                         [&](std::size_t begin, std::size_t end) { body(begin, end, memory[begin / block]); });
}

} // namespace detail

/// `convolve`, frame after frame: holds tables and memory, so that it allocates only while buffers grow.
class convolver {
  public:
    /// See `insonify::convolve`.
    template <exec::policy Policy, transducer Probe>
    iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                      const convolve_settings& settings = {}) {
        probe.check();
        sent.check(probe.frequency);
        if (echoes.count != probe.lines || echoes.samples == 0 ||
            echoes.values.size() != static_cast<std::size_t>(echoes.count) * echoes.samples)
            throw usage_error{
                "convolve: the echoes must have as many lines as the probe, and a value for every sample"};
        check_depth(echoes.depth, "convolve");
        if (settings.decimation == 0 || echoes.samples % settings.decimation != 0)
            throw usage_error{
                detail::joined({"convolve: decimation is ", std::to_string(settings.decimation),
                                "; it must be a divisor of the number of samples, ", std::to_string(echoes.samples)})};
        const float per_metre = static_cast<float>(echoes.samples) / echoes.depth;
        const pulse_envelope in_metres = sent.envelope(probe.frequency);
        const pulse_envelope envelope{.sigma = in_metres.sigma * per_metre, .burst = in_metres.burst * per_metre};
        const auto decimation = static_cast<float>(settings.decimation);
        if (!(envelope.sigma * 1.0001F >= decimation)) {
            const float needed = min(std::ceil(static_cast<float>(echoes.samples) * decimation / envelope.sigma), 1e9F);
            throw usage_error{
                detail::joined({"convolve: the samples are too coarse for the pulse; a line needs at least ",
                                std::to_string(static_cast<std::uint32_t>(needed)), " (twice as many are usual)",
                                settings.decimation > 1 ? ", or a smaller `decimation`" : ""})};
        }

        iq_lines lines = along(policy, std::move(echoes), envelope, settings.decimation);
        lateral_ =
            detail::make_lateral_kernel(probe, {.depth = lines.depth, .samples = lines.samples}, std::move(lateral_));
        return across(policy, std::move(lines));
    }

  private:
    // The axial half of `convolve`; in place without decimation.
    // @param sent  in units of samples
    template <exec::policy Policy>
    iq_lines along(const Policy& policy, iq_lines echoes, const pulse_envelope& sent, std::uint32_t decimation) {
        constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
        axial_.set(echoes.samples, sent, decimation);
        if (decimation > 1) decimated_.reshape(echoes.count, echoes.samples / decimation, echoes.depth);
        iq_lines& results = decimation > 1 ? decimated_ : echoes;
        detail::for_each_block_with_memory(
            policy, echoes.count, 8, axial_.nanoseconds(), blocks_,
            [&](std::size_t begin, std::size_t end, std::vector<vec2>& layout) {
                layout.assign(axial_.layout_size(), vec2{0, 0});
                for (std::size_t line = begin; line < end; ++line) {
                    axial_.lay_out(echoes.values.data() + line * echoes.samples, layout.data());
                    axial_.template apply<width>(layout.data(), results.values.data() + line * results.samples);
                }
            });
        if (decimation > 1) std::swap(decimated_, echoes);
        return echoes;
    }

    // The lateral half of `convolve`; in place where lines are not steered. The weights change from sample to sample.
    template <exec::policy Policy>
    iq_lines across(const Policy& policy, iq_lines lines) {
        constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
        constexpr std::size_t thickness = detail::lateral_slab::samples;
        const std::size_t slabs = (lines.samples + thickness - 1) / thickness;
        const bool in_place = !lateral_.steered();
        if (!in_place) steered_.reshape(lines.count, lines.samples, lines.depth);
        iq_lines& results = in_place ? lines : steered_;
        const float slab_time = 0.2F * static_cast<float>((2 * lateral_.half_width() + 1) * lines.count * thickness);
        detail::for_each_block_with_memory(
            policy, slabs, 8, slab_time, blocks_, [&](std::size_t begin, std::size_t end, std::vector<vec2>& memory) {
                detail::lateral_slab slab{lateral_, memory};
                for (std::size_t i = begin; i < end; ++i) {
                    const std::size_t first = i * thickness, count = std::min(thickness, lines.samples - first);
                    slab.weigh(first, count);
                    slab.copy(lines.values.data() + first, lines.samples, count, first, lines.samples - first - count);
                    slab.template apply<width>(results.values.data() + first, lines.samples, count);
                }
            });
        if (!in_place) std::swap(steered_, lines);
        return lines;
    }

    detail::lateral_kernel lateral_{};        // weights across the lines
    detail::axial_kernel axial_{};            // weights along a line
    std::vector<std::vector<vec2>> blocks_{}; // scratch memory of each block of lines or samples
    iq_lines decimated_{};                    // the lines of the previous frame
    iq_lines steered_{};                      // lines that cannot be filtered in place
};

/// Convolves echoes with the point-spread function of the probe: the pulse along each line, the beam across the lines.
///
/// Axial: the pulse envelope, with peak 1. Lateral: a Gaussian of width `beam_model::lateral_sigma` along the wave front,
/// at right angles to the lines (`line_advance`), whose weights sum to 1 over the lines that exist, at the ends as well. So a plate keeps its amplitude at every depth, sampling and
/// line spacing. Lines are zero beyond their ends, so speckle fades within two standard deviations of the pulse from
/// them. In place: pass std::move(echoes).
/// @param echoes  baseband: an echo a at displayed depth z is a exp(-j 4 pi f0 z / c0), with c0 = display_speed
/// @throws usage_error  for lines that are not those of the probe, samples coarser than the standard deviation of the
///                      pulse, a pulse frequency other than that of the probe, and settings out of range
template <exec::policy Policy, transducer Probe>
iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                  const convolve_settings& settings = {}) {
    return convolver{}.convolve(policy, std::move(echoes), sent, probe, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
