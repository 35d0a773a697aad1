#ifndef INSONIFY_SCENE_PATH_ATTENUATION_HPP
#define INSONIFY_SCENE_PATH_ATTENUATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/attenuation.hpp>
#include <insonify/probe/plausible.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/scene.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Whether almost no sound passes from tissue into a medium of so small an impedance: gas, inflated lung.
INSONIFY_FN inline bool is_gas(const medium& m) { return m.impedance() < 3e5F; }
/// Whether almost no sound passes between tissue and this medium: gas, bone, metal.
INSONIFY_FN inline bool blocks_sound(const medium& m) { return m.impedance() > 3e6F || is_gas(m); }

/// What the middle lines of a probe pass, down to the first medium that blocks sound. Medians over the lines.
struct path_survey {
    static constexpr int lines = 15; ///< evenly over the middle half of the field of view
    float attenuation = 0;           ///< mean along the path, dB/m at 1 MHz, one way
    float loss_db = 0;               ///< of an echo from the end of the path, there and back
    float length = 0;                ///< of the path, metres
};

template <transducer Probe>
path_survey survey_paths(const scene_view& flat, const Probe& probe, const pose& at, float depth) {
    crossing crossings[256];
    std::uint32_t inside[64];
    layer layers[256];
    float attenuation[path_survey::lines], loss[path_survey::lines], length[path_survey::lines];
    int count = 0;
    for (int i = 0; i < path_survey::lines; ++i) {
        const float fraction = (static_cast<float>(i) + 0.5F) / (2 * path_survey::lines) - 0.25F;
        const ray beam = probe.beam(line_at_fraction(fraction, probe.lines));
        const line_frame line{.origin = at.point(beam.origin), .along = at.direction(beam.direction)};
        line_crossings found{.room = {crossings, 256}, .inside = {.ranks = {inside, 64}}};
        if (!find_crossings(flat, {line.origin, line.along}, depth, found)) continue;
        float path = 0, mean = 0, decibels = 0;
        for (const layer& here : stack_layers(flat, line, depth, found, {layers, 256}, false)) {
            const medium& m = flat.media[here.medium];
            if (blocks_sound(m)) break;
            const float part = here.end - here.begin;
            if (!(part > 0)) continue;
            path += part;
            mean += (m.attenuation - mean) * (part / path); // exact in a single medium
            decibels += part * echo_loss(m, probe.frequency);
        }
        if (!(path > 0)) continue;
        attenuation[count] = mean;
        loss[count] = decibels;
        length[count++] = path;
    }
    if (count == 0) return {};
    const auto median = [count](float* values) {
        std::nth_element(values, values + count / 2, values + count);
        return values[count / 2];
    };
    return {.attenuation = median(attenuation), .loss_db = median(loss), .length = median(length)};
}

} // namespace detail

/// Attenuation that time-gain compensation (TGC) has to make up for, dB/m at 1 MHz, one way: `b_mode` uses it where its
/// `tgc` is 0.
///
/// Each of 15 lines in the middle half of the field of view has a mean attenuation, down to the first medium that blocks
/// sound, such as bone or air. The result is the median of the 15, within 50 to 100, as scanners assume (0.5 to 1
/// dB/(cm MHz)). Lines with more than 256 surfaces do not count.
/// @param depth  of the picture, metres
/// @throws usage_error  for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
float automatic_tgc(const Policy& policy, const scene& body, const Probe& probe, const pose& at, float depth) {
    probe.check();
    check_depth(depth, "automatic_tgc");
    if (!is_rigid(at))
        throw geometry_error{"automatic_tgc: the pose of the probe is not a rigid transform; make it with look_at, or "
                             "mend it with orthonormalised"};
    const detail::path_survey passed = detail::survey_paths(body.view_for_rays(policy), probe, at, depth);
    return clamp(passed.length > 0 ? passed.attenuation : body.background().attenuation, 50, 100);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
