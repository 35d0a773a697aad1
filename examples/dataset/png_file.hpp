#ifndef INSONIFY_DATASET_PNG_FILE_HPP
#define INSONIFY_DATASET_PNG_FILE_HPP

#include <cstdint>
#include <string>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#if __has_include(<stb_image.h>)
#include <stb_image.h>
#else
#include <stb/stb_image.h>
#endif
#pragma GCC diagnostic pop

namespace dataset {

/// The grey levels of a PNG file with 8 bits. @return empty where it cannot be read
inline std::vector<std::uint8_t> grey_levels(const std::string& bytes) {
    int columns = 0, rows = 0, channels = 0;
    stbi_uc* read = stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()),
                                          static_cast<int>(bytes.size()), &columns, &rows, &channels, 1);
    if (read == nullptr) return {};
    std::vector<std::uint8_t> levels(read, read + static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    stbi_image_free(read);
    return levels;
}

} // namespace dataset
#endif
