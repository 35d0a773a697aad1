#ifndef INSONIFY_DATASET_RENDER_HPP
#define INSONIFY_DATASET_RENDER_HPP

#include "acquisition.hpp"
#include "hdf5_file.hpp"
#include "specimen.hpp"
#include <optional>

namespace dataset {

/// The face of a probe, and its beam: what the options do not say.
struct face {
    enum class kind { linear, convex, phased };
    kind shape = kind::linear;
    float width = 0;         ///< metres; along the arc where it is curved
    float radius = 0;        ///< metres; 0: flat
    float field_of_view = 0; ///< of a sector, radians; 0: parallel lines
    float fnumber = 0;
    float elevation_height = 0, elevation_focus = 0; ///< metres
    float bandwidth = 0;                             ///< at -6 dB, as a fraction of the frequency
};

/// All that is stored of one sample.
struct record {
    sample numbers{};
    anatomy::values parameters{}; ///< of the region
    bending bend{};
    std::vector<vec2> factors{}; ///< of attenuation and backscatter, for each label but the needle
    pose at{};                   ///< of the probe
    bool on_surface = true;      ///< false: the probe's place is beside the anatomy
    contact touch{};             ///< of the probe, where it is pressed
    face probe{};
    vec2 centre{0, 0};                 ///< of the image, {x, z} in the frame of the probe, metres
    vec2 pitch{0, 0};                  ///< width and height of a pixel, metres
    std::vector<std::uint8_t> image{}; ///< rows x columns
    std::vector<std::uint8_t> label{};
    std::vector<float> incidence{}, transmitted{}, depth{};
    iq_lines iq{};                                   ///< on the lines of the probe
    std::vector<ray> beams{};                        ///< those lines
    std::vector<float> channels{};                   ///< transmits x samples x elements
    tissue_maps tissue{};                            ///< on the slice of the array of those
    std::vector<std::vector<packed_chunk>> packed{}; ///< the arrays of `layout`, once they are compressed
};

/// Calls visit(probe) with the probe of a sample.
template <class Visit>
auto with_probe(const description& d, const anatomy::view& seen, const sample& s, const Visit& visit) {
    return std::visit(
        [&](auto probe) {
            probe.lines = d.lines;
            probe.frequency = s.frequency * 1_MHz;
            probe.focus = s.focus * 1_mm;
            return visit(presets::in_use(probe));
        },
        array_of(d, seen));
}

/// Samples along each line of IQ: as many as the deepest image at the highest frequency needs, so that all have as many.
inline std::uint32_t line_samples(const description& d, const anatomies& all) {
    std::uint32_t largest = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = 0; k < all[i].views().size(); ++k) {
            const anatomy::view& seen = all[i].views()[k];
            const limits_of_sample deepest_limits = limits_of(d, seen, all[i].deepest(k));
            with_probe(d, seen, {.frequency = deepest_limits.frequency}, [&](const auto& probe) {
                largest = std::max(
                    largest, samples_for(deepest_limits.depth * 1_mm, nominal_pulse(probe).sigma_z(probe.frequency)));
            });
        }
    return largest;
}

template <class Probe>
face face_of(const Probe& probe) {
    face made{.width = probe.aperture(),
              .fnumber = probe.fnumber,
              .elevation_height = probe.elevation_height,
              .elevation_focus = probe.elevation_focus,
              .bandwidth = probe.bandwidth};
    if constexpr (requires { probe.field_of_view; }) {
        made.shape = face::kind::phased;
        made.field_of_view = probe.field_of_view;
    }
    if constexpr (requires { probe.radius; }) {
        made.shape = face::kind::convex;
        made.radius = probe.radius;
    }
    return made;
}

/// The echoes of a sample on the lines of the probe itself: those of the straight look.
template <transducer Probe>
iq_lines own_echoes(const scanner<Probe>& machine) {
    return resample_lines(exec::unseq, machine.echoes(), machine.echo_probe(), machine.probe);
}

