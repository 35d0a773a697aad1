#ifndef INSONIFY_SIGNAL_KERNEL_CONVOLVE_HPP
#define INSONIFY_SIGNAL_KERNEL_CONVOLVE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// One coefficient of an FIR filter.
struct tap {
    float weight = 0;
    std::ptrdiff_t offset = 0; ///< of its input sample relative to the result, in complex samples
};

/// Number of samples that `sum_taps` may read beyond those that its results need.
inline constexpr std::size_t tap_room = std::size_t{4} * simd_width;

/// Computes as many results as eight SIMD registers hold; the sums stay in registers.
template <int Width, std::size_t... I>
INSONIFY_INLINE void sum_taps_of_block(view<const tap> taps, const float* from, float* to, std::index_sequence<I...>) {
    lanes<Width> sums[] = {lanes<Width>(static_cast<float>(I - I))...};
    for (const tap& one : taps) {
        const lanes<Width> weight(one.weight);
        const float* at = from + 2 * one.offset;
        ((sums[I] = multiply_add(load<Width>(at + I * Width), weight, sums[I])), ...);
    }
    (store(sums[I], to + I * Width), ...);
}

/// Filters complex samples: to[i] = sum over the taps of weight * from[i + offset].
///
/// @param from  read up to `tap_room` samples beyond what `count` results need
/// @param to    must not overlap the samples read
template <int Width>
void sum_taps(view<const tap> taps, const vec2* from, vec2* to, std::size_t count) {
    constexpr std::size_t block = std::size_t{4} * Width;
    constexpr auto registers = std::make_index_sequence<8>{};
    std::size_t begin = 0;
    for (; begin + block <= count; begin += block)
        sum_taps_of_block<Width>(taps, reinterpret_cast<const float*>(from + begin),
                                 reinterpret_cast<float*>(to + begin), registers);
    if (begin == count) return;
    vec2 last[block];
    sum_taps_of_block<Width>(taps, reinterpret_cast<const float*>(from + begin), reinterpret_cast<float*>(last),
                             registers);
    for (std::size_t i = 0; begin + i < count; ++i) to[begin + i] = last[i];
}

/// FIR filter with the envelope of a pulse along a line of complex samples, with one result for every D samples.
///
/// Result k is at the centre of samples k D to k D + D - 1. A line is stored as D polyphase rows (samples 0, D, 2 D,
/// ..., then 1, D + 1, ...), each padded with zeros, so that a tap reads consecutive samples for consecutive results.
class axial_kernel {
  public:
    /// Recomputes the kernel in the same memory. @param envelope  in units of samples
    void set(std::size_t samples, const pulse_envelope& envelope, std::size_t decimation) {
        decimation_ = decimation;
        results_ = samples / decimation;
        const auto length = static_cast<std::size_t>(min(envelope.length_behind(), static_cast<float>(samples)));
        zeros_ = length / decimation + 1;
        stride_ = results_ + 2 * zeros_ + tap_room;
        taps_.clear();
        const std::size_t begin = zeros_ * decimation; // of the line in one padded row, before it is split into phases
        for (std::size_t at = begin - length; at < begin + length + decimation; ++at) {
            const float centre = static_cast<float>(begin) + 0.5F * static_cast<float>(decimation - 1);
            const float behind = centre - static_cast<float>(at); // the echo of that sample
            if (behind < -envelope.half_length() || behind > envelope.length_behind()) continue;
            taps_.push_back({.weight = envelope(behind),
                             .offset = static_cast<std::ptrdiff_t>(at % decimation * stride_ + at / decimation)});
        }
    }

    /// Size of a polyphase line, in samples.
    std::size_t layout_size() const { return decimation_ * stride_; }

    float nanoseconds() const { return static_cast<float>(results_ * (2 + taps_.size() / 8)); }

    /// Stores a line as polyphase rows. @param layout  zeros, or an earlier line
    void lay_out(const vec2* line, vec2* layout) const {
        for (std::size_t phase = 0; phase < decimation_; ++phase)
            for (std::size_t i = 0; i < results_; ++i)
                layout[phase * stride_ + zeros_ + i] = line[i * decimation_ + phase];
    }

