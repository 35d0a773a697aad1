#ifndef INSONIFY_DATASET_PNG_PART_HPP
#define INSONIFY_DATASET_PNG_PART_HPP

#include "file.hpp"
#include "layout.hpp"
#include "png_file.hpp"
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

/// Parts as folders of PNG files, each beside its JSON, and beside its IQ in the format of NumPy.
namespace dataset {

/// Numbers as nested lists of JSON; null where there is none.
inline std::string json(const std::vector<float>& values, const std::vector<hsize_t>& shape) {
    std::size_t next = 0;
    const auto list = [&](const auto& self, std::size_t axis) -> std::string {
        if (axis == shape.size()) {
            const float value = values[next++];
            return is_finite(value) ? digits(value) : "null";
        }
        std::string text{"["};
        for (hsize_t i = 0; i < shape[axis]; ++i) text += (i == 0 ? "" : ", ") + self(self, axis + 1);
        return text + "]";
    };
    return list(list, 0);
}
inline std::string json(const std::vector<std::string>& texts) {
    std::string list{"["};
    for (const std::string& text : texts) list += (list.size() == 1 ? "" : ", ") + json(text);
    return list + "]";
}

inline std::string json_of(const record& one, const layout& arrays, const anatomies& all) {
    std::string text{"{"};
    for (const whole_fact& each : layout::whole_facts())
        text += (text.size() == 1 ? "\n  " : ",\n  ") + json(each.short_name()) + ": " + std::to_string(each.of(one));
    for (const fact& each : arrays.facts())
        text += ",\n  " + json(each.short_name()) + ": " + json(each.of(one), each.shape);
    const spot& at = one.numbers.at;
    text += ",\n  \"anatomy_name\": " + json(all[at.anatomy].name());
    text += ",\n  \"view_name\": " + json(all.view_names()[all.view_of(at)]);
    std::vector<std::string> parameters;
    for (const anatomy::parameter& each : all.parameters()) parameters.emplace_back(each.name);
    text += ",\n  \"parameter_names\": " + json(parameters);
    text += ",\n  \"labels\": " + json(all.labels().names);
    return text + "\n}\n";
}

/// Complex numbers, samples x lines, as a file of NumPy.
inline std::string numpy_of(const iq_lines& echoes) {
    std::string header = "{'descr': '<c8', 'fortran_order': False, 'shape': (" + std::to_string(echoes.samples) + ", " +
                         std::to_string(echoes.count) + "), }";
    header.resize((header.size() + 11 + 63) / 64 * 64 - 11, ' '); // with the first 10 bytes a multiple of 64
    header += '\n';
    std::string bytes{"\x93NUMPY\x01\x00", 8};
    bytes += static_cast<char>(header.size() & 0xFFU);
    bytes += static_cast<char>(header.size() >> 8U);
    bytes += header;
    for (std::uint32_t k = 0; k < echoes.samples; ++k)
        for (std::uint32_t line = 0; line < echoes.count; ++line)
            bytes.append(reinterpret_cast<const char*>(&echoes(line, k)), sizeof(vec2));
    return bytes;
}

inline std::string stem_of(std::uint32_t sample) {
    char stem[16];
    std::snprintf(stem, sizeof stem, "%08u", sample);
    return stem;
}

/// The file in the folder of a part that has a line for each other one.
inline constexpr const char* checksums_name = "checksums.txt";
inline std::string checksum_line(const std::string& name, const std::string& bytes) {
    return checksum_of(bytes) + "  " + name + "\n";
}

/// Makes the folder of a part.
inline void write_files(const std::filesystem::path& folder, const layout& arrays, const anatomies& all,
                        const std::vector<record>& records, std::uint32_t size) {
    std::filesystem::create_directories(folder);
    std::string checksums;
    for (const record& one : records) {
        const std::string stem = stem_of(one.numbers.number);
        const auto write = [&](const char* kind, const std::string& bytes) {
            write_file(folder / (stem + kind), bytes);
            checksums += checksum_line(stem + kind, bytes);
        };
        const auto png = [&](const char* kind, const std::vector<std::uint8_t>& levels) {
            image picture{uvec2{size, size}};
            std::transform(levels.begin(), levels.end(), picture.pixels.begin(),
                           [](std::uint8_t byte) { return static_cast<float>(byte) / 255; });
            write_png((folder / (stem + kind)).string(), picture);
            checksums += checksum_line(stem + kind, read_file(folder / (stem + kind)));
        };
        png(".png", one.image);
        png("_label.png", one.label);
        if (one.iq.count != 0) write("_iq.npy", numpy_of(one.iq));
        write(".json", json_of(one, arrays, all));
    }
    write_file(folder / checksums_name, checksums);
}

/// Calls visit(sample) with the samples of a part from the first up to, but without, the last.
template <class Visit>
void read_files(const std::filesystem::path& folder, const layout& arrays, std::uint32_t first, std::uint32_t last,
                const Visit& visit) {
    for (std::uint32_t i = first; i < last; ++i) {
        stored_sample one;
        one.image = grey_levels(read_file(folder / (stem_of(i) + ".png")));
        one.label = grey_levels(read_file(folder / (stem_of(i) + "_label.png")));
        const std::string text = read_file(folder / (stem_of(i) + ".json"));
        for (const fact* each : arrays.scalars()) {
            const std::string key = json(each->short_name()) + ": ";
            const std::size_t at = text.find(key);
            const bool is_number = at != std::string::npos && text.compare(at + key.size(), 4, "null") != 0;
            one.numbers.push_back(is_number ? std::strtof(text.c_str() + at + key.size(), nullptr)
                                            : std::numeric_limits<float>::quiet_NaN());
        }
        visit(one);
    }
}

/// What is wrong with the folder of a part; empty: nothing.
inline std::string fault_of_files(const std::filesystem::path& folder, const description& d, std::uint32_t first,
                                  std::uint32_t last) {
    const auto content = [&](const std::string& name) {
        return std::filesystem::is_regular_file(folder / name) ? read_file(folder / name) : std::string{};
    };
    std::set<std::string> checksums;
    std::istringstream lines{content(checksums_name)};
    for (std::string line; std::getline(lines, line);) checksums.insert(line + "\n");
    for (std::uint32_t i = first; i < last; ++i)
        for (const char* kind : {".png", "_label.png", ".json", "_iq.npy"}) {
            if (!d.iq && kind == std::string{"_iq.npy"}) continue;
            const std::string name = stem_of(i) + kind;
            if (!checksums.contains(checksum_line(name, content(name))))
                return name + " is missing or damaged, or " + checksums_name + " is";
        }
    return "";
}

} // namespace dataset
#endif
