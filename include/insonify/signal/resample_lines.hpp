#ifndef INSONIFY_SIGNAL_RESAMPLE_LINES_HPP
#define INSONIFY_SIGNAL_RESAMPLE_LINES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Echoes on the lines of a probe from those on fewer or more lines of it, after `convolve`: a beam has no detail finer
/// than its width, so lines half of that apart say what is between them (`rays_per_line`).
///
/// Each line is the sum of the six around it, weighted by a Lanczos window, along the wave front; beyond the sides of
/// the field of view there are none, and the others weigh more. `tests/signal/resample_lines.cpp` measures the error.
/// @param traced    the probe of `lines`
/// @param wanted    that of the result: the same face, field of view and steering
/// @param recycled  lines whose memory is reused
/// @throws usage_error  for lines that are not those of the probe, or probes that are steered differently
template <exec::policy Policy, transducer Traced, transducer Wanted>
iq_lines resample_lines(const Policy& policy, const iq_lines& lines, const Traced& traced, const Wanted& wanted,
                        iq_lines recycled = {}) {
    detail::check_echoes(lines, traced.lines, "resample_lines");
    check_depth(lines.depth, "resample_lines");
    wanted.check();
    const auto middle_direction = [](const auto& probe) {
        return probe.beam(0.5F * static_cast<float>(probe.lines) - 0.5F).direction;
    };
    if (!(length(middle_direction(wanted) - middle_direction(traced)) < 1e-3F))
        throw usage_error{"resample_lines: the probes are steered differently; both must have the same `steering`"};
    iq_lines made = std::move(recycled);
    made.reshape(wanted.lines, lines.samples, lines.depth);
    const bool around = is_full_circle(traced);
    const auto count = static_cast<int>(lines.count), samples = static_cast<int>(lines.samples);
    const float advance = line_advance(traced), per_line = static_cast<float>(count) / static_cast<float>(wanted.lines);
    const float samples_per_line = advance * static_cast<float>(samples) / lines.depth,
                turn = 4 * pi * traced.frequency * advance / display_speed; // of the phase, from line to line
    // Sinc, with the window of Lanczos over six lines, at a distance in lines.
    const auto lanczos = [](float distance) {
        constexpr float half_width = 3;
        const auto sinc = [](float x) { return std::fabs(x) < 1e-4F ? 1.0F : std::sin(pi * x) / (pi * x); };
        return std::fabs(distance) < half_width ? sinc(distance) * sinc(distance / half_width) : 0;
    };
    const auto interpolate = [&](std::size_t line, std::size_t) {
        vec2* const to = made.values.data() + line * lines.samples;
        std::fill_n(to, samples, vec2{0, 0});
        const float place = (static_cast<float>(line) + 0.5F) * per_line - 0.5F;
        const auto first = static_cast<int>(std::floor(place)) - 2;
        const auto exists = [&](int neighbour) { return around || (neighbour >= 0 && neighbour < count); };
        float sum = 0;
        for (int i = first; i < first + 6; ++i)
            if (exists(i)) sum += lanczos(static_cast<float>(i) - place);
        for (int i = first; i < first + 6; ++i) {
            if (!exists(i)) continue;
            const float apart = static_cast<float>(i) - place, weight = lanczos(apart) / sum;
            const vec2 factor = weight * vec2{std::cos(turn * apart), -std::sin(turn * apart)};
            const auto less_deep = static_cast<int>(std::lround(samples_per_line * apart));
            const vec2* const from =
                lines.values.data() + static_cast<std::size_t>((i + count) % count) * lines.samples;
            for (int k = std::max(less_deep, 0); k < std::min(samples + less_deep, samples); ++k)
                to[k] += detail::complex_product(from[k - less_deep], factor);
        }
    };
    exec::for_each_block(policy, wanted.lines, 1, 6 * static_cast<float>(samples), interpolate);
    return made;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