    template <int Width>
    void apply(const vec2* layout, vec2* results) const {
        sum_taps<Width>({taps_.data(), taps_.size()}, layout, results, results_);
    }

  private:
    std::size_t decimation_ = 1;
    std::size_t results_ = 0;
    std::size_t zeros_ = 0;  // padding before and after each row
    std::size_t stride_ = 0; // from row to row
    std::vector<tap> taps_;
};

/// Lateral weights of `convolve` at every depth. Made by `make_lateral_kernel`.
///
/// Computed at the centre of every depth step and interpolated linearly, since steps would add noise.
struct lateral_kernel {
    static constexpr std::uint32_t depth_step = 4; ///< samples

    /// Range of the weights of a depth step in `weights`.
    struct entry {
        std::size_t begin = 0;
        std::size_t count = 0;
        float spacing = 0; ///< distance between lines, metres
    };
    std::uint32_t lines = 1;
    bool full_circle = false;   ///< the last line is next to the first
    double cycles_per_line = 0; ///< `line_advance` of the probe, cycles of the carrier of an echo
    std::vector<entry> entries;
    std::vector<float> weights;
    std::vector<std::ptrdiff_t> less; ///< by distance in lines: samples by which a wave front is less deep there

    /// Weights at a sample: (1 - fraction) of the weights `above` plus `fraction` of those `below`.
    struct blend {
        view<const float> above{};
        view<const float> below{};
        float fraction = 0;
    };
    blend blend_at(std::uint32_t sample) const {
        const table_place place{(static_cast<float>(sample) + 0.5F) / depth_step - 0.5F, entries.size()};
        const entry &above = entries[place.above], &below = entries[place.below];
        return {.above = {weights.data() + above.begin, above.count},
                .below = {weights.data() + below.begin, below.count},
                .fraction = place.part};
    }

    /// The largest of all depths, in lines.
    std::size_t half_width() const {
        std::size_t longest = 1;
        for (const entry& e : entries) longest = std::max(longest, e.count);
        return longest - 1;
    }

    bool steered() const { return cycles_per_line != 0; }
    /// Phase of an echo on a line relative to that on line 0, at the same wave front.
    vec2 phase(std::ptrdiff_t line) const { return turned(cycles_per_line * static_cast<double>(line)); }
};

/// @param scan      depth and samples of the lines; `samples` must not be 0
/// @param recycled  a kernel whose memory is reused
/// @throws usage_error  for an acquisition out of range
inline lateral_kernel make_lateral_kernel(const probe_settings& probe, const acquisition& scan,
                                          lateral_kernel recycled = {}) {
    check_depth(scan.depth, "make_lateral_kernel");
    const beam_model beam = make_beam(probe, scan.depth);
    if (scan.samples == 0) throw usage_error{"make_lateral_kernel: `samples` is 0; it must be that of the lines"};
    constexpr std::uint32_t step = lateral_kernel::depth_step;
    lateral_kernel kernel = std::move(recycled);
    kernel.lines = probe.lines;
    kernel.full_circle = probe.full_circle;
    const float advance = probe.advance();
    kernel.cycles_per_line = 2.0 * static_cast<double>(probe.frequency) * static_cast<double>(advance / display_speed);
    auto& entries = kernel.entries;
    auto& weights = kernel.weights;
    entries.clear();
    weights.clear();
    const std::uint32_t last = kernel.full_circle ? (probe.lines - 1) / 2 : probe.lines - 1;
    for (std::uint32_t sample = 0; sample < scan.samples; sample += step) {
        const float depth = (static_cast<float>(sample) + 0.5F * step) * scan.depth / static_cast<float>(scan.samples);
        const float sigma = beam.lateral_sigma(depth), lobe = beam.side_lobe_width(depth);
        const float spacing = probe.spacing(depth);
        const float max_sigmas =
            max(kernel_sigmas, beam.side_lobes > 0 ? beam_model::side_lobe_extent * lobe / sigma : 0);
        const std::size_t begin = weights.size();
        double sum = 0;
        for (std::uint32_t offset = 0; offset <= last; ++offset) {
            const float apart = static_cast<float>(offset) * spacing, sigmas = apart / sigma;
            if (sigmas > max_sigmas) break;
            weights.push_back(std::exp(-0.5F * sigmas * sigmas) + beam.side_lobe(apart / lobe));
            sum += (offset == 0 ? 1 : 2) * static_cast<double>(weights.back());
        }
        const std::size_t end = weights.size();
        for (std::size_t i = begin; i < end; ++i)
            weights[i] = static_cast<float>(static_cast<double>(weights[i]) / sum);
        entries.push_back({.begin = begin, .count = end - begin, .spacing = spacing});
    }
    const float samples_per_line = advance * static_cast<float>(scan.samples) / scan.depth;
    kernel.less.resize(kernel.half_width() + 1);
    for (std::size_t i = 0; i < kernel.less.size(); ++i)
        kernel.less[i] = static_cast<std::ptrdiff_t>(std::lround(samples_per_line * static_cast<float>(i)));
    return kernel;
}

