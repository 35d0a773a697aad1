#ifndef INSONIFY_IO_IMPLEMENTATION_PNG_HPP
#define INSONIFY_IO_IMPLEMENTATION_PNG_HPP

#include <insonify/image/check_size.hpp>
#include <insonify/io/implementation_file.hpp>
#include <insonify/io/implementation_stb.hpp>
#include <insonify/io/png.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

void write_png(const std::string& path, const image& picture) {
    detail::check_size(picture.size, "write_png");
    if (picture.pixels.size() != static_cast<std::size_t>(picture.size.x) * picture.size.y)
        throw usage_error{"write_png: size " + std::to_string(picture.size.x) + 'x' + std::to_string(picture.size.y) +
                          " needs as many pixels, not " + std::to_string(picture.pixels.size())};

    std::vector<unsigned char> grey(picture.pixels.size());
    std::transform(picture.pixels.begin(), picture.pixels.end(), grey.begin(), [](float value) {
        const bool is_nan = (__builtin_bit_cast(std::uint32_t, value) & 0x7FFFFFFFU) > 0x7F800000U;
        return static_cast<unsigned char>(is_nan ? 0.0F : clamp(value, 0, 1) * 255 + 0.5F);
    });

    std::ofstream file = detail::create_file(path);
    const auto write = [](void* to, void* data, int size) {
        static_cast<std::ofstream*>(to)->write(static_cast<const char*>(data), size);
    };
    const int columns = static_cast<int>(picture.size.x), rows = static_cast<int>(picture.size.y);
    if (detail::stb::stbi_write_png_to_func(write, &file, columns, rows, 1, grey.data(), columns) == 0)
        throw io_error{path + ": compression failed; check the free memory"};
    detail::close_file(file, path);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
