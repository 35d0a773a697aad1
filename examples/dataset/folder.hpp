#ifndef INSONIFY_DATASET_FOLDER_HPP
#define INSONIFY_DATASET_FOLDER_HPP

#include <insonify/core/version.hpp>
#include "file.hpp"
#include "options.hpp"
#include <cinttypes>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

/// The folder of a dataset, and its file `description.ini`, which `--config` reads.
namespace dataset {

/// What makes samples those of one dataset: lines `name = value`, in the order of the options.
using identity_lines = std::vector<std::pair<std::string, std::string>>;

/// A number of the content of an OBJ file and its material libraries. Source: FNV-1a, 64 bits.
inline std::string content_of(const std::filesystem::path& obj) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    const auto add = [&](const std::string& bytes) {
        for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3U;
        hash = (hash ^ bytes.size()) * 0x100000001b3U;
    };
    const std::string text = read_file(obj);
    add(text);
    std::istringstream lines{text};
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words{line};
        std::string keyword, rest, word;
        words >> keyword;
        if (keyword != "mtllib") continue;
        std::getline(words >> std::ws, rest);
        while (!rest.empty() && (rest.back() == '\r' || rest.back() == ' ')) rest.pop_back();
        std::vector<std::string> names{rest}; // one with spaces, or several
        for (std::istringstream each{rest}; each >> word;) names.push_back(word);
        for (const std::string& name : names)
            if (std::filesystem::is_regular_file(obj.parent_path() / name)) add(read_file(obj.parent_path() / name));
    }
    char digits[24];
    std::snprintf(digits, sizeof digits, "%016" PRIx64, hash);
    return digits;
}

inline identity_lines identity_of(const description& d, const std::vector<described_option>& options) {
    identity_lines lines{{"# insonify", std::to_string(INSONIFY_VERSION)}};
    for (std::size_t i = 0; i < d.anatomy.size(); ++i)
        lines.push_back({"# content of anatomy " + std::to_string(i),
                         anatomy::region_named(d.anatomy[i]) != nullptr ? d.anatomy[i] : content_of(d.anatomy[i])});
    for (const described_option& each : options)
        if (each.alters_samples)
            if (const std::string value = each.value(); !value.empty()) lines.push_back({each.name, value});
    return lines;
}
inline std::string text_of(const identity_lines& lines) {
    std::string text;
    for (const auto& [name, value] : lines) text += name + " = " + value + "\n";
    return text;
}

/// The lines of a description that was written; other lines are left out.
inline identity_lines read_description(const std::string& text) {
    identity_lines lines;
    std::istringstream stream{text};
    for (std::string line; std::getline(stream, line);)
        if (const std::size_t sign = line.find(" = "); sign != std::string::npos)
            lines.push_back({line.substr(0, sign), line.substr(sign + 3)});
    return lines;
}
inline std::string value_in(const identity_lines& lines, const std::string& name) {
    for (const auto& [key, value] : lines)
        if (key == name) return value;
    return "";
}

/// @throws usage_error  where the folder holds samples of another dataset, naming what differs, or more of this one
inline void check_folder(const description& d, const identity_lines& identity) {
    const std::filesystem::path file = std::filesystem::path{d.output} / "description.ini";
    if (!std::filesystem::exists(file)) return;
    const identity_lines old = read_description(read_file(file));
    const auto differs = [&](const std::string& name, const std::string& there, const std::string& here) {
        throw usage_error{"--output: '" + d.output + "' holds samples of another description: '" + name + "' is " +
                          (there.empty() ? "not given" : there) + " there, and " + (here.empty() ? "not given" : here) +
                          " here; choose another folder, or delete it"};
    };
    for (const auto& [name, value] : identity)
        if (value_in(old, name) != value) differs(name, value_in(old, name), value);
    for (const auto& [name, value] : old)
        if (name != "samples" && name != "anatomy" && value_in(identity, name).empty()) differs(name, value, "");
    const std::string samples = value_in(old, "samples");
    if (samples.size() > 10 || std::strtoull(samples.c_str(), nullptr, 10) > d.samples)
        throw usage_error{"--samples: '" + d.output + "' has " + samples + " samples already; ask for as many or more"};
}

/// Creates the folder where there is none, and writes the description.
inline void prepare_folder(const description& d, const identity_lines& identity,
                           const std::vector<described_option>& options) {
    std::error_code failed;
    std::filesystem::create_directories(d.output, failed);
    if (failed) throw io_error{"--output: cannot create '" + d.output + "': " + failed.message()};
    std::string text = "# The options of these samples, for dataset --config.\n" + text_of(identity);
    for (const described_option& each : options)
        if (!each.alters_samples)
            if (const std::string value = each.value(); !value.empty()) text += each.name + " = " + value + "\n";
    replace_file(std::filesystem::path{d.output} / "description.ini", text);
}

} // namespace dataset
#endif
