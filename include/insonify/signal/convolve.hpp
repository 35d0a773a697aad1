#ifndef INSONIFY_SIGNAL_CONVOLVE_HPP
#define INSONIFY_SIGNAL_CONVOLVE_HPP

#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/axial_kernel.hpp>
#include <insonify/signal/lateral_kernel.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

struct convolve_settings {
    std::uint32_t decimation = 1; ///< so many samples become one, in the middle of them; it must divide their number
};

/// The axial half of `convolve`: in place where nothing is decimated.
/// @param sent  in samples
template <exec::policy Policy>
iq_lines convolve_along(const Policy& policy, iq_lines echoes, const pulse_envelope& sent, std::uint32_t decimation) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    const axial_kernel kernel{echoes.samples, sent, decimation};
    iq_lines decimated;
    if (decimation > 1) decimated = {echoes.count, echoes.samples / decimation, echoes.depth};
    iq_lines& results = decimation > 1 ? decimated : echoes;
    exec::for_each_block(policy, echoes.count, 8, [&](std::size_t begin, std::size_t end) {
        std::vector<vec2> layout(kernel.layout_size());
        for (std::size_t line = begin; line < end; ++line) {
            kernel.lay_out(echoes.values.data() + line * echoes.samples, layout.data());
            kernel.template apply<width>(layout.data(), results.values.data() + line * results.samples);
        }
    });
    return std::move(results);
}

/// The lateral half of `convolve`, in place.
template <exec::policy Policy>
iq_lines convolve_across(const Policy& policy, iq_lines lines, const lateral_kernel& kernel) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    constexpr std::size_t together = 8; // samples whose lines are turned into rows at a time: whole cache lines
    const std::size_t margin = kernel.reach();
    const std::size_t stride = margin + lines.count + margin + tap_block;
    exec::for_each_block(policy, lines.samples, 16 * together, [&](std::size_t begin, std::size_t end) {
        // A row is a sample on all lines, so that the taps read consecutive values here too; around it zeros or, for a
        // full circle, the lines from the other end.
        std::vector<vec2> rows(together * stride), sums(together * lines.count);
        std::vector<tap> taps;
        std::vector<float> half;
        for (std::size_t first = begin; first < end; first += together) {
            const std::size_t count = std::min(together, end - first);
            vec2* values = lines.values.data() + first;
            for (std::size_t line = 0; line < lines.count; ++line)
                for (std::size_t i = 0; i < count; ++i)
                    rows[i * stride + margin + line] = values[line * lines.samples + i];
            for (std::size_t i = 0; i < count; ++i) {
                vec2* row = rows.data() + i * stride + margin;
                if (kernel.full_circle) {
                    std::copy_n(row + lines.count - margin, margin, row - margin);
                    std::copy_n(row, margin, row + lines.count);
                }
                const lateral_weights weights = kernel.between(static_cast<std::uint32_t>(first + i), half);
                taps.clear();
                for (int offset = -weights.reach(); offset <= weights.reach(); ++offset)
                    taps.push_back(
                        {.weight = half[static_cast<std::size_t>(offset < 0 ? -offset : offset)], .offset = offset});
                vec2* sum = sums.data() + i * lines.count;
                sum_taps<width>({taps.data(), taps.size()}, row, sum, lines.count);
                const auto reach = static_cast<std::uint32_t>(weights.reach());
                for (std::uint32_t line = 0; line < lines.count; ++line)
                    if (line < reach || line + reach >= lines.count) sum[line] /= weights.existing(line);
            }
            for (std::size_t line = 0; line < lines.count; ++line)
                for (std::size_t i = 0; i < count; ++i) values[line * lines.samples + i] = sums[i * lines.count + line];
        }
    });
    return lines;
}

/// Echoes to what the probe receives: each spread by the pulse along the line and by the beam across the lines.
///
/// Along: the pulse's envelope, of peak 1. Across: a Gaussian in metres, `beam_model::lateral_sigma` wide,
/// whose weights sum to 1 over the lines that exist, also at the ends. So a plate keeps its amplitude at every depth,
/// sampling and line spacing. Beyond the ends of a line there is nothing. In place: pass std::move(echoes).
/// @param echoes  at baseband: an echo a at displayed depth z stands as a exp(-j 4 pi f0 z / c0), c0 = display_speed
/// @throws usage_error  where the echoes are not the probe's, or coarser than one standard deviation of the pulse;
///                      where the pulse is not at the probe's frequency, or a setting makes no sense
template <exec::policy Policy, transducer Probe>
iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                  const convolve_settings& settings = {}) {
    probe.check();
    sent.check(probe.frequency);
    if (echoes.count != probe.lines || echoes.samples == 0 ||
        echoes.values.size() != static_cast<std::size_t>(echoes.count) * echoes.samples)
        throw usage_error{"convolve: the echoes must have as many lines as the probe, and at least one sample"};
    if (!is_finite(echoes.depth) || !(echoes.depth > 0))
        throw usage_error{"convolve: the depth of the echoes must be a finite number of metres above 0"};
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

    iq_lines lines = convolve_along(policy, std::move(echoes), envelope, settings.decimation);
    return convolve_across(policy, std::move(lines),
                           make_lateral_kernel(probe, {.depth = lines.depth, .samples = lines.samples}));
}

} // namespace insonify::inline INSONIFY_ABI
#endif
