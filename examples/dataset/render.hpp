#ifndef INSONIFY_DATASET_RENDER_HPP
#define INSONIFY_DATASET_RENDER_HPP

#include "anatomy.hpp"
#include "hdf5_file.hpp"

namespace dataset {

/// All that is stored of one sample.
struct record {
    sample numbers{};
    pose at{};
    vec2 pitch{0, 0};                  ///< width and height of a pixel, metres
    std::vector<std::uint8_t> image{}; ///< rows x columns
    std::vector<std::uint8_t> label{};
    std::vector<float> incidence{}, transmitted{}, depth{};
    scan_lines envelope{};
    iq_lines iq{};
    std::vector<packed_row> packed{}; ///< the arrays, in the order of `row_kinds`, once they are compressed
};

namespace detail_ {

template <class Probe>
Probe with_settings(Probe probe, const description& d, const sample& s) {
    probe.lines = d.lines;
    probe.frequency = s.frequency * 1_MHz;
    probe.focus = s.focus * 1_mm;
    return presets::in_use(probe);
}

} // namespace detail_

/// Draws a sample with one thread: ranks share the work.
template <transducer Probe>
record render(const Probe& probe, const description& d, const anatomies& all, const sample& s) {
    const auto [body, at] = all.make(probe, d, s);
    b_mode_settings how = presets::settings_for(probe);
    how.depth = s.depth * 1_mm;
    how.size = {d.size, d.size};
    how.dynamic_range_db = s.dynamic_range;
    how.gain_db = s.gain;
    how.tgc = 0;
    how.planes = d.planes;
    how.noise = {.level_db = s.noise, .seed = s.seed};
    how.frame = s.number;
    how.compound.angles = d.looks;
    scanner machine{probe, how};
    const image& picture = machine.scan(exec::unseq, body, at);
    // About one sample for each row of the image, so that no surface falls between two.
    const label_settings maps{.depth = how.depth, .samples = d.size, .grid = label_settings::grid::displayed};
    const auto truth = ground_truth(exec::unseq, body, probe, at, maps);
    const scan_map map =
        make_scan_map(exec::unseq, probe, {.depth = how.depth, .samples = truth.label.samples}, {.size = how.size});

    record made{.numbers = s, .at = at, .pitch = map.pitch};
    made.image.reserve(picture.pixels.size());
    for (const float grey : picture.pixels)
        made.image.push_back(static_cast<std::uint8_t>(clamp(grey, 0, 1) * 255 + 0.5F));
    std::vector<std::uint8_t> label_of_object;
    for (const object& one : body.objects()) {
        const auto id = static_cast<std::uint32_t>(one.id);
        if (label_of_object.size() <= id) label_of_object.resize(id + 1);
        label_of_object[id] = all.labels().of(one.name);
    }
    const label_image labels = scan_convert(exec::unseq, truth.label, map);
    made.label.reserve(labels.pixels.size());
    for (std::size_t i = 0; i < labels.pixels.size(); ++i)
        made.label.push_back(map.first[i] == scan_map::outside      ? label_names::outside
                             : labels.pixels[i] == background_label ? std::uint8_t{0}
                                                                    : label_of_object[labels.pixels[i]]);
    made.incidence = scan_convert_nearest(exec::unseq, truth.incidence, map).pixels;
    made.transmitted = scan_convert_nearest(exec::unseq, truth.transmitted, map).pixels;
    made.depth = scan_convert_nearest(exec::unseq, truth.depth, map).pixels;
    if (d.iq) {
        made.envelope = envelope(exec::unseq, machine.echoes());
        made.iq = machine.echoes();
    }
    return made;
}

inline record render(const description& d, const anatomies& all, const sample& s) {
    if (d.probe == "convex") return render(detail_::with_settings(convex_array{}, d, s), d, all, s);
    if (d.probe == "phased") return render(detail_::with_settings(phased_array{}, d, s), d, all, s);
    return render(detail_::with_settings(linear_array{}, d, s), d, all, s);
}

} // namespace dataset
#endif
