#ifndef INSONIFY_TESTS_IO_TEMPORARY_FOLDER_HPP
#define INSONIFY_TESTS_IO_TEMPORARY_FOLDER_HPP

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

/// A folder of its own for each test case, gone when the case ends. Names and paths are in UTF-8.
class temporary_folder {
  public:
    temporary_folder() { std::filesystem::create_directories(path_); }
    temporary_folder(const temporary_folder&) = delete;
    temporary_folder& operator=(const temporary_folder&) = delete;
    ~temporary_folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }

    std::string path(const std::string& name) const {
        const std::u8string text = place(name).u8string();
        return {text.begin(), text.end()};
    }

    /// Writes a file and gives its path.
    std::string write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories(place(name).parent_path());
        std::ofstream{place(name), std::ios::binary} << text;
        return path(name);
    }

    std::string read(const std::string& name) const {
        std::ifstream file{place(name), std::ios::binary};
        return {std::istreambuf_iterator<char>{file}, {}};
    }

  private:
    std::filesystem::path place(const std::string& name) const {
        return path_ / std::u8string{name.begin(), name.end()};
    }

    std::filesystem::path path_ =
        std::filesystem::temp_directory_path() / ("insonify_" + std::to_string(std::random_device{}()));
};

#endif
