#ifndef INSONIFY_IO_IMPLEMENTATION_FILE_HPP
#define INSONIFY_IO_IMPLEMENTATION_FILE_HPP

#include <insonify/core/error.hpp>
#include <filesystem>
#include <fstream>
#include <ios>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

namespace insonify::inline INSONIFY_ABI::io {

/// @throws io_error  for a name that the system would cut off
inline void check_name(const std::string& path) {
    if (path.empty()) throw io_error{"a file was asked for without a name; give its path"};
    if (path.find('\0') != std::string::npos)
        throw io_error{path.substr(0, path.find('\0')) + ": its name goes on after a character 0; take that out"};
}

/// The whole file, byte by byte, less the mark by which some editors begin UTF-8.
inline std::string read_file(const std::string& path) {
    check_name(path);
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) throw io_error{path + ": this is a folder; name a file in it"};
    std::ifstream file{path, std::ios::binary};
    if (!file)
        throw io_error{path + ": the file cannot be opened; check its name, its folder and your rights to read it"};
    std::ostringstream content;
    content << file.rdbuf();
    if (content.bad() || file.bad()) throw io_error{path + ": the file cannot be read to its end; is the disk sound?"};
    std::string text = std::move(content).str();
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    return text;
}

inline std::ofstream create_file(const std::string& path) {
    check_name(path);
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
