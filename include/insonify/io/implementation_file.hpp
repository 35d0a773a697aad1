#ifndef INSONIFY_IO_IMPLEMENTATION_FILE_HPP
#define INSONIFY_IO_IMPLEMENTATION_FILE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/io/implementation_packages.hpp>
#include <insonify/io/png.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <ios>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// @throws io_error  for an empty name, or one with a null character, at which the system would truncate it
inline void check_file_name(const std::string& path) {
    if (path.empty()) throw io_error{"the file name is empty; give a path"};
    if (path.find('\0') != std::string::npos)
        throw io_error{path.substr(0, path.find('\0')), ": the file name contains a null character; remove it"};
}

/// A word of a file for use in an error: without control characters, and at most 60 characters long.
inline std::string printable(std::string_view word) {
    std::string text{word.substr(0, 60)};
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }, '?');
    return word.size() > 60 ? text + "..." : text;
}

/// The path with a name in UTF-8. Windows would take a narrow string as text in its code page.
/// @throws io_error  on Windows, for a name in another encoding
inline std::filesystem::path path_of(const std::string& name) {
    try {
        return std::u8string{name.begin(), name.end()};
    } catch (const std::system_error&) {
        throw io_error{printable(name), ": the file name is not in UTF-8; encode it so"};
    }
}

/// Whether a text has the byte order mark of UTF-16, or begins with two of its characters that are ASCII.
inline bool is_utf16(std::string_view text) {
    const auto null = [text](std::size_t i) { return text[i] == '\0'; };
    return text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
           (text.size() >= 4 && null(0) == null(2) && null(1) == null(3) && null(0) != null(1));
}

/// The content of a text file, without a UTF-8 byte order mark. @throws io_error  for one in UTF-16
inline std::string read_file(const std::string& path) {
    check_file_name(path);
    std::error_code ignored;
    if (std::filesystem::is_directory(path_of(path), ignored))
        throw io_error{path, ": this is a folder; give the path of a file"};
    std::ifstream file{path_of(path), std::ios::binary};
    if (!file) throw io_error{path, ": the file cannot be opened; check its name, its folder and its permissions"};
    std::ostringstream content;
    content << file.rdbuf();
    if (content.bad() || file.bad())
        throw io_error{path, ": reading failed before the end of the file; check the disk"};
    std::string text = std::move(content).str();
    if (is_utf16(text))
        throw io_error{path, ": the text is in UTF-16; save it as UTF-8 (a text editor offers it as its encoding)"};
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    return text;
}

inline std::ofstream create_file(const std::string& path) {
    check_file_name(path);
    std::ofstream file{path_of(path), std::ios::binary};
    if (!file) throw io_error{path, ": the file cannot be created; check that its folder exists and is writable"};
    return file;
}

inline void close_file(std::ofstream& file, const std::string& path) {
    file.close();
    if (!file) throw io_error{path, ": writing failed before the end of the file; check the free space on the disk"};
}

/// @param values  of each pixel as many as `channels`, row by row
inline void write_png_values(const std::string& path, uvec2 size, std::size_t pixels, const float* values,
                             std::size_t channels) {
    check_size(size, "write_png");
    if (pixels != static_cast<std::size_t>(size.x) * size.y)
        throw usage_error{"write_png: size ", size.x, "x", size.y, " needs as many pixels, not ", pixels};
    std::vector<unsigned char> bytes(channels * pixels);
    std::transform(values, values + bytes.size(), bytes.begin(), [](float value) {
        return static_cast<unsigned char>(is_number(value) ? clamp(value, 0, 1) * 255 + 0.5F : 0.0F);
    });
    std::ofstream file = create_file(path);
    const auto write = [](void* to, void* data, int count) {
        static_cast<std::ofstream*>(to)->write(static_cast<const char*>(data), count);
    };
    const int columns = static_cast<int>(size.x), rows = static_cast<int>(size.y), each = static_cast<int>(channels);
    if (stb::stbi_write_png_to_func(write, &file, columns, rows, each, bytes.data(), columns * each) == 0)
        throw io_error{path, ": compression failed; check the free memory"};
    close_file(file, path);
}

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

void write_png(const std::string& path, const image& picture) {
    detail::write_png_values(path, picture.size, picture.pixels.size(), picture.pixels.data(), 1);
}

void write_png(const std::string& path, const colour_image& picture) {
    const auto* const values = reinterpret_cast<const float*>(picture.pixels.data()); // vec3 is packed
    detail::write_png_values(path, picture.size, picture.pixels.size(), values, 3);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
