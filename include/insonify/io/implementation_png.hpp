#ifndef INSONIFY_IO_IMPLEMENTATION_PNG_HPP
#define INSONIFY_IO_IMPLEMENTATION_PNG_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/io/implementation_file.hpp>
#include <insonify/io/implementation_packages.hpp>
#include <insonify/io/png.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

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

} // namespace detail

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
