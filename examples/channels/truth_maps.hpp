#ifndef INSONIFY_CHANNELS_TRUTH_MAPS_HPP
#define INSONIFY_CHANNELS_TRUTH_MAPS_HPP

#include <insonify/channels/channel_data.hpp>
#include <insonify/channels/tissue_maps.hpp>
#include "../dataset/hdf5_file.hpp"
#include "arrays.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

/// The truth behind channel data, as maps of files in the layout of zea.
namespace channels {

/// The slice that is traced, from the element that lies furthest back, in steps of half a wavelength, or of as many as
/// give no more than 2^22 pixels.
inline map_grid slice_grid(const named_array& array, const channel_data& data, float depth) {
    constexpr std::size_t max_pixels = std::size_t{1} << 22U;
    const float half = 0.5F * length(data.places.back().origin - data.places.front().origin) +
                       depth * std::tan(array.opening_deg * 1_deg);
    float top = 0; // of the flanks of a convex array
    for (const ray& one : data.places) top = std::min(top, one.origin.z);
    const float step = 0.5F * data.sound_speed / data.frequency;
    for (float spacing = step;; spacing += step) {
        const auto columns = static_cast<std::uint32_t>(2 * half / spacing) + 1;
        const map_grid grid{.from = {-0.5F * static_cast<float>(columns - 1) * spacing, top},
                            .spacing = spacing,
                            .size = {columns, static_cast<std::uint32_t>((depth - top) / spacing) + 1}};
        if (grid.count() <= max_pixels) return grid;
    }
}

/// A number of tissue, or several, at each pixel.
struct truth_map {
    std::string name, unit, description;
    std::vector<std::string> labels{}; ///< of the several; empty: it is one
    /// Of a pixel. @param frequency  of the carrier, hertz
    float (*value)(const tissue_maps& truth, std::size_t pixel, std::size_t label, float frequency);

    /// Its name in a file.
    dataset::map_name in_file() const { return {{"tracks/track_0/data/" + name, unit, description}, labels}; }
    /// Numbers at a pixel.
    std::size_t depth() const { return labels.empty() ? 1 : labels.size(); }
    /// The shape of the values of a frame.
    std::vector<hsize_t> shape(const map_grid& grid) const {
        std::vector<hsize_t> made{grid.size.y, grid.size.x};
        if (!labels.empty()) made.push_back(labels.size());
        return made;
    }
    /// The values of a frame, a chunk for each label.
    std::vector<dataset::packed_chunk> pack(const tissue_maps& truth, float frequency) const {
        std::vector<dataset::packed_chunk> chunks;
        std::vector<float> values(truth.grid.count());
        for (std::size_t label = 0; label < depth(); ++label) {
            for (std::size_t i = 0; i < values.size(); ++i) values[i] = value(truth, i, label, frequency);
            chunks.push_back(dataset::pack(values, dataset::repetitions::any));
        }
        return chunks;
    }
};

/// All but the labels.
inline const std::vector<truth_map>& truth_maps() {
    static const std::vector<truth_map> all{
        {"sos_map",
         "m/s",
         "sound speed of the tissue",
         {},
         [](const tissue_maps& truth, std::size_t i, std::size_t, float) { return truth.sound_speed[i]; }},
        {"attenuation_map",
         "dB/m/Hz",
         "attenuation of the tissue at the carrier, one way, over its frequency",
         {},
         [](const tissue_maps& truth, std::size_t i, std::size_t, float frequency) {
             return truth.attenuation[i] * std::pow(frequency / 1_MHz, truth.attenuation_power[i]) / frequency;
         }},
        {"displacement",
         "m",
         "of the tissue that is now at a pixel, from where it is at rest",
         {"x", "z"},
         [](const tissue_maps& truth, std::size_t i, std::size_t label, float) {
             return truth.displacement[i][static_cast<int>(label)];
         }},
        {"strain",
         dataset::no_unit,
         "of the tissue that is now at a pixel, relative to its size at rest: 0.01 is 1 % longer; shear is half the "
         "sum "
         "of the two derivatives",
         {"lateral", "axial", "shear"},
         [](const tissue_maps& truth, std::size_t i, std::size_t label, float) {
             const slice_strain& one = truth.strain[i];
             return label == 0 ? one.lateral : label == 1 ? one.axial : one.shear;
         }},
    };
    return all;
}

/// What is said of the attenuation beside its map.
inline void add_gamma(dataset::hdf5_file& file) {
    file.add_number({"tracks/track_0/data/attenuation_map/gamma", dataset::no_unit,
                     "exponent of the frequency by which the values are to be multiplied"},
                    1);
}

/// Coordinates of a grid, a chunk for each axis: rows repeat, and are compressed to almost nothing.
inline std::vector<dataset::packed_chunk> pack_coordinates(const map_grid& grid) {
    return dataset::pack_points(grid.size.y, grid.size.x, [&](hsize_t row, hsize_t column) {
        return grid.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
    });
}

} // namespace channels
#endif
