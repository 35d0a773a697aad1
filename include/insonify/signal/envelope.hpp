#ifndef INSONIFY_SIGNAL_ENVELOPE_HPP
#define INSONIFY_SIGNAL_ENVELOPE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/hilbert.hpp>
#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Square roots, in place.
template <int Width>
void square_roots(float* values, std::size_t count) {
    const std::size_t whole = count - count % Width;
    for (std::size_t i = 0; i < whole; i += Width) store(sqrt(load<Width>(values + i)), values + i);
    for (std::size_t i = whole; i < count; ++i) values[i] = std::sqrt(values[i]);
}

} // namespace detail

/// Envelope of baseband signals: |IQ| = sqrt(I^2 + Q^2).
/// @param recycled  lines whose memory is reused
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const iq_lines& iq, scan_lines recycled = {}) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    recycled.reshape(iq.count, iq.samples, iq.depth);
    exec::for_each_block(policy, iq.values.size(), 16384, 0.6F, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            recycled.values[i] = iq.values[i].x * iq.values[i].x + iq.values[i].y * iq.values[i].y;
        detail::square_roots<width>(recycled.values.data() + begin, end - begin);
    });
    return recycled;
}

/// Envelope of RF signals: sqrt(RF^2 + H(RF)^2), where H is the Hilbert transform.
///
/// Equals |IQ| of the same echoes within 1e-3 of the maximum for fractional bandwidths below 0.8, except near truncated
/// signals: lines are zero beyond their ends.
/// @param rf  at least four samples per cycle
/// @throws usage_error  where the number of values is not lines times samples
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const scan_lines& rf) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    if (rf.values.size() != static_cast<std::size_t>(rf.count) * rf.samples)
        throw usage_error{"envelope: " + std::to_string(rf.count) + " lines of " + std::to_string(rf.samples) +
                          " samples need as many values, not " + std::to_string(rf.values.size())};
    const detail::hilbert_transform transform{rf.samples};
    scan_lines lines{rf.count, rf.samples, rf.depth};
    exec::for_each_block(policy, rf.count, 2, 20 * static_cast<float>(rf.samples),
                         [&](std::size_t first, std::size_t end) {
                             const std::size_t n = rf.samples, last = end - 1; // an odd last line is paired with itself
                             std::vector<float> shifted(2 * transform.size());
                             float* one = shifted.data();
                             float* other = one + transform.size();
                             std::copy_n(rf.values.data() + first * n, n, one);
                             std::copy_n(rf.values.data() + last * n, n, other);
                             transform.template apply<width>(one, other);
                             for (const std::size_t line : {first, last}) {
                                 const float* from = rf.values.data() + line * n;
                                 const float* quarter = line == first ? one : other;
                                 float* to = lines.values.data() + line * n;
                                 for (std::size_t i = 0; i < n; ++i)
                                     to[i] = from[i] * from[i] + quarter[i] * quarter[i];
                                 detail::square_roots<width>(to, n);
                             }
                         });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
