#ifndef INSONIFY_SIGNAL_TAPS_HPP
#define INSONIFY_SIGNAL_TAPS_HPP

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// Gaussian kernels are cut off at so many standard deviations: e^-8 or -69 dB.
inline constexpr float kernel_sigmas = 4;

/// One weight of a filter.
struct tap {
    float weight = 0;
    std::ptrdiff_t offset = 0; ///< in complex samples, from the sample that has the number of the result
};

/// So many results of a filter are worked on at a time.
inline constexpr std::size_t tap_block = 32;

/// Adds four taps to the sums of a block, all as plain floats.
///
/// A function of its own: merged into the loop over the taps, GCC would vectorise that one instead, with gathers.
template <int Width>
[[gnu::noinline]] void add_four_taps(const tap (&taps)[4], const float* from, float* sums) {
    using floats = lanes<Width>;
    const floats w0(taps[0].weight), w1(taps[1].weight), w2(taps[2].weight), w3(taps[3].weight);
    const float *from0 = from + 2 * taps[0].offset, *from1 = from + 2 * taps[1].offset;
    const float *from2 = from + 2 * taps[2].offset, *from3 = from + 2 * taps[3].offset;
    for (std::size_t i = 0; i < 2 * tap_block; i += Width)
        store(load<Width>(sums + i) + w0 * load<Width>(from0 + i) + w1 * load<Width>(from1 + i) +
                  w2 * load<Width>(from2 + i) + w3 * load<Width>(from3 + i),
              sums + i);
}

/// Filters complex samples: to[i] = sum over the taps of weight * from[i + offset].
///
/// @tparam Width  floats that are worked on at once
/// @param from  is read as far as if `count` were rounded up to whole blocks
/// @param to    must not overlap what is read
template <int Width>
void sum_taps(view<const tap> taps, const vec2* from, vec2* to, std::size_t count) {
    for (std::size_t begin = 0; begin < count; begin += tap_block) {
        vec2 sums[tap_block] = {};
        for (std::size_t first = 0; first < taps.size(); first += 4) {
            tap four[4];
            for (std::size_t i = 0; i < 4; ++i)
                four[i] = first + i < taps.size() ? taps[first + i] : tap{.offset = taps[first].offset};
            add_four_taps<Width>(four, reinterpret_cast<const float*>(from + begin), reinterpret_cast<float*>(sums));
        }
        const std::size_t results = count - begin < tap_block ? count - begin : tap_block;
        for (std::size_t i = 0; i < results; ++i) to[begin + i] = sums[i];
    }
}

} // namespace insonify::inline INSONIFY_ABI
#endif
