#ifndef INSONIFY_SIGNAL_CONVOLVE_HPP
#define INSONIFY_SIGNAL_CONVOLVE_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/axial_kernel.hpp>
#include <insonify/signal/lateral_slab.hpp>
#include <insonify/signal/pulse.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What `convolve` does beside spreading the echoes.
struct convolve_settings {
    std::uint32_t decimation = 1; ///< so many samples become one, in the middle of them; it must divide their number
};

/// What `convolve` keeps from frame to frame: handed back each time, nothing is allocated after the first.
struct convolve_workspace {
    lateral_kernel lateral;                ///< weights across the lines
    axial_kernel axial;                    ///< weights along a line
    std::vector<std::vector<vec2>> blocks; ///< what a block of lines, or of samples, is worked on in
    iq_lines decimated;                    ///< the lines of the frame before
};

/// The axial half of `convolve`: in place where nothing is decimated.
/// @param sent  in samples
template <exec::policy Policy>
iq_lines convolve_along(const Policy& policy, iq_lines echoes, const pulse_envelope& sent, std::uint32_t decimation,
                        convolve_workspace& own) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    constexpr std::size_t together = 8; // lines
    own.axial.set(echoes.samples, sent, decimation);
    if (decimation > 1) own.decimated.reshape(echoes.count, echoes.samples / decimation, echoes.depth);
    iq_lines& results = decimation > 1 ? own.decimated : echoes;
    const std::size_t blocks = (echoes.count + together - 1) / together;
    if (own.blocks.size() < blocks) later<Policy>(own.blocks).resize(blocks);
    exec::for_each_block(
        policy, echoes.count, together, own.axial.nanoseconds(), [&](std::size_t begin, std::size_t end) {
            std::vector<vec2>& layout = own.blocks[begin / together];
            layout.assign(own.axial.layout_size(), vec2{0, 0});
            for (std::size_t line = begin; line < end; ++line) {
                own.axial.lay_out(echoes.values.data() + line * echoes.samples, layout.data());
                own.axial.template apply<width>(layout.data(), results.values.data() + line * results.samples);
            }
        });
    if (decimation > 1) std::swap(later<Policy>(own.decimated), later<Policy>(echoes));
    return echoes;
}

/// The lateral half of `convolve`, in place.
///
/// A slab of a few samples on all lines is copied out, with room for neighbours beyond the outermost: zeros or, for a
/// full circle, the lines from the other end. The weights change from sample to sample.
template <exec::policy Policy>
iq_lines convolve_across(const Policy& policy, iq_lines lines, convolve_workspace& own) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    constexpr std::size_t thickness = lateral_slab::samples;
    const std::size_t slabs = (lines.samples + thickness - 1) / thickness, together = 8;
    const std::size_t blocks = (slabs + together - 1) / together;
    if (own.blocks.size() < blocks) later<Policy>(own.blocks).resize(blocks);
    const float slab_time = 0.2F * static_cast<float>((2 * own.lateral.reach() + 1) * lines.count * thickness);
    exec::for_each_block(policy, slabs, together, slab_time, [&](std::size_t begin, std::size_t end) {
        lateral_slab slab{own.lateral, own.blocks[begin / together]};
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t first = i * thickness, count = std::min(thickness, lines.samples - first);
            slab.weigh(first, count);
            slab.copy(lines.values.data() + first, lines.samples, count);
            slab.template apply<width>(lines.values.data() + first, lines.samples, count);
        }
    });
    return lines;
}

/// Echoes to what the probe receives: each spread by the pulse along the line and by the beam across the lines.
///
/// Along: the pulse's envelope, of peak 1. Across: a Gaussian in metres, `beam_model::lateral_sigma` wide,
/// whose weights sum to 1 over the lines that exist, also at the ends. So a plate keeps its amplitude at every depth,
/// sampling and line spacing. Beyond the ends of a line there is nothing, so texture fades within two deviations of the
/// pulse from them. In place: pass std::move(echoes).
/// @param echoes  at baseband: an echo a at displayed depth z stands as a exp(-j 4 pi f0 z / c0), c0 = display_speed
/// @throws usage_error  where the echoes are not the probe's, or coarser than one standard deviation of the pulse;
///                      where the pulse is not at the probe's frequency, or a setting makes no sense
/// @param own     kept from frame to frame it spares allocations
template <exec::policy Policy, transducer Probe>
iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                  const convolve_settings& settings, convolve_workspace& own) {
    probe.check();
    sent.check(probe.frequency);
    if (echoes.count != probe.lines || echoes.samples == 0 ||
        echoes.values.size() != static_cast<std::size_t>(echoes.count) * echoes.samples)
        throw usage_error{"convolve: the echoes must have as many lines as the probe, and at least one sample"};
    if (!is_depth(echoes.depth)) throw usage_error{"convolve: the depth of the echoes must be from 1 nm to 1000 km"};
    if (settings.decimation == 0 || echoes.samples % settings.decimation != 0)
        throw usage_error{"convolve: `decimation` must divide the number of samples, " +
                          std::to_string(echoes.samples)};
    const float per_metre = static_cast<float>(echoes.samples) / echoes.depth;
    const pulse_envelope in_metres = sent.envelope(probe.frequency);
    const pulse_envelope envelope{.sigma = in_metres.sigma * per_metre, .burst = in_metres.burst * per_metre};
    const auto decimation = static_cast<float>(settings.decimation);
    if (!(envelope.sigma * 1.0001F >= decimation)) {
        const float needed = lesser(std::ceil(static_cast<float>(echoes.samples) * decimation / envelope.sigma), 1e9F);
        throw usage_error{"convolve: the samples are too coarse for this pulse; a line needs at least " +
                          std::to_string(static_cast<std::uint32_t>(needed)) + " (twice as many are usual)" +
                          (settings.decimation > 1 ? ", or a smaller `decimation`" : "")};
    }

    iq_lines lines = convolve_along(policy, std::move(echoes), envelope, settings.decimation, own);
    own.lateral = make_lateral_kernel(probe, {.depth = lines.depth, .samples = lines.samples}, std::move(own.lateral));
    return convolve_across(policy, std::move(lines), own);
}
/// The same in memory of its own.
template <exec::policy Policy, transducer Probe>
iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                  const convolve_settings& settings = {}) {
    convolve_workspace own;
    return convolve(policy, std::move(echoes), sent, probe, settings, own);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