/// A copy of a few consecutive samples of every line, for filtering across the lines. H: half width of the kernel.
///
///     line  -H ... -1 | 0 ... lines - 1 | lines ... lines - 1 + H
///           zeros, or for a full circle the lines from the other end
///
/// SIMD works along the line: each sample has its own weights. Across steered lines the filter follows the wave front:
/// it reads neighbours a few samples above or below, with the phase that they have at the same wave front.
class lateral_slab {
  public:
    static constexpr std::size_t samples = 32;

    /// @param memory  scratch memory; grows as needed
    lateral_slab(const lateral_kernel& kernel, std::vector<vec2>& memory)
        : kernel_{kernel}, lines_{kernel.lines}, half_width_{kernel.half_width()},
          margin_{static_cast<std::size_t>(std::abs(kernel.less.back()))}, stride_{samples + 2 * margin_} {
        memory.resize(2 * (half_width_ + 1) * samples + (lines_ + 2 * half_width_) * stride_);
        weights_ = memory.data();
        tails_ = weights_ + (half_width_ + 1) * samples;
        values_ = tails_ + (half_width_ + 1) * samples;
        std::fill(values_, values_ + (lines_ + 2 * half_width_) * stride_, vec2{0, 0});
    }

    /// Computes the weights of samples `first` to `first` + `count` - 1.
    void weigh(std::size_t first, std::size_t count) {
        std::fill(weights_, values_, vec2{0, 0});
        for (std::size_t k = 0; k < count; ++k) {
            const lateral_kernel::blend at = kernel_.blend_at(static_cast<std::uint32_t>(first + k));
            for (std::size_t i = 0; i < at.above.size(); ++i)
                weights_[i * samples + k] += (1 - at.fraction) * at.above[i];
            for (std::size_t i = 0; i < at.below.size(); ++i) weights_[i * samples + k] += at.fraction * at.below[i];
        }
        for (std::size_t i = half_width_; i-- > 0;) // sum of the weights of the neighbours beyond the i-th
            for (std::size_t k = 0; k < samples; ++k)
                tails_[i * samples + k] = tails_[(i + 1) * samples + k] + weights_[(i + 1) * samples + k];
    }

    /// Copies samples of all lines.
    /// @param stride  from line to line
    /// @param before  samples of the lines before `from`
    /// @param after   samples of the lines after these
    void copy(const vec2* from, std::size_t stride, std::size_t count, std::size_t before = 0, std::size_t after = 0) {
        const std::size_t above = std::min(before, margin_), below = std::min(after, margin_);
        const auto beyond = static_cast<std::ptrdiff_t>(kernel_.full_circle ? half_width_ : 0);
        const auto lines = static_cast<std::ptrdiff_t>(lines_);
        for (std::ptrdiff_t line = -beyond; line < lines + beyond; ++line) {
            const vec2* source = from + static_cast<std::size_t>((line + lines) % lines) * stride - above;
            vec2* const to = row(line);
            std::fill(to - margin_, to - above, vec2{0, 0});
            std::copy_n(source, above + count + below, to - above);
            std::fill(to + count + below, to + samples + margin_, vec2{0, 0});
            if (kernel_.steered()) turn(to - above, above + count + below, kernel_.phase(-line));
        }
    }

