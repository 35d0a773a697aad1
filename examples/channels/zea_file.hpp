#ifndef INSONIFY_CHANNELS_ZEA_FILE_HPP
#define INSONIFY_CHANNELS_ZEA_FILE_HPP

#include <insonify/core/version.hpp>
#include "../dataset/hdf5_file.hpp"
#include "../dataset/quaternion.hpp"
#include "recording.hpp"
#include "scan_groups.hpp"
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

/// Channel data in the layout of zea.
namespace channels {

namespace detail {

inline void add_pose(hdf5_file& file, const pose& at, std::uint32_t frames) {
    const std::string to = "metadata/probe_pose";
    file.add_group("metadata", "of the frames");
    file.add_group(to, "from the probe to the body, a row for each frame");
    file.add_text({to + "/rotation_representation", no_unit, "w first"}, "quaternion_wxyz");
    file.add_number({to + "/start_time_offset", "s", "frames are no moments of time"}, 0);
    file.add_number({to + "/sampling_frequency", "Hz", "frames are no moments of time"}, 1);
    const std::array<float, 4> turn = dataset::quaternion(at.rotation);
    std::vector<float> places, turns;
    for (std::uint32_t frame = 0; frame < frames; ++frame) {
        places.insert(places.end(), {at.translation.x, at.translation.y, at.translation.z});
        turns.insert(turns.end(), turn.begin(), turn.end());
    }
    file.add_array({to + "/translation", "m", "of the middle of the face"}, number_type::real, {frames, 3},
                   places.data());
    file.add_array({to + "/rotation", no_unit, "from the probe to the body"}, number_type::real, {frames, 4},
                   turns.data());
}

// The slice that is traced, in steps of half a wavelength.
inline map_grid grid_of(const recording& of, const channel_data& data) {
    const float spacing = 0.5F * data.sound_speed / data.frequency;
    const float half = 0.5F * length(data.places.back().origin - data.places.front().origin) +
                       of.depth * std::tan(of.array.opening_deg * 1_deg);
    const auto columns = static_cast<std::uint32_t>(2 * half / spacing) + 1;
    return {.from = {-0.5F * static_cast<float>(columns - 1) * spacing, 0},
            .spacing = spacing,
            .size = {columns, static_cast<std::uint32_t>(of.depth / spacing) + 1}};
}

// The labels of the truth: the background, then the names of objects, each once.
struct label_names {
    std::vector<std::string> names{"background"};
    std::map<label_id, std::size_t> index{{background_label, 0}};

