#ifndef INSONIFY_SIGNAL_ENVELOPE_HPP
#define INSONIFY_SIGNAL_ENVELOPE_HPP

#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The amplitude of complex lines: |IQ|.
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const iq_lines& iq) {
    scan_lines lines{iq.count, iq.samples, iq.depth};
    exec::for_each_block(policy, lines.values.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) lines.values[i] = length(iq.values[i]);
    });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