    /// Filters across the lines; the weights are normalized over the lines that exist.
    /// @param to      in place only where lines are not steered
    template <int Width>
    void apply(vec2* to, std::size_t stride, std::size_t count) const {
        vec2 sums[samples];
        for (std::size_t line = 0; line < lines_; ++line) {
            const std::size_t after = lines_ - 1 - line;
            const bool whole = kernel_.full_circle || (line >= half_width_ && after >= half_width_);
            vec2* out = whole && count == samples ? to + line * stride : sums;
            const vec2* const here = row(static_cast<std::ptrdiff_t>(line));
            for (std::size_t part = 0; part < samples; part += std::size_t{4} * Width)
                sum_neighbours<Width>(here + part, weights_ + part, out + part, std::make_index_sequence<8>{});
            if (!whole)
                for (std::size_t k = 0; k < count; ++k)
                    sums[k] /= 1 - (line < half_width_ ? tails_[line * samples + k].x : 0) -
                               (after < half_width_ ? tails_[after * samples + k].x : 0);
            if (out == sums) std::copy_n(sums, count, to + line * stride);
            if (kernel_.steered()) turn(to + line * stride, count, kernel_.phase(static_cast<std::ptrdiff_t>(line)));
        }
    }

  private:
    vec2* row(std::ptrdiff_t line) const {
        return values_ + (static_cast<std::ptrdiff_t>(half_width_) + line) * static_cast<std::ptrdiff_t>(stride_) +
               margin_;
    }

    static void turn(vec2* values, std::size_t count, vec2 phase) {
        for (std::size_t k = 0; k < count; ++k) values[k] = complex_product(values[k], phase);
    }

    // As many samples as eight SIMD registers hold; the sums stay in registers.
    template <int Width, std::size_t... I>
    INSONIFY_INLINE void sum_neighbours(const vec2* here, const vec2* weights, vec2* to,
                                        std::index_sequence<I...>) const {
        const auto floats = [](const vec2* at) { return reinterpret_cast<const float*>(at); };
        lanes<Width> sums[] = {load<Width>(floats(here) + I * Width) * load<Width>(floats(weights) + I * Width)...};
        const std::ptrdiff_t* const less_deep = kernel_.less.data();
        for (std::size_t apart = 1; apart <= half_width_; ++apart) {
            const std::ptrdiff_t less = less_deep[apart];
            const float *left = floats(here - apart * stride_ + less), *right = floats(here + apart * stride_ - less),
                        *weight = floats(weights + apart * samples);
            ((sums[I] = multiply_add(load<Width>(left + I * Width) + load<Width>(right + I * Width),
                                     load<Width>(weight + I * Width), sums[I])),
             ...);
        }
        (store(sums[I], reinterpret_cast<float*>(to) + I * Width), ...);
    }

    const lateral_kernel& kernel_;
    std::size_t lines_ = 0;
    std::size_t half_width_ = 0;
    std::size_t margin_ = 0;  // samples above and below that steered lines need
    std::size_t stride_ = 0;  // from line to line of the copy
    vec2* weights_ = nullptr; // by distance in lines, that of each sample twice: for x and y
    vec2* tails_ = nullptr;   // by distance in lines: sum of the weights beyond
    vec2* values_ = nullptr;
};

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

/// Options of `convolve`.
struct convolve_settings {
    std::uint32_t decimation = 1; ///< samples per result; a divisor of the number of samples
};

