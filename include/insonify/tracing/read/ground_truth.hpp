#ifndef INSONIFY_TRACING_READ_GROUND_TRUTH_HPP
#define INSONIFY_TRACING_READ_GROUND_TRUTH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/core/units.hpp>
#include <insonify/tracing/read/label.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Ground truth of every sample, as maps on one grid.
struct ground_truth_lines {
    label_lines label{};      ///< id of the object that it lies in, as `label` gives it; `background_label` outside all
    label_lines medium{};     ///< index into `scene::media()`
    label_lines surface{};    ///< id of the object whose surface lies in it; `background_label` where none does
    scan_lines incidence{};   ///< radians between the beam and the normal of that surface; 0 where there is none
    scan_lines transmitted{}; ///< amplitude that arrives there along the line and returns, 0 to 1: sharp shadows
    scan_lines depth{};       ///< metres along the line, whatever the grid

    friend bool operator==(const ground_truth_lines&, const ground_truth_lines&) = default;
};

/// A model that states its interface law and its attenuation: `physical` with any laws, and `law2011`.
template <class Model>
concept ground_truth_model = requires(const Model& model, const incidence& at, const medium& m, float frequency) {
    { model.at_interface(at) } -> std::same_as<response>;
    { model.loss(m, frequency) } -> std::convertible_to<float>;
};

/// Ground truth of a frame, for training data and tests.
///
///     transmitted = product of T over the interfaces above * 10^(-P(sum of loss * d over the media above) / 20)
///
/// T is the round-trip transmission of the model's own interface law, `loss` its attenuation in dB/m (there and back
/// for `physical`, by its `travel` for `law2011`, whose result is a fraction of intensity), d the metres of the
/// refracted ray, P what the peak of the pulse loses where the carrier loses so much (`physical::pulse_loss`;
/// `law2011`: the same). It is the amplitude with which the model weights every echo of a line by itself, without the
/// penumbra that the aperture gives to shadows (`straight_lines::directions`); 1 is what the probe sends.
///
/// A surface is where the medium changes: water in water has none. Where two objects meet it is that of the object that
/// has precedence. Of several in one sample the one nearest to the probe is reported.
/// @param at     probe to world: x lateral, y elevation, z depth
/// @param model  the one that the picture is drawn with
/// @return maps of `probe.lines` lines of `settings.samples` samples
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, ground_truth_model Model>
ground_truth_lines ground_truth(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const Model& model, const label_settings& settings) {
    const detail::any_policy<false> any{policy};
    if constexpr (requires { model.check(); }) model.check();
    const std::uint32_t samples = detail::check_labels(body, probe, at, settings, "ground_truth");
    detail::layer_search search;
    const line_layers& found = detail::layers_for_labels(any, body, probe, at, settings, true, search);
    const label_lines labels{probe.lines, samples, settings.depth};
    const scan_lines numbers{probe.lines, samples, settings.depth};
    ground_truth_lines truth{labels, labels, labels, numbers, numbers, numbers};
    std::fill(truth.surface.values.begin(), truth.surface.values.end(), background_label);
    const float spacing = settings.depth / static_cast<float>(samples);
    exec::for_each_in_blocks(
        any, found.lines, detail::lines_per_block, 20 * static_cast<float>(samples), [&](std::size_t index) {
            const auto number = static_cast<std::uint32_t>(index);
            const traced_line line{.layers = found(number),
                                   .media = found.media,
                                   .frequency = probe.frequency,
                                   .frame = found.frame(number),
                                   .pulse_sigma = nominal_pulse(probe).sigma_z(probe.frequency),
                                   .bandwidth = fractional_bandwidth(probe)};
            float lost = 0;   // dB, to attenuation
            float passed = 1; // through interfaces
            detail::line_refraction<Model> refraction{model, line};
            const auto visit = [&](std::size_t i, const detail::label_stretch& part) {
                const layer& here = line.layers[i];
                const medium& m = line.media[here.medium];
                const detail::refracted_layer bent = refraction.next();
                if (i > 0 && line.layers[i - 1].medium != here.medium) {
                    const layer& above = line.layers[i - 1];
                    passed *=
                        model.at_interface({line.media[above.medium], m, bent.cosine, line.frequency}).transmitted;
                    const auto k = static_cast<std::uint32_t>(min(part.begin / spacing, static_cast<float>(samples)));
                    if (k < samples && truth.surface(number, k) == background_label) {
                        // Ranks, in which the background comes last: place 0 wraps around.
                        truth.surface(number, k) = above.place - 1 < here.place - 1 ? above.object : here.object;
                        // From the slopes, because a cosine loses its digits near normal incidence.
                        truth.incidence(number, k) = std::atan(length(here.slope));
                    }
                }
                const float per_metre = model.loss(m, line.frequency);
                for (auto k = static_cast<std::uint32_t>(part.first); k < part.last; ++k) {
                    const float into = ((static_cast<float>(k) + 0.5F) * spacing - part.begin) / part.scale;
                    truth.label(number, k) = here.object;
                    truth.medium(number, k) = here.medium;
                    truth.transmitted(number, k) =
                        passed *
                        amplitude_of_decibels(-detail::pulse_loss(model, line, lost + per_metre * bent.length(into)));
                    truth.depth(number, k) = here.begin + into;
                }
                lost += per_metre * bent.length(here.end - here.begin);
            };
            detail::for_each_stretch(line.layers, line.media, settings.grid, samples, spacing, visit);
        });
    return truth;
}

/// The same under `physical`.
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe>
ground_truth_lines ground_truth(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const label_settings& settings) {
    return ground_truth(policy, body, probe, at, physical<>{}, settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