/// Draws a sample with one thread: others draw other samples.
template <transducer Probe>
record render(const Probe& probe, const description& d, const anatomies& all,
              const std::optional<acquisition>& recorded, const specimen& of, sample s) {
    placement placed = place(d, all, of, probe, s);
    const scene& body = placed.body;
    const pose& at = placed.at;
    record drawn{.numbers = s,
                 .parameters = of.parameters,
                 .bend = of.bend,
                 .factors = of.factors,
                 .at = at,
                 .on_surface = placed.on_surface,
                 .touch = placed.touch,
                 .probe = face_of(probe)};
    const anatomy::view& seen = of.views[s.at.view];
    b_mode_settings how = d.probe.empty() ? seen.settings : presets::settings_for(probe);
    how.depth = s.depth * 1_mm;
    how.size = {d.size, d.size};
    how.dynamic_range_db = s.dynamic_range;
    how.gain_db = s.gain;
    how.tgc = 0;
    how.planes = d.planes;
    how.noise = {.level_db = s.noise, .seed = s.seed};
    how.frame = s.number;
    if (d.iq) how.samples = line_samples(d, all);
    scanner machine{probe, how};
    if (d.iq && d.looks % 2 == 0) { // none of the looks is straight
        machine.settings.compound.angles = 1;
        machine.scan(exec::unseq, body, at);
        drawn.iq = own_echoes(machine);
    }
    machine.settings.compound.angles = d.looks;
    const image& picture = machine.scan(exec::unseq, body, at);
    if (d.iq && d.looks % 2 == 1) drawn.iq = own_echoes(machine);
    for (std::uint32_t line = 0; line < drawn.iq.count; ++line)
        drawn.beams.push_back(probe.beam(static_cast<float>(line)));

    if (recorded) drawn.channels = recorded->record(body, at, s.number);
    if (recorded && !d.no_truth) drawn.tissue = map_tissue(exec::unseq, body, at, recorded->grid());

    // About one sample for each row of the image, so that no surface falls between two.
    const label_settings maps{.depth = how.depth, .samples = d.size, .grid = label_settings::depth_grid::displayed};
    const auto truth = ground_truth(exec::unseq, body, probe, at, maps);
    const scan_map map =
        make_scan_map(exec::unseq, probe, {.depth = how.depth, .samples = truth.label.samples}, {.size = how.size});
    drawn.centre = map.centre;
    drawn.pitch = map.pitch;
    drawn.image.reserve(picture.pixels.size());
    for (const float grey : picture.pixels)
        drawn.image.push_back(static_cast<std::uint8_t>(clamp(grey, 0, 1) * 255 + 0.5F));
    const label_image labels = scan_convert(exec::unseq, truth.label, map);
    drawn.label.reserve(labels.pixels.size());
    for (std::size_t i = 0; i < labels.pixels.size(); ++i)
        drawn.label.push_back(map.first[i] == scan_map::outside      ? label_names::outside
                              : labels.pixels[i] == background_label ? std::uint8_t{0}
                                                                     : of.labels[labels.pixels[i]]);
    if (d.no_truth) return drawn;
    drawn.incidence = scan_convert_nearest(exec::unseq, truth.incidence, map).pixels;
    drawn.transmitted = scan_convert_nearest(exec::unseq, truth.transmitted, map).pixels;
    drawn.depth = scan_convert_nearest(exec::unseq, truth.depth, map).pixels;
    return drawn;
}

inline record render(const description& d, const anatomies& all, const std::optional<acquisition>& recorded,
                     const specimen& of, const spot& at) {
    const anatomy::view& seen = of.views[at.view];
    const sample s = draw_sample(d, at, seen);
    return with_probe(d, seen, s, [&](const auto& probe) { return render(probe, d, all, recorded, of, s); });
}

/// Draws samples one after the other, and keeps the body for the next.
class renderer {
  public:
    renderer(const description& d, const anatomies& all) : d_{d}, all_{all}, recorded_{acquisition_of(d, all)} {}

    record operator()(std::uint32_t number) {
        const spot at = all_.place_of(number);
        if (!of_ || !anatomies::share_body(of_->at, at)) of_ = make_specimen(d_, all_, at);
        return render(d_, all_, recorded_, *of_, at);
    }

  private:
    const description& d_;
    const anatomies& all_;
    std::optional<acquisition> recorded_;
    std::optional<specimen> of_{};
};

} // namespace dataset
#endif