/// `convolve`, frame after frame: holds tables and memory, so that it allocates only while buffers grow.
class convolver {
  public:
    /// See `insonify::convolve`.
    template <exec::policy Policy, transducer Probe>
    iq_lines convolve(const Policy& policy, iq_lines echoes, const pulse& sent, const Probe& probe,
                      const convolve_settings& settings = {}) {
        const detail::probe_settings own{probe};
        sent.check(probe.frequency);
        detail::check_echoes(echoes, probe.lines, "convolve");
        check_depth(echoes.depth, "convolve");
        if (settings.decimation == 0 || echoes.samples % settings.decimation != 0)
            throw usage_error{"convolve: decimation is ", settings.decimation,
                              "; it must be a divisor of the number of samples, ", echoes.samples};
        const float per_metre = static_cast<float>(echoes.samples) / echoes.depth;
        pulse_envelope envelope = sent.envelope(probe.frequency);
        envelope.sigma *= per_metre;
        envelope.burst *= per_metre;
        const auto decimation = static_cast<float>(settings.decimation);
        if (!(envelope.sigma * 1.0001F >= decimation)) {
            const float needed = min(std::ceil(static_cast<float>(echoes.samples) * decimation / envelope.sigma), 1e9F);
            throw usage_error{"convolve: the samples are too coarse for the pulse; a line needs at least ",
                              static_cast<std::uint32_t>(needed), " (twice as many are usual)",
                              settings.decimation > 1 ? ", or a smaller `decimation`" : ""};
        }

        iq_lines lines = along(policy, std::move(echoes), envelope, settings.decimation);
        lateral_ =
            detail::make_lateral_kernel(own, {.depth = lines.depth, .samples = lines.samples}, std::move(lateral_));
        return across(policy, std::move(lines));
    }

  private:
    template <exec::policy Policy>
    iq_lines along(const Policy& policy, iq_lines echoes, const pulse_envelope& sent, std::uint32_t decimation);
    template <exec::policy Policy>
    iq_lines across(const Policy& policy, iq_lines lines);
    // Calls body(begin, end, memory) for blocks of eight.
    template <class Policy, class Body>
    void for_each_block(const Policy& policy, std::size_t count, float nanoseconds, const Body& body) {
        if (blocks_.size() < count / 8 + 1) blocks_.resize(count / 8 + 1);
        exec::for_each_block(policy, count, 8, nanoseconds,
                             [&](std::size_t begin, std::size_t end) { body(begin, end, blocks_[begin / 8]); });
    }

    detail::lateral_kernel lateral_{};        // weights across the lines
    detail::axial_kernel axial_{};            // weights along a line
    std::vector<std::vector<vec2>> blocks_{}; // scratch memory of each block of lines or samples
    iq_lines decimated_{};                    // the lines of the previous frame
    iq_lines steered_{};                      // lines that cannot be filtered in place
};

// The axial half of `convolve`; in place without decimation.
// @param sent  in units of samples
template <exec::policy Policy>
iq_lines convolver::along(const Policy& policy, iq_lines echoes, const pulse_envelope& sent, std::uint32_t decimation) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    axial_.set(echoes.samples, sent, decimation);
    if (decimation > 1) decimated_.reshape(echoes.count, echoes.samples / decimation, echoes.depth);
    iq_lines& results = decimation > 1 ? decimated_ : echoes;
    for_each_block(policy, echoes.count, axial_.nanoseconds(),
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
iq_lines convolver::across(const Policy& policy, iq_lines lines) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    constexpr std::size_t thickness = detail::lateral_slab::samples;
    const std::size_t slabs = (lines.samples + thickness - 1) / thickness;
    const bool in_place = !lateral_.steered();
    if (!in_place) steered_.reshape(lines.count, lines.samples, lines.depth);
    iq_lines& results = in_place ? lines : steered_;
    const float slab_time = 0.2F * static_cast<float>((2 * lateral_.half_width() + 1) * lines.count * thickness);
    for_each_block(policy, slabs, slab_time, [&](std::size_t begin, std::size_t end, std::vector<vec2>& memory) {
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

/// Convolves echoes with the point-spread function of the probe: the pulse along each line, the beam across the lines.
///
/// Axial: the pulse envelope, with peak 1. Lateral: a Gaussian of width `beam_model::lateral_sigma` along the wave
/// front, at right angles to the lines (`line_advance`), whose weights sum to 1 over the lines that exist, at the ends
/// as well. So a plate keeps its amplitude at every depth, sampling and line spacing. Lines are zero beyond their ends,
/// so speckle fades within two standard deviations of the pulse from them. In place: pass std::move(echoes).
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
