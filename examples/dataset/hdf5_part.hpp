#ifndef INSONIFY_DATASET_HDF5_PART_HPP
#define INSONIFY_DATASET_HDF5_PART_HPP

#include <insonify/core/version.hpp>
#include "../channels/scan_groups.hpp"
#include "file.hpp"
#include "layout.hpp"
#include <algorithm>
#include <string>
#include <vector>

/// Parts as HDF5, and the file that stands for all of them.
namespace dataset {

inline const array_name present_name{"insonify/present", no_unit,
                                     "1 where there is a sample; 0: its part is missing or damaged"};

/// Groups, texts and links: what a part and the whole have in common.
/// @param add_arrays  called when the groups exist, before the links
template <class AddArrays>
void add_content(hdf5_file& file, const description& d, const layout& arrays, const anatomies& all,
                 const std::string& identity, const AddArrays& add_arrays) {
    file.set_text("zea_version", zea_version);
    file.set_text("us_machine", "insonify " + std::to_string(INSONIFY_VERSION));
    file.set_text("description", "simulated ultrasound images, with ground truth");
    if (const auto& recorded = arrays.recorded()) {
        channels::add_probe(file, recorded->array(), recorded->like());
    } else if (const std::vector<std::string> types = probe_types(d, all); types.size() == 1) {
        file.add_group("probe", "the array; what varies is in insonify");
        file.add_text({"probe/name", no_unit, "of the array"}, types[0] + " array");
        file.add_text({"probe/type", no_unit, "linear, curved or phased"}, types[0]);
    }
    file.add_group("metadata", "of the samples");
    file.add_group("metadata/probe_pose", "from the probe to the anatomy, a row for each sample");
    file.add_text({"metadata/probe_pose/rotation_representation", no_unit, "w first"}, "quaternion_wxyz");
    file.add_number({"metadata/probe_pose/start_time_offset", "s", "samples are no moments of time"}, 0);
    file.add_number({"metadata/probe_pose/sampling_frequency", "Hz", "samples are no moments of time"}, 1);
    file.add_group("tracks", "the samples are the frames of one track");
    file.add_group("tracks/track_0", "a frame for each sample");
    file.add_group("tracks/track_0/data", "images, labels and signals");
    if (const auto& recorded = arrays.recorded()) channels::add_scan(file, recorded->like());
    for (const map_name& map : arrays.maps()) file.add_map(map);
    if (arrays.has_tissue()) channels::add_gamma(file);
    file.add_group("insonify", "how a sample came about");
    file.set_text("options", identity, "insonify");
    const auto add_names = [&](const char* name, const char* text, const std::vector<std::string>& names) {
        file.add_texts({std::string{"insonify/"} + name, no_unit, text}, names, {names.size()});
    };
    add_names("anatomies", "regions of the body, and files", all.names());
    add_names("views", "of all anatomies; empty for a file", all.view_names());
    if (!all.parameters().empty()) {
        std::vector<std::string> names, units;
        for (const anatomy::parameter& one : all.parameters()) {
            names.emplace_back(one.name);
            units.emplace_back(*one.unit ? one.unit : no_unit);
        }
        add_names("parameter_names", "of `parameters`", names);
        add_names("parameter_units", "of `parameters`", units);
    }
    const std::size_t labels = all.labels().needle();
    std::vector<float> media(all.size() * labels * 5, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const auto& [structure, m] : all[i].structures()) {
            const float values[5]{m.density, m.sound_speed, m.attenuation, m.attenuation_power, m.backscatter};
            float* place = &media[(i * labels + all.labels().of(structure)) * 5];
            if (std::isnan(*place)) std::copy(values, values + 5, place);
        }
    file.add_array(
        {"insonify/label_media", "SI",
         "of each label but the needle in each of `anatomies`, of the first of its objects, before the factors of a "
         "sample: density, "
         "sound speed, attenuation (dB/m at 1 MHz), its power of the frequency, backscatter; NaN where there is none"},
        number_type::real, {all.size(), labels, 5}, media.data());
    add_arrays();
    for (const auto& [path, target] : arrays.links()) file.add_link(path, target);
    file.add_link("data", "tracks/track_0/data");
}

/// The shape of an array of rows.
inline std::vector<hsize_t> with_rows(hsize_t rows, const std::vector<hsize_t>& row) {
    std::vector<hsize_t> shape{rows};
    shape.insert(shape.end(), row.begin(), row.end());
    return shape;
}

/// The bytes of a file, and after them, where HDF5 does not look, their checksum.
inline std::string with_checksum(const std::string& bytes) { return bytes + "\ncrc32 " + checksum_of(bytes) + "\n"; }

/// A part, whose samples are packed.
inline std::string hdf5_part(const description& d, const layout& arrays, const anatomies& all,
                             const std::string& identity, const std::vector<record>& records) {
    const hsize_t n = records.size();
    hdf5_file file;
    add_content(file, d, arrays, all, identity, [&] {
        const std::vector<std::uint8_t> present(n, 1);
        file.add_array(present_name, number_type::byte, {n}, present.data());
        for (const whole_fact& each : layout::whole_facts()) {
            std::vector<std::uint32_t> numbers;
            for (const record& one : records) numbers.push_back(each.of(one));
            file.add_array(each.name, number_type::whole, {n}, numbers.data());
        }
        for (const fact& each : arrays.facts()) {
            std::vector<float> values;
            for (const record& one : records) each.append(one, values);
            file.add_array(each.name, number_type::real, with_rows(n, each.shape), values.data());
        }
        for (std::size_t i = 0; i < arrays.arrays().size(); ++i) {
            const packed_array& each = arrays.arrays()[i];
            std::vector<hsize_t> chunk = with_rows(1, each.shape);
            if (each.split) chunk.back() = 1;
            file.add_packed(
                each.name, each.numbers, with_rows(n, each.shape),
                chunk, [&](hsize_t row) -> const auto& { return records[row].packed[i]; });
        }
    });
    return with_checksum(file.image());
}

/// One file that stands for all parts: a virtual dataset for each array.
inline std::string hdf5_whole(const description& d, const layout& arrays, const anatomies& all,
                              const std::string& identity, const std::vector<hdf5_file::source>& parts) {
    hdf5_file file;
    add_content(file, d, arrays, all, identity, [&] {
        const hsize_t n = d.samples;
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        file.add_virtual(present_name, number_type::byte, {n}, parts, 0);
        for (const whole_fact& each : layout::whole_facts())
            file.add_virtual(each.name, number_type::whole, {n}, parts, 4294967295.0);
        for (const fact& each : arrays.facts())
            file.add_virtual(each.name, number_type::real, with_rows(n, each.shape), parts, nan);
        for (const packed_array& each : arrays.arrays())
            file.add_virtual(each.name, each.numbers, with_rows(n, each.shape), parts, each.missing);
    });
    return file.image();
}

/// Calls visit(sample) with the first samples of a part.
template <class Visit>
void read_hdf5(const std::string& path, const layout& arrays, hsize_t count, const Visit& visit) {
    const hdf5_reader file{path};
    for (hsize_t row = 0; row < count; ++row) {
        stored_sample one{.image = file.row<std::uint8_t>(layout::image_path, row),
                          .label = file.row<std::uint8_t>(layout::label_path, row)};
        for (const fact* each : arrays.scalars()) {
            const std::vector<float> value = file.row<float>(each->name.path, row);
            one.numbers.push_back(value.size() == 1 ? value[0] : std::numeric_limits<float>::quiet_NaN());
        }
        visit(one);
    }
}

/// What is wrong with a part; empty: nothing.
inline std::string fault_of_hdf5(const std::string& path, const std::string& identity, hsize_t rows) {
    const hdf5_reader file{path};
    if (!file.is_open()) return "is cut short, or no HDF5 file";
    if (file.text("insonify", "options") != identity) return "has other options";
    if (file.rows(present_name.path) != rows) return "has another number of samples";
    const std::string bytes = read_file(path);
    const std::size_t end = bytes.size() - std::min(bytes.size(), with_checksum("").size());
    return with_checksum(bytes.substr(0, end)) == bytes ? "" : "is damaged: its checksum is another one";
}

} // namespace dataset
#endif
