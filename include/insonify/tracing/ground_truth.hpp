#ifndef INSONIFY_TRACING_GROUND_TRUTH_HPP
#define INSONIFY_TRACING_GROUND_TRUTH_HPP

#include <insonify/acoustics/attenuation.hpp>
#include <insonify/acoustics/fresnel.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/execution/any_policy.hpp>
#include <insonify/tracing/label.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What is true of every sample: maps of one grid.
struct ground_truth_lines {
    label_lines label{};      ///< id of the object that it lies in, as `label` gives it; `background_label` outside all
    label_lines medium{};     ///< index into `scene::media()`
    label_lines surface{};    ///< id of the object whose surface lies in it; `background_label` where none does
    scan_lines incidence{};   ///< radians between the beam and the normal of that surface; 0 where there is none
    scan_lines transmitted{}; ///< amplitude that arrives there and comes back, 0 to 1: the map of shadows
    scan_lines depth{};       ///< metres along the line, whatever the grid

    friend bool operator==(const ground_truth_lines&, const ground_truth_lines&) = default;
};

/// `ground_truth`, compiled once for all policies.
template <transducer Probe>
ground_truth_lines find_truth(const exec::any_policy<false>& policy, const scene& body, const Probe& probe,
                              const pose& at, const label_settings& settings) {
    const label_axis axis{settings.grid};
    const std::uint32_t samples =
        check_acquisition(body, probe, at, axis, {.depth = settings.depth, .samples = settings.samples});
    const float spacing = settings.depth / static_cast<float>(samples);
    const later_t<Probe, label_lines> ids{probe.lines, samples, settings.depth};
    const later_t<Probe, scan_lines> numbers{probe.lines, samples, settings.depth};
    later_t<Probe, ground_truth_lines> truth{ids, ids, ids, numbers, numbers, numbers};
    std::fill(truth.surface.values.begin(), truth.surface.values.end(), background_label);

    const auto rank_of = [&](const layer& one) {
        return one.place == 0 ? media_stack::none : body.objects()[one.place - 1].rank;
    };
    const auto trace_line = [&](std::uint32_t line, std::uint32_t, const line_frame&, view<const layer> layers) {
        float lost = 0;   // dB, to attenuation
        float passed = 1; // through interfaces
        for_each_stretch(layers, body.media(), axis, samples, spacing, [&](std::size_t i, const label_stretch& part) {
            const layer& here = layers[i];
            const medium& m = body.media()[here.medium];
            if (i > 0 && layers[i - 1].medium != here.medium) {
                const layer& above = layers[i - 1];
                passed *= fresnel{}.energy_transmission(body.media()[above.medium], m, here.cosine);
                const auto k = static_cast<std::uint32_t>(lesser(part.begin / spacing, static_cast<float>(samples)));
                if (k < samples && truth.surface(line, k) == background_label) {
                    truth.surface(line, k) = rank_of(above) < rank_of(here) ? above.object : here.object;
                    // The tilts, because near normal incidence a cosine has no digits left.
                    truth.incidence(line, k) = std::atan(length(vec2{std::tan(here.tilt.x), std::tan(here.tilt.y)}));
                }
            }
            const float loss = echo_loss(m, probe.frequency);
            for (auto k = static_cast<std::uint32_t>(part.first); k < part.last; ++k) {
                const float into = ((static_cast<float>(k) + 0.5F) * spacing - part.begin) / part.scale;
                truth.label(line, k) = here.object;
                truth.medium(line, k) = here.medium;
                truth.transmitted(line, k) = passed * std::pow(10.0F, -(lost + loss * into) / 20);
                truth.depth(line, k) = here.begin + into;
            }
            lost += loss * (here.end - here.begin);
        });
    };
    const elevation_planes middle{beam_of(probe, settings.depth), 1};
    line_workspace found;
    for_each_line(policy, search::best, body, probe, at, middle, axis.reach(settings.depth, body.media()), angles::find,
                  found, 20 * static_cast<float>(samples), trace_line);
    return truth;
}

/// All that a learning pipeline may want to know of a frame, from one trace.
///
///     transmitted = product of T over the interfaces above * 10^(-sum of 2 alpha0 f^b d over the media above / 20)
///
/// T = 1 - r^2 of `fresnel`, what an echo keeps when it crosses twice; alpha0 in dB/m at 1 MHz, f the probe's frequency
/// in MHz, d in metres. It is the amplitude with which `physical` weighs every echo; 1 is what the probe sends.
///
/// A surface counts where the medium changes: water in water has none. Where two objects meet it is that of the object
/// that gives the medium where both are. Of several in one sample the one nearest to the probe is reported.
/// @param at  probe to world: x lateral, y elevation, z depth
/// @return maps of `probe.lines` lines of `settings.samples` samples
/// @throws usage_error     for an unbuilt scene, senseless settings, absurd sizes
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
ground_truth_lines ground_truth(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const label_settings& settings) {
    return find_truth(exec::any_policy<false>{policy}, body, probe, at, settings);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