    explicit label_names(const scene& body) {
        std::map<std::string, std::size_t> known;
        for (const object& one : body.objects()) {
            const std::string name = one.name.empty() ? "object " + std::to_string(index.size()) : one.name;
            const auto [at, is_new] = known.emplace(name, names.size());
            if (is_new) names.push_back(name == names[0] ? name + " (object)" : name);
            index.emplace(static_cast<label_id>(one.id), at->second);
        }
    }
};

// The truth, which is the same in all frames; repetitions are compressed to almost nothing.
inline void add_truth(hdf5_file& file, const recording& of, const channel_data& data) {
    const map_grid grid = grid_of(of, data);
    const tissue_maps truth = map_tissue(exec::par_unseq, of.body, of.at, grid);
    const hsize_t frames = of.frames, rows = grid.size.y, columns = grid.size.x;
    const auto pack = [](const auto& values) { return dataset::pack(values, dataset::repetitions::any); };
    std::vector<dataset::packed_chunk> axes;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<float> values;
        for (std::uint32_t row = 0; row < grid.size.y; ++row)
            for (std::uint32_t column = 0; column < grid.size.x; ++column) values.push_back(grid.at(column, row)[axis]);
        axes.push_back(pack(values));
    }
    // A chunk for each index of the last axis of values.
    const auto add_map = [&](const std::string& name, const std::string& unit, const std::string& text,
                             number_type numbers, std::vector<hsize_t> shape, bool split,
                             const std::vector<dataset::packed_chunk>& chunks) {
        const std::string group = "tracks/track_0/data/" + name;
        file.add_group(group, text);
        file.add_text({group + "/unit", no_unit, "of the values"}, unit);
        file.add_text({group + "/description", no_unit, "of the values"}, text);
        std::vector<hsize_t> chunk = shape, points = shape;
        chunk[0] = 1;
        if (split) chunk.back() = 1;
        file.add_packed(
            {group + "/values", unit, text}, numbers, shape, chunk, [&](hsize_t) -> const auto& { return chunks; });
        if (split)
            points.back() = 3;
        else
            points.push_back(3);
        chunk = points;
        chunk[0] = chunk.back() = 1;
        file.add_packed(
            {group + "/coordinates", "m", "x lateral, y elevation, z depth, in the frame of the probe"},
            number_type::real, points, chunk, [&](hsize_t) -> const auto& { return axes; });
    };
    add_map("sos_map", "m/s", "sound speed of the tissue", number_type::real, {frames, rows, columns}, false,
            {pack(truth.sound_speed)});
    std::vector<float> loss(truth.attenuation.size());
    for (std::size_t i = 0; i < loss.size(); ++i)
        loss[i] = truth.attenuation[i] * std::pow(data.frequency / 1_MHz, truth.attenuation_power[i]) / data.frequency;
    add_map("attenuation_map", "dB/m/Hz", "attenuation of the tissue at the carrier, one way, over its frequency",
            number_type::real, {frames, rows, columns}, false, {pack(loss)});
    file.add_number({"tracks/track_0/data/attenuation_map/gamma", no_unit,
                     "exponent of the frequency by which the values are to be multiplied"},
                    1);
    const label_names labels{of.body};
    std::vector<dataset::packed_chunk> masks;
    for (std::size_t label = 0; label < labels.names.size(); ++label) {
        std::vector<std::uint8_t> mask(truth.labels.size());
        for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = labels.index.at(truth.labels[i]) == label ? 1 : 0;
        masks.push_back(pack(mask));
    }
    add_map("segmentation", no_unit, "a mask for each of `labels`", number_type::boolean,
            {frames, rows, columns, 1, labels.names.size()}, true, masks);
    file.add_texts({"tracks/track_0/data/segmentation/labels", no_unit, "of the masks"}, labels.names,
                   {labels.names.size()});
}

} // namespace detail

/// The bytes of a file.
inline std::string zea_file(const recording& of) {
    frame_data first = of.trace_one(0);
    check_size(of, first);
    const channel_data data = insonify::detail::same_acquisition<float>(first.received);
    dataset::hdf5_file file;
    file.set_text("zea_version", dataset::zea_version);
    file.set_text("us_machine", "insonify " + std::to_string(INSONIFY_VERSION));
    file.set_text("description", of.title);
    file.add_group("tracks", "one");
    file.add_group("tracks/track_0", "all frames");
    file.add_group("tracks/track_0/data", "channel data, and the truth behind them");
    add_scan(file, data);
    add_probe(file, of.array, data);
    detail::add_pose(file, of.at, of.frames);
    detail::add_truth(file, of, data);
    if (!of.points.empty()) {
        std::vector<float> places;
        for (const point_scatterer& one : of.points)
            places.insert(places.end(), {one.position.x, one.position.y, one.position.z});
        file.add_group("custom", "beyond the layout of zea");
        file.add_array({"custom/point_scatterers", "m", "x, y, z of each, in the frame of the probe"},
                       dataset::number_type::real, {of.points.size(), 3}, places.data());
    }
    const hsize_t parts = first.parts();
    const auto raw = file.add_pieces({"tracks/track_0/data/raw_data", no_unit,
                                      std::string{parts == 1 ? "RF" : "IQ"} +
                                          " of each element; 1 is the echo of a perfect mirror. The envelope of an "
                                          "echo peaks at its travel time"},
                                     {of.frames, data.transmits, data.samples, data.elements, parts});
    std::vector<float> piece(std::size_t{data.samples} * data.elements * parts);
    for_each_transmit(of, std::move(first), [&](std::uint32_t frame, std::uint32_t t, const frame_data& one) {
        std::size_t i = 0;
        for (std::uint32_t k = 0; k < data.samples; ++k)
            for (std::uint32_t e = 0; e < data.elements; ++e)
                for (std::uint32_t part = 0; part < parts; ++part) piece[i++] = one(part, t, e, k);
        raw.write(frame, t, piece);
    });
    return file.image();
}

} // namespace channels
#endif
