#ifndef INSONIFY_CHANNELS_ZEA_FILE_HPP
#define INSONIFY_CHANNELS_ZEA_FILE_HPP

#include <insonify/core/version.hpp>
#include "../dataset/hdf5_file.hpp"
#include "../dataset/quaternion.hpp"
#include "recording.hpp"
#include "scan_groups.hpp"
#include "truth_maps.hpp"
#include <array>
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

// A map, which is the same in all frames.
struct packed_map {
    dataset::map_name name;
    number_type numbers = number_type::real;
    std::vector<hsize_t> shape{}; // of a frame
    std::vector<dataset::packed_chunk> chunks{};
};

inline packed_map pack_labels(const scene& body, const tissue_maps& truth) {
    const label_names labels{body};
    packed_map made{
        .name = {{"tracks/track_0/data/segmentation", no_unit, "a mask for each of `labels`"}, labels.names},
        .numbers = number_type::boolean,
        .shape = {truth.grid.size.y, truth.grid.size.x, 1, labels.names.size()}};
    for (std::size_t label = 0; label < labels.names.size(); ++label) {
        std::vector<std::uint8_t> mask(truth.labels.size());
        for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = labels.index.at(truth.labels[i]) == label ? 1 : 0;
        made.chunks.push_back(dataset::pack(mask, dataset::repetitions::any));
    }
    return made;
}

inline std::vector<packed_map> pack_truth(const scene& body, const tissue_maps& truth, float frequency) {
    std::vector<packed_map> all;
    for (const truth_map& map : truth_maps())
        all.push_back({.name = map.in_file(), .shape = map.shape(truth.grid), .chunks = map.pack(truth, frequency)});
    all.push_back(pack_labels(body, truth));
    return all;
}

// An array of frames that are all alike; where the values have labels, each is a chunk.
inline void add_frames(hdf5_file& file, const dataset::array_name& name, number_type numbers, hsize_t frames,
                       std::vector<hsize_t> shape, bool split, const std::vector<dataset::packed_chunk>& chunks) {
    shape.insert(shape.begin(), frames);
    std::vector<hsize_t> chunk = shape;
    chunk[0] = 1;
    if (split) chunk.back() = 1;
    file.add_packed(
        name, numbers, shape, chunk, [&](hsize_t) -> const auto& { return chunks; });
}

inline void add_map(hdf5_file& file, const packed_map& map, hsize_t frames,
                    const std::vector<dataset::packed_chunk>& axes) {
    const auto& [path, unit, text] = map.name.group;
    const bool split = !map.name.labels.empty();
    file.add_map(map.name);
    add_frames(file, {path + "/values", unit, text}, map.numbers, frames, map.shape, split, map.chunks);
    std::vector<hsize_t> points = map.shape;
    if (split) points.pop_back();
    points.push_back(3);
    add_frames(file, {path + "/coordinates", "m", "x lateral, y elevation, z depth, in the frame of the probe"},
               number_type::real, frames, points, true, axes);
}

} // namespace detail

/// The bytes of a file.
inline std::string zea_file(const recording& of) {
    frame_data first = of.trace_one(0);
    const channel_data data = insonify::detail::same_acquisition<float>(first.received);
    const tissue_maps truth = map_tissue(exec::par_unseq, of.body, of.at, slice_grid(of.array, data, of.depth));
    const std::vector<detail::packed_map> maps = detail::pack_truth(of.body, truth, data.frequency);
    std::size_t of_maps = 0;
    for (const detail::packed_map& map : maps)
        for (const dataset::packed_chunk& chunk : map.chunks) of_maps += chunk.size();
    check_size(of, first, of_maps);
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
    const std::vector<dataset::packed_chunk> axes = pack_coordinates(truth.grid);
    for (const detail::packed_map& map : maps) detail::add_map(file, map, of.frames, axes);
    add_gamma(file);
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
