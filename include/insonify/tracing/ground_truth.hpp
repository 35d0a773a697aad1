#ifndef INSONIFY_TRACING_GROUND_TRUTH_HPP
#define INSONIFY_TRACING_GROUND_TRUTH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/interface_law.hpp>
#include <insonify/acoustics/line_refraction.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/propagation.hpp>
#include <insonify/core/decibels.hpp>
#include <insonify/tracing/label.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Ground truth of every sample, as maps on one grid.
struct ground_truth_lines {
    label_lines label{};    ///< id of the object that it lies in, as `label` gives it; `background_label` outside all
    label_lines medium{};   ///< index into `scene::media()`
    label_lines surface{};  ///< id of the object whose surface lies in it; `background_label` where none does
    scan_lines incidence{}; ///< radians between the beam and the normal of that surface; 0 where there is none
    scan_lines
        transmitted{};  ///< amplitude that arrives there along the line and returns, 0 to 1: the map of sharp shadows
    scan_lines depth{}; ///< metres along the line, whatever the grid

    friend bool operator==(const ground_truth_lines&, const ground_truth_lines&) = default;
};

/// A model that states its interface law and its attenuation: `physical` with any laws, and `law2011`.
template <class Model>
concept ground_truth_model = requires(const Model& model, const incidence& at, const medium& m, float frequency) {
    { model.at_interface(at) } -> std::same_as<response>;
    { model.loss(m, frequency) } -> std::convertible_to<float>;
};

namespace detail {

struct truth_sample {
    label_id label = background_label;
    label_id medium = 0;
    label_id surface = background_label;
    float incidence = 0;
    float transmitted = 0;
    float depth = 0;
};

/// A model whose samples are ground truth, under the interface law and the attenuation of another.
template <ground_truth_model Model>
struct truth_model : label_axis {
    using sample_type = truth_sample;
    static constexpr float nanoseconds = 20;

    Model model{};

    template <class Policy>
    INSONIFY_FN void operator()(const Policy&, const traced_line& line, float spacing, view<truth_sample> out) const {
        float lost = 0;   // dB, to attenuation
        float passed = 1; // through interfaces
        line_refraction<Model> refraction{model, line};
        this->for_each_stretch(line, out.size(), spacing, [&](std::size_t i, const label_stretch& part) {
            const layer& here = line.layers[i];
            const medium& m = line.media[here.medium];
            const refracted_layer bent = refraction.next();
            if (i > 0 && line.layers[i - 1].medium != here.medium) {
                const layer& above = line.layers[i - 1];
                passed *= model.at_interface({line.media[above.medium], m, bent.cosine, line.frequency}).transmitted;
                const auto k = static_cast<std::size_t>(min(part.begin / spacing, static_cast<float>(out.size())));
                if (k < out.size() && out[k].surface == background_label) {
                    // Ranks, in which the background comes last: place 0 wraps around.
                    out[k].surface = above.place - 1 < here.place - 1 ? above.object : here.object;
                    // From the slopes, because a cosine loses its digits near normal incidence.
                    out[k].incidence = std::atan(length(here.slope));
                }
            }
            const float per_metre = model.loss(m, line.frequency);
            for (std::size_t k = part.first; k < part.last; ++k) {
                const float into = ((static_cast<float>(k) + 0.5F) * spacing - part.begin) / part.scale;
                out[k].label = here.object;
                out[k].medium = here.medium;
                out[k].transmitted =
                    passed * amplitude_of_decibels(-pulse_loss(model, line, lost + per_metre * bent.length(into)));
                out[k].depth = here.begin + into;
            }
            lost += per_metre * bent.length(here.end - here.begin);
        });
    }
    friend bool operator==(const truth_model&, const truth_model&) = default;
};

} // namespace detail

/// Ground truth of a frame from one trace, for training data and tests.
///
///     transmitted = product of T over the interfaces above * 10^(-P(sum of loss * d over the media above) / 20)
///
/// T is the round-trip transmission of the model's own interface law, `loss` its attenuation in dB/m (there and back for
/// `physical`, by its `travel` for `law2011`, whose result is a fraction of intensity), d the metres of the refracted ray, P
/// what the peak of the pulse loses where the carrier loses so much (`physical::pulse_loss`; `law2011`: the same). It is the amplitude with which the model weights every echo of a line by itself, without the penumbra that the aperture gives
/// to shadows (`straight_lines::directions`); 1 is what the probe sends.
///
/// A surface is where the medium changes: water in water has none. Where two objects meet it is that of the object that
/// has precedence. Of several in one sample the one nearest to the probe is reported.
/// @param at     probe to world: x lateral, y elevation, z depth
/// @param model  the one that the picture is drawn with
/// @return maps of `probe.lines` lines of `settings.samples` samples
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, ground_truth_model Model = physical<>>
ground_truth_lines ground_truth(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                const label_settings& settings, const Model& model = {}) {
    const detail::any_policy<false> any{policy};
    const auto found = trace(any, body, probe, at, detail::truth_model<Model>{{settings.grid}, model},
                             {.depth = settings.depth, .samples = settings.samples});
    const label_lines labels{found.count, found.samples, found.depth};
    const scan_lines numbers{found.count, found.samples, found.depth};
    ground_truth_lines truth{labels, labels, labels, numbers, numbers, numbers};
    exec::for_each_block(any, found.values.size(), 16384, 3, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const detail::truth_sample& one = found.values[i];
            truth.label.values[i] = one.label;
            truth.medium.values[i] = one.medium;
            truth.surface.values[i] = one.surface;
            truth.incidence.values[i] = one.incidence;
            truth.transmitted.values[i] = one.transmitted;
            truth.depth.values[i] = one.depth;
        }
    });
    return truth;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
