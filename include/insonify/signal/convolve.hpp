#ifndef INSONIFY_SIGNAL_CONVOLVE_HPP
#define INSONIFY_SIGNAL_CONVOLVE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/text.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/axial_kernel.hpp>
#include <insonify/signal/lateral_slab.hpp>
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

/// Tables and memory of `convolve`. Pass it again with the next frame: memory is allocated only while it grows.
struct convolve_workspace {
    detail::lateral_kernel lateral;        ///< weights across the lines
    detail::axial_kernel axial;            ///< weights along a line
    std::vector<std::vector<vec2>> blocks; ///< scratch memory of each block of lines or samples
    iq_lines decimated;                    ///< the lines of the previous frame
    iq_lines steered;                      ///< lines that cannot be filtered in place
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

/// The axial half of `convolve`; in place without decimation.
/// @param sent  in units of samples
template <exec::policy Policy>
iq_lines convolve_along(const Policy& policy, iq_lines echoes, const pulse_envelope& sent, std::uint32_t decimation,
                        convolve_workspace& own) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    own.axial.set(echoes.samples, sent, decimation);
    if (decimation > 1) own.decimated.reshape(echoes.count, echoes.samples / decimation, echoes.depth);
    iq_lines& results = decimation > 1 ? own.decimated : echoes;
    for_each_block_with_memory(policy, echoes.count, 8, own.axial.nanoseconds(), own.blocks,
                               [&](std::size_t begin, std::size_t end, std::vector<vec2>& layout) {
                                   layout.assign(own.axial.layout_size(), vec2{0, 0});
                                   for (std::size_t line = begin; line < end; ++line) {
                                       own.axial.lay_out(echoes.values.data() + line * echoes.samples, layout.data());
                                       own.axial.template apply<width>(layout.data(),
                                                                       results.values.data() + line * results.samples);
                                   }
                               });
    if (decimation > 1) std::swap(own.decimated, echoes);
    return echoes;
}

/// The lateral half of `convolve`; in place where lines are not steered. The weights change from sample to sample.
template <exec::policy Policy>
iq_lines convolve_across(const Policy& policy, iq_lines lines, convolve_workspace& own) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    constexpr std::size_t thickness = lateral_slab::samples;
    const std::size_t slabs = (lines.samples + thickness - 1) / thickness;
    const bool in_place = !own.lateral.steered();
    if (!in_place) own.steered.reshape(lines.count, lines.samples, lines.depth);
    iq_lines& results = in_place ? lines : own.steered;
    const float slab_time = 0.2F * static_cast<float>((2 * own.lateral.half_width() + 1) * lines.count * thickness);
    for_each_block_with_memory(
        policy, slabs, 8, slab_time, own.blocks, [&](std::size_t begin, std::size_t end, std::vector<vec2>& memory) {
            lateral_slab slab{own.lateral, memory};
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t first = i * thickness, count = std::min(thickness, lines.samples - first);
                slab.weigh(first, count);
                slab.copy(lines.values.data() + first, lines.samples, count, first, lines.samples - first - count);
                slab.template apply<width>(results.values.data() + first, lines.samples, count);
            }
        });
    if (!in_place) std::swap(own.steered, lines);
    return lines;
}

} // namespace detail

/// Convolves echoes with the point-spread function of the probe: the pulse along each line, the beam across the lines.
///
/// Axial: the pulse envelope, with peak 1. Lateral: a Gaussian of width `beam_model::lateral_sigma` along the wave front,
/// at right angles to the lines (`line_advance`), whose weights sum to 1 over the lines that exist, at the ends as well. So a plate keeps its amplitude at every depth, sampling and
/// line spacing. Lines are zero beyond their ends, so speckle fades within two standard deviations of the pulse from
/// them. In place: pass std::move(echoes).
/// @param echoes  baseband: an echo a at displayed depth z is a exp(-j 4 pi f0 z / c0), with c0 = display_speed
/// @param own     tables and memory, kept from frame to frame
/// @throws usage_error  for lines that are not those of the probe, samples coarser than the standard deviation of the
///                      pulse, a pulse frequency other than that of the probe, and settings out of range
template <exec::policy Policy, transducer Probe>
iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                  const convolve_settings& settings, convolve_workspace& own) {
    probe.check();
    sent.check(probe.frequency);
    if (echoes.count != probe.lines || echoes.samples == 0 ||
        echoes.values.size() != static_cast<std::size_t>(echoes.count) * echoes.samples)
        throw usage_error{"convolve: the echoes must have as many lines as the probe, and a value for every sample"};
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

    iq_lines lines = detail::convolve_along(policy, std::move(echoes), envelope, settings.decimation, own);
    own.lateral =
        detail::make_lateral_kernel(probe, {.depth = lines.depth, .samples = lines.samples}, std::move(own.lateral));
    return detail::convolve_across(policy, std::move(lines), own);
}
/// The same, with its own tables and memory.
template <exec::policy Policy, transducer Probe>
iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                  const convolve_settings& settings = {}) {
    convolve_workspace own;
    return convolve(policy, std::move(echoes), sent, probe, settings, own);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
