#ifndef INSONIFY_DATASET_PARTS_HPP
#define INSONIFY_DATASET_PARTS_HPP

#include "hdf5_file.hpp"
#include "render.hpp"
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

/// The samples are stored in parts of equal size. A part is written under another name and then renamed: where its file
/// exists it is complete, whatever happened. Its content depends on the description and its number alone.
namespace dataset {

struct part_range {
    std::uint32_t first = 0, last = 0; ///< samples, from the first up to, but without, the last
};

inline std::uint32_t part_count(const description& d) { return (d.samples + d.part - 1) / d.part; }
inline part_range samples_of_part(const description& d, std::uint32_t part) {
    return {part * d.part, std::min(d.samples, (part + 1) * d.part)};
}
inline std::string part_name(const description& d, std::uint32_t part) {
    char name[32];
    std::snprintf(name, sizeof name, "part-%06u%s", part, d.format == "png" ? "" : ".h5");
    return name;
}

namespace detail_ {

/// Values along lines as samples x lines, as the format has them; shorter lines end with zeros.
template <int Components, class Value>
std::vector<float> along_lines(const line_grid<Value>& from, std::uint32_t samples, std::uint32_t lines) {
    std::vector<float> all(std::size_t{samples} * lines * Components);
    for (std::uint32_t line = 0; line < from.count; ++line)
        for (std::uint32_t k = 0; k < from.samples; ++k) {
            float* to = &all[(std::size_t{k} * lines + line) * Components];
            if constexpr (Components == 2) {
                to[0] = from(line, k).x;
                to[1] = from(line, k).y;
            } else {
                to[0] = from(line, k);
            }
        }
    return all;
}

} // namespace detail_

/// An array with a row for each sample.
struct row_kind {
    const char* name;
    const char* unit;
    const char* description;
    bool bytes;                 ///< 8-bit; else floats
    std::vector<hsize_t> shape; ///< of a row
};

/// The arrays of a part, and of the whole.
/// @param samples  of the longest line
inline std::vector<row_kind> row_kinds(const description& d, std::uint32_t samples) {
    const hsize_t size = d.size, k = samples, lines = d.lines;
    const std::vector<hsize_t> pixels{size, size};
    std::vector<row_kind> all{
        {"data/image_sc", "-", "B-mode image, scan-converted: 0 black to 255 white; rows from the top", true, pixels},
        {"insonify/label", "-",
         "index into `label_names` of the object at each pixel of image_sc; 255: outside the field of view", true,
         pixels},
        {"insonify/incidence", "rad", "angle between the beam and the normal of the surface in a pixel; 0: none", false,
         pixels},
        {"insonify/transmitted", "-", "amplitude that arrives in a pixel and returns, 0 to 1", false, pixels},
        {"insonify/depth", "m", "of what a pixel shows, along its line", false, pixels}};
    if (d.iq) {
        all.push_back({"data/envelope_data",
                       "-",
                       "amplitude along the lines: samples x lines; 1 is the echo of a perfect mirror",
                       false,
                       {k, lines}});
        all.push_back({"data/beamformed_data",
                       "-",
                       "complex echoes along the lines: samples x lines x (in phase, quadrature)",
                       false,
                       {k, lines, 2}});
    }
    return all;
}

/// Compresses the arrays of a sample, and frees them.
inline void pack(record& one, const description& d, std::uint32_t samples) {
    const auto add = [&](const auto& values) { one.packed.push_back(pack(values)); };
    add(std::exchange(one.image, {}));
    add(std::exchange(one.label, {}));
    add(std::exchange(one.incidence, {}));
    add(std::exchange(one.transmitted, {}));
    add(std::exchange(one.depth, {}));
    if (!d.iq) return;
    add(detail_::along_lines<1>(std::exchange(one.envelope, {}), samples, d.lines));
    add(detail_::along_lines<2>(std::exchange(one.iq, {}), samples, d.lines));
}

/// Writes a part, whose samples are packed, as HDF5.
/// @param samples  of the longest line
inline void write_hdf5(const std::string& path, const description& d, const anatomies& all,
                       const std::vector<record>& records, std::uint32_t samples) {
    const hsize_t n = records.size();
    hdf5_file file{path};
    file.set_text("label_names", [&] {
        std::string text;
        for (const std::string& name : all.labels().names) text += (text.empty() ? "" : "\n") + name;
        return text;
    }());
    file.set_text("anatomies", [&] {
        std::string text;
        for (const std::string& name : all.files()) text += (text.empty() ? "" : "\n") + name;
        return text;
    }());
    file.set_text("probe", d.probe);
    file.set_text("description", "simulated ultrasound images, by insonify");
    file.add_group("data", "images and signals, a row for each sample");
    file.add_group("scan", "settings that all samples share, or their means");
    file.add_group("insonify", "ground truth, and the numbers that vary");

    const std::vector<row_kind> kinds = row_kinds(d, samples);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        std::vector<hsize_t> shape = kinds[i].shape;
        shape.insert(shape.begin(), n);
        file.add_packed(
            kinds[i].name, kinds[i].bytes ? H5T_STD_U8LE : H5T_IEEE_F32LE, shape,
            [&](hsize_t row) -> const packed_row& { return records[row].packed[i]; }, kinds[i].unit,
            kinds[i].description);
    }

