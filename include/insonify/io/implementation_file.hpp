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
        throw io_error{path.substr(0, path.find('\0')) + ": the file name contains a null character; remove it"};
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
    if (std::filesystem::is_directory(path, ignored))
        throw io_error{path + ": this is a folder; give the path of a file"};
    std::ifstream file{path, std::ios::binary};
    if (!file) throw io_error{path + ": the file cannot be opened; check its name, its folder and its permissions"};
    std::ostringstream content;
    content << file.rdbuf();
    if (content.bad() || file.bad())
        throw io_error{path + ": reading failed before the end of the file; check the disk"};
    std::string text = std::move(content).str();
    if (is_utf16(text))
        throw io_error{path + ": the text is in UTF-16; save it as UTF-8 (a text editor offers it as its encoding)"};
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    return text;
}

inline std::ofstream create_file(const std::string& path) {
    check_file_name(path);
    std::ofstream file{path, std::ios::binary};
    if (!file) throw io_error{path + ": the file cannot be created; check that its folder exists and is writable"};
    return file;
}

inline void close_file(std::ofstream& file, const std::string& path) {
    file.close();
    if (!file) throw io_error{path + ": writing failed before the end of the file; check the free space on the disk"};
}

template <class Picture>
void check_pixels(const Picture& picture) {
    check_size(picture.size, "write_png");
    if (picture.pixels.size() != static_cast<std::size_t>(picture.size.x) * picture.size.y)
        throw usage_error{"write_png: size " + std::to_string(picture.size.x) + 'x' + std::to_string(picture.size.y) +
                          " needs as many pixels, not " + std::to_string(picture.pixels.size())};
}

inline unsigned char byte_of(float value) {
    return static_cast<unsigned char>(is_number(value) ? clamp(value, 0, 1) * 255 + 0.5F : 0.0F);
}

/// @param bytes  of each pixel as many as `channels`, row by row
inline void write_png_bytes(const std::string& path, uvec2 size, int channels,
                            const std::vector<unsigned char>& bytes) {
    std::ofstream file = create_file(path);
    const auto write = [](void* to, void* data, int count) {
        static_cast<std::ofstream*>(to)->write(static_cast<const char*>(data), count);
    };
    const int columns = static_cast<int>(size.x), rows = static_cast<int>(size.y);
    if (stb::stbi_write_png_to_func(write, &file, columns, rows, channels, bytes.data(), columns * channels) == 0)
        throw io_error{path + ": compression failed; check the free memory"};
    close_file(file, path);
}

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

void write_png(const std::string& path, const image& picture) {
    detail::check_pixels(picture);
    std::vector<unsigned char> grey(picture.pixels.size());
    std::transform(picture.pixels.begin(), picture.pixels.end(), grey.begin(), detail::byte_of);
    detail::write_png_bytes(path, picture.size, 1, grey);
}

void write_png(const std::string& path, const colour_image& picture) {
    detail::check_pixels(picture);
    std::vector<unsigned char> colours;
    colours.reserve(3 * picture.pixels.size());
    for (const vec3& pixel : picture.pixels)
        for (int channel = 0; channel < 3; ++channel) colours.push_back(detail::byte_of(pixel[channel]));
    detail::write_png_bytes(path, picture.size, 3, colours);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
