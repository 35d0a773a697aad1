#ifndef INSONIFY_DATASET_FILE_HPP
#define INSONIFY_DATASET_FILE_HPP

#include <insonify/core/error.hpp>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <unistd.h>
#include <zlib.h>

namespace dataset {

/// Writes a file and waits until the disk has it.
/// @throws insonify::io_error  with the reason; what was written is removed
inline void write_file(const std::filesystem::path& path, std::string_view bytes) {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    bool written = file != nullptr && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() &&
                   std::fflush(file) == 0 && fsync(fileno(file)) == 0;
    std::string reason = std::strerror(errno);
    if (file != nullptr && std::fclose(file) != 0 && written) {
        written = false;
        reason = std::strerror(errno);
    }
    if (written) return;
    std::error_code ignored;
    if (file != nullptr) std::filesystem::remove(path, ignored);
    throw insonify::io_error{"cannot write " + path.string() + " (" + reason +
                             "); is the disk full, or the folder read-only?"};
}

/// Writes a file under another name, then renames it: it is there as a whole, or not at all.
inline void replace_file(const std::filesystem::path& path, std::string_view bytes) {
    const std::filesystem::path draft = path.string() + ".draft";
    write_file(draft, bytes);
    std::filesystem::rename(draft, path);
}

/// A checksum of bytes, as text. Source: CRC-32 of zlib.
inline std::string checksum_of(std::string_view bytes) {
    char text[16];
    std::snprintf(text, sizeof text, "%08lx",
                  crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
    return text;
}

/// The content of a file.
/// @throws insonify::io_error  for a file that cannot be read
inline std::string read_file(const std::filesystem::path& path) {
    std::ifstream file{path, std::ios::binary};
    std::string bytes{std::istreambuf_iterator<char>{file}, std::istreambuf_iterator<char>{}};
    if (!file || file.bad()) throw insonify::io_error{"cannot read " + path.string()};
    return bytes;
}

} // namespace dataset
#endif