    const auto rows = [&](const char* name, const auto& of, const char* unit, const char* text) {
        std::vector<std::decay_t<decltype(of(records[0]))>> values;
        for (const record& one : records) values.push_back(of(one));
        file.add(name, {n}, values.data(), unit, text);
    };
    rows(
        "insonify/number", [](const record& r) { return r.numbers.number; }, "-",
        "number of the sample in the dataset");
    for (const named_number& each : numbers())
        rows((std::string{"insonify/"} + each.name).c_str(), [&](const record& r) { return each.of(r.numbers); },
             each.unit, each.description);
    std::vector<float> poses, pitches;
    for (const record& one : records) {
        pitches.insert(pitches.end(), {one.pitch.x, one.pitch.y});
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column)
                poses.push_back(row == 3      ? (column == 3 ? 1.0F : 0.0F)
                                : column == 3 ? one.at.translation[row]
                                              : one.at.rotation[column][row]);
    }
    file.add("insonify/pitch", {n, 2}, pitches.data(), "m", "width and height of a pixel");
    file.add("insonify/pose", {n, 4, 4}, poses.data(), "m", "from the probe to the anatomy");

    const float middle = 0.5F * (d.frequency.from + d.frequency.to) * 1e6F;
    file.add("scan/n_frames", static_cast<std::uint32_t>(n), "-", "number of samples");
    file.add("scan/n_tx", d.lines, "-", "transmissions of a frame: one for each line");
    file.add("scan/n_el", d.lines, "-", "elements: one for each line");
    file.add("scan/n_ax", samples, "-", "samples along a line");
    file.add("scan/n_ch", std::uint32_t{2}, "-", "channels: in phase and quadrature");
    file.add("scan/center_frequency", middle, "Hz", "middle of the range; that of each sample is insonify/frequency");
    file.add("scan/sampling_frequency", display_speed / 2 * static_cast<float>(samples) / (d.depth.to * 1_mm), "Hz",
             "of the samples along a line, for the largest depth");
    file.add("scan/sound_speed", display_speed, "m/s", "that depths are displayed with");
    std::vector<float> geometry;
    for (std::uint32_t i = 0; i < d.lines; ++i) {
        const vec3 origin = d.probe == "convex"   ? convex_array{.lines = d.lines}.beam(static_cast<float>(i)).origin
                            : d.probe == "phased" ? vec3{0, 0, 0}
                                                  : linear_array{.lines = d.lines}.beam(static_cast<float>(i)).origin;
        geometry.insert(geometry.end(), {origin.x, origin.y, origin.z});
    }
    file.add("scan/probe_geometry", {d.lines, 3}, geometry.data(), "m",
             "origin of each line, in the frame of the probe");
    const std::vector<float> zeros(d.lines);
    file.add("scan/initial_times", {d.lines}, zeros.data(), "s", "of the first sample of each line");
    file.flush();
}

/// Writes a part as a folder of PNG files, each beside its JSON.
inline void write_files(const std::string& path, const anatomies& all, const std::vector<record>& records,
                        std::uint32_t size) {
    std::filesystem::create_directories(path);
    for (const record& one : records) {
        char stem[32];
        std::snprintf(stem, sizeof stem, "/%08u", one.numbers.number);
        const auto png = [&](const char* kind, const std::vector<std::uint8_t>& bytes) {
            image picture{uvec2{size, size}};
            std::transform(bytes.begin(), bytes.end(), picture.pixels.begin(),
                           [](std::uint8_t byte) { return static_cast<float>(byte) / 255; });
            write_png(path + stem + kind, picture);
        };
        png(".png", one.image);
        png("_label.png", one.label);
        const auto digits = [](double value) { // a float is read back as it was
            char written[32];
            std::snprintf(written, sizeof written, "%.9g", value);
            return std::string{written};
        };
        std::string text = "{\n  \"number\": " + std::to_string(one.numbers.number) + ",\n  \"pitch\": [" +
                           digits(double{one.pitch.x}) + ", " + digits(double{one.pitch.y}) + "]";
        for (const named_number& each : numbers())
            text += std::string{",\n  \""} + each.name + "\": " + digits(double{each.of(one.numbers)});
        text += ",\n  \"labels\": [";
        for (std::size_t i = 0; i < all.labels().names.size(); ++i) {
            std::string quoted;
            for (const char letter : all.labels().names[i])
                quoted += letter == '"' || letter == '\\' ? std::string{'\\', letter} : std::string{letter};
            text += (i == 0 ? "\"" : ", \"") + quoted + "\"";
        }
        text += "]\n}\n";
        const std::string name = path + stem + ".json";
        std::FILE* file = std::fopen(name.c_str(), "w");
        const bool written = file != nullptr && std::fputs(text.c_str(), file) >= 0;
        if (file == nullptr || std::fclose(file) != 0 || !written)
            throw io_error{"cannot write " + name + "; is the disk full, or the folder read-only?"};
    }
}

/// Writes a part under another name, then renames it.
/// @param writer  a number of the process, for that name
inline void write_part(const description& d, const anatomies& all, std::uint32_t part,
                       const std::vector<record>& records, int writer, std::uint32_t samples) {
    const std::filesystem::path done = std::filesystem::path{d.output} / part_name(d, part),
                                draft = done.string() + ".draft" + std::to_string(writer);
    try {
        if (d.format == "png")
            write_files(draft.string(), all, records, d.size);
        else
            write_hdf5(draft.string(), d, all, records, samples);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove_all(draft, ignored);
        throw;
    }
    std::filesystem::rename(draft, done);
}

} // namespace dataset
#endif
