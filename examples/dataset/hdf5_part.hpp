#ifndef INSONIFY_DATASET_HDF5_PART_HPP
#define INSONIFY_DATASET_HDF5_PART_HPP

#include <insonify/core/version.hpp>
#include "layout.hpp"
#include <string>
#include <vector>

/// Parts as HDF5, and the file that stands for all of them.
namespace dataset {

/// The version of zea whose layout the files have.
inline constexpr const char* zea_version = "0.1.8";

inline const array_name present_name{"insonify/present", no_unit,
                                     "1 where there is a sample; 0: its part is missing or damaged"};
inline const array_name sample_number_name{"insonify/number", no_unit, "number of the sample in the dataset"};

/// Groups, texts and links: what a part and the whole have in common.
/// @param add_arrays  called when the groups exist, before the links
template <class AddArrays>
void add_content(hdf5_file& file, const layout& arrays, const anatomies& all, const std::string& probe,
                 const std::string& identity, const AddArrays& add_arrays) {
    file.set_text("zea_version", zea_version);
    file.set_text("us_machine", "insonify " + std::to_string(INSONIFY_VERSION));
    file.set_text("description", "simulated ultrasound images, with ground truth");
    file.add_group("probe", "the array; what varies is in insonify");
    file.add_text({"probe/name", no_unit, "of the array"}, probe + " array");
    file.add_text({"probe/type", no_unit, "linear, curved or phased"}, probe == "convex" ? "curved" : probe);
    file.add_group("metadata", "of the samples");
    file.add_group("metadata/probe_pose", "from the probe to the anatomy, a row for each sample");
    file.add_text({"metadata/probe_pose/rotation_representation", no_unit, "w first"}, "quaternion_wxyz");
    file.add_number({"metadata/probe_pose/start_time_offset", "s", "samples are no moments of time"}, 0);
    file.add_number({"metadata/probe_pose/sampling_frequency", "Hz", "samples are no moments of time"}, 1);
    file.add_group("tracks", "the samples are the frames of one track");
    file.add_group("tracks/track_0", "a frame for each sample");
    file.add_group("tracks/track_0/data", "images, labels and signals");
    for (const array_name& map : arrays.maps()) {
        file.add_group(map.path, map.description);
        file.add_text({map.path + "/unit", no_unit, "of the values"}, map.unit);
        file.add_text({map.path + "/description", no_unit, "of the values"}, map.description);
        if (map.path.find("segmentation") != std::string::npos)
            file.add_texts({map.path + "/labels", no_unit, "of the masks"}, all.labels().names,
                           {all.labels().names.size()});
        if (map.path.find("beamformed") != std::string::npos)
            file.add_texts({map.path + "/labels", no_unit, "of the last axis"}, {"I", "Q"}, {2});
    }
    file.add_group("insonify", "how a sample came about");
    file.set_text("options", identity, "insonify");
    const hsize_t anatomy_count = all.files().size(), media = all.most_objects() + 1;
    file.add_texts({"insonify/anatomies", no_unit, "files of the anatomies"}, all.files(), {anatomy_count});
    std::vector<std::string> names;
    std::vector<float> media_values;
    const auto add_medium = [&](const std::string& name, const medium& m) {
        names.push_back(name);
        media_values.insert(media_values.end(),
                            {m.density, m.sound_speed, m.attenuation, m.attenuation_power, m.backscatter});
    };
    for (std::size_t i = 0; i < anatomy_count; ++i) {
        add_medium("background", all.original(i).background());
        const auto& objects = all.original(i).objects();
        for (std::size_t k = 0; k < objects.size(); ++k) add_medium(all.names(i)[k], objects[k].inside);
        names.resize((i + 1) * media);
        media_values.resize((i + 1) * media * 5, std::numeric_limits<float>::quiet_NaN());
    }
    file.add_texts({"insonify/objects", no_unit, "of each anatomy: the background, then its objects"}, names,
                   {anatomy_count, media});
    file.add_array(
        {"insonify/object_media", "SI",
         "of `objects`, before the factors of a sample: density, sound speed, attenuation (dB/m at 1 MHz), its "
         "power of the frequency, backscatter"},
        number_type::real, {anatomy_count, media, 5}, media_values.data());
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

/// A part, whose samples are packed.
inline std::string hdf5_part(const description& d, const layout& arrays, const anatomies& all,
                             const std::string& identity, const std::vector<record>& records) {
    const hsize_t n = records.size();
    hdf5_file file;
    add_content(file, arrays, all, d.probe, identity, [&] {
        const std::vector<std::uint8_t> present(n, 1);
        file.add_array(present_name, number_type::byte, {n}, present.data());
        std::vector<std::uint32_t> numbers;
        for (const record& one : records) numbers.push_back(one.numbers.number);
        file.add_array(sample_number_name, number_type::whole, {n}, numbers.data());
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
    return file.image();
}

/// One file that stands for all parts: a virtual dataset for each array.
inline std::string hdf5_whole(const description& d, const layout& arrays, const anatomies& all,
                              const std::string& identity, const std::vector<hdf5_file::source>& parts) {
    hdf5_file file;
    add_content(file, arrays, all, d.probe, identity, [&] {
        const hsize_t n = d.samples;
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        file.add_virtual(present_name, number_type::byte, {n}, parts, 0);
        file.add_virtual(sample_number_name, number_type::whole, {n}, parts, 4294967295.0);
        for (const fact& each : arrays.facts())
            file.add_virtual(each.name, number_type::real, with_rows(n, each.shape), parts, nan);
        for (const packed_array& each : arrays.arrays())
            file.add_virtual(each.name, each.numbers, with_rows(n, each.shape), parts, each.missing);
    });
    return file.image();
}

/// What is wrong with a part; empty: nothing. It is read as a whole: the checksums of its arrays reveal damage.
inline std::string fault_of_hdf5(const std::string& path, const layout& arrays, const std::string& identity,
                                 hsize_t rows) {
    const hdf5_reader file{path};
    if (!file.is_open()) return "is cut short, or no HDF5 file";
    if (file.text("insonify", "options") != identity) return "has other options";
    const auto fault = [](const array_name& name) { return name.path + " is damaged, or has another shape"; };
    for (const auto& [name, numbers] :
         {std::pair{present_name, number_type::byte}, std::pair{sample_number_name, number_type::whole}})
        if (!file.reads(name.path, numbers, {rows})) return fault(name);
    for (const fact& each : arrays.facts())
        if (!file.reads(each.name.path, number_type::real, with_rows(rows, each.shape))) return fault(each.name);
    for (const packed_array& each : arrays.arrays())
        if (!file.reads(each.name.path, each.numbers, with_rows(rows, each.shape))) return fault(each.name);
    return "";
}

} // namespace dataset
#endif
