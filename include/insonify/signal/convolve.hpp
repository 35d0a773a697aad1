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
#include <vector>

namespace insonify::inline INSONIFY_ABI {

struct convolve_settings {
    std::uint32_t decimation = 1; ///< so many samples become one; it must divide their number
};

/// Along each line: in place where nothing is decimated.
template <exec::policy Policy>
iq_lines convolve_along(const Policy& policy, iq_lines echoes, float sigma, std::uint32_t decimation) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    const axial_kernel kernel{echoes.samples, sigma, decimation};
    iq_lines decimated;
    if (decimation > 1) decimated = iq_lines{echoes.count, echoes.samples / decimation, echoes.depth};
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

/// Across the lines, in place.
template <exec::policy Policy>
iq_lines convolve_across(const Policy& policy, iq_lines lines, const lateral_kernel& kernel) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    constexpr std::size_t step = lateral_kernel::depth_step;
    exec::for_each_block(policy, lines.samples, 16 * step, [&](std::size_t begin, std::size_t end) {
        const std::size_t margin = kernel.reach() * step;
        std::vector<vec2> rows(2 * margin + lines.count * step + tap_block), sums(lines.count * step);
        std::vector<tap> taps;
        for (std::size_t first = begin; first < end; first += step) {
            const std::size_t used = std::min(step, end - first);
            for (std::size_t line = 0; line < lines.count; ++line)
                std::copy_n(lines.values.data() + line * lines.samples + first, used,
                            rows.data() + margin + line * step);
            if (kernel.full_circle) {
                std::copy_n(rows.data() + lines.count * step, margin, rows.data());
                std::copy_n(rows.data() + margin, margin, rows.data() + margin + lines.count * step);
            }
            const lateral_weights weights = kernel.at(static_cast<std::uint32_t>(first));
            taps.clear();
            for (int offset = -weights.reach(); offset <= weights.reach(); ++offset)
                taps.push_back({.weight = weights.half[static_cast<std::size_t>(std::abs(offset))], .offset = offset * static_cast<std::ptrdiff_t>(step)});
            sum_taps<width>({taps.data(), taps.size()}, rows.data() + margin, sums.data(), lines.count * step);
            for (std::uint32_t line = 0; line < lines.count; ++line) {
                const float whole = 1 / weights.existing(line);
                for (std::size_t i = 0; i < used; ++i) lines.values[line * lines.samples + first + i] = whole * sums[line * step + i];
            }
        }
    });
    return lines;
}

template <exec::policy Policy, transducer Probe>
iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                  const convolve_settings& settings = {}) {
    const float sigma = sent.sigma_z(probe.frequency) * static_cast<float>(echoes.samples) / echoes.depth;
    iq_lines lines = convolve_along(policy, std::move(echoes), sigma, settings.decimation);
    const lateral_kernel across = make_lateral_kernel(probe, {.depth = lines.depth, .samples = lines.samples});
    return convolve_across(policy, std::move(lines), across);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
