#ifndef INSONIFY_IO_IMPLEMENTATION_FILE_HPP
#define INSONIFY_IO_IMPLEMENTATION_FILE_HPP

#include <insonify/core/error.hpp>
#include <fstream>
#include <ios>
#include <sstream>
#include <string>

namespace insonify::inline INSONIFY_ABI::io {

/// The whole file, byte by byte, less the mark by which some editors begin UTF-8.
inline std::string read_file(const std::string& path) {
    std::ifstream file{path, std::ios::binary};
    if (!file) throw io_error{path + ": the file cannot be opened; check its name, its folder and your rights to read it"};
    std::ostringstream content;
    content << file.rdbuf();
    if (content.bad() || file.bad()) throw io_error{path + ": it cannot be read; is it a file, and not a folder?"};
    std::string text = std::move(content).str();
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    return text;
}

inline std::ofstream create_file(const std::string& path) {
    std::ofstream file{path, std::ios::binary};
    if (!file) throw io_error{path + ": the file cannot be written; check that its folder exists and lets you write"};
    return file;
}

inline void close_file(std::ofstream& file, const std::string& path) {
    file.close();
    if (!file) throw io_error{path + ": not all of the file could be written; check the space left on the disk"};
}

} // namespace insonify::inline INSONIFY_ABI::io
#endif
