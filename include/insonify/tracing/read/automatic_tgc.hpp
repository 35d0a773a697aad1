#ifndef INSONIFY_TRACING_READ_AUTOMATIC_TGC_HPP
#define INSONIFY_TRACING_READ_AUTOMATIC_TGC_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/laws.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <algorithm>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// What the middle lines of a probe pass, down to the first medium that blocks sound. Medians over the lines.
struct path_survey {
    static constexpr int lines = 15; ///< evenly over the middle half of the field of view
    float attenuation = 0;           ///< mean along the path, dB/m at 1 MHz, one way
    float loss_db = 0;               ///< of an echo from the end of the path, there and back
    float length = 0;                ///< of the path, metres
};

/// @param frequency  hertz
/// @param depth      where paths end, metres
inline path_survey survey_paths(const line_layers& found, float frequency, float depth) {
    path_survey each[path_survey::lines];
    int count = 0;
    for (int i = 0; i < path_survey::lines; ++i) {
        const float fraction = (static_cast<float>(i) + 0.5F) / (2 * path_survey::lines) - 0.25F;
        const float nearest = std::round(line_at_fraction(fraction, found.lines));
        path_survey& own = each[count];
        own = {};
        for (const layer& here : found(static_cast<std::uint32_t>(max(nearest, 0)))) {
            const medium& m = found.media[here.medium];
            if (here.begin >= depth || blocks_sound(m)) break;
            const float part = min(here.end, depth) - here.begin;
            if (!(part > 0)) continue;
            own.length += part;
            own.attenuation += (m.attenuation - own.attenuation) * (part / own.length); // exact in a single medium
            own.loss_db += part * echo_loss(m, frequency);
        }
        if (own.length > 0) ++count;
    }
    if (count == 0) return {};
    const auto median = [&](float path_survey::*of) {
        const auto less = [of](const path_survey& a, const path_survey& b) { return a.*of < b.*of; };
        std::nth_element(each, each + count / 2, each + count, less);
        return each[count / 2].*of;
    };
    return {median(&path_survey::attenuation), median(&path_survey::loss_db), median(&path_survey::length)};
}

} // namespace detail

/// Attenuation that time-gain compensation (TGC) has to make up for, dB/m at 1 MHz, one way: `b_mode` uses it where its
/// `tgc` is 0.
///
/// Each of 15 lines in the middle half of the field of view has a mean attenuation, down to the first medium that
/// blocks sound, such as bone or air. The result is the median of the 15, within 50 to 100, as scanners assume (0.5 to
/// 1 dB/(cm MHz)).
/// @param found  what lies along the lines of the probe
/// @param depth  of the picture, metres
/// @throws usage_error  for layers without lines, or a depth out of range
inline float automatic_tgc(const line_layers& found, float depth) {
    check_depth(depth, "automatic_tgc");
    if (found.lines == 0)
        throw usage_error{"automatic_tgc: the layers have no lines: tracers other than straight_lines find none; call "
                          "find_layers"};
    constexpr float any_frequency = 1e6F; // of losses, which have no part in it
    const detail::path_survey passed = detail::survey_paths(found, any_frequency, depth);
    return clamp(passed.length > 0 ? passed.attenuation : found.media[0].attenuation, 50, 100);
}
/// The same in a scene, whose layers are found.
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
float automatic_tgc(const Policy& policy, const scene& body, const Probe& probe, const pose& at, float depth) {
    detail::check_lines(body, probe.frequency, at, depth, "automatic_tgc");
    const detail::any_policy<false> any{policy};
    return automatic_tgc(detail::layer_search{}(any, body, probe, at, {.depth = depth}, depth, false), depth);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
