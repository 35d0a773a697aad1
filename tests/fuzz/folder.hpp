#ifndef INSONIFY_TESTS_FUZZ_FOLDER_HPP
#define INSONIFY_TESTS_FUZZ_FOLDER_HPP

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

namespace fuzz {

/// A folder in memory, where there is one, for the files of one program; gone when that ends.
class folder {
  public:
    folder() { std::filesystem::create_directories(place_); }
    folder(const folder&) = delete;
    folder& operator=(const folder&) = delete;
    ~folder() {
        std::error_code ignored;
        std::filesystem::remove_all(place_, ignored);
    }

    std::string path(const std::string& name) const { return place_.string() + "/" + name; }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream{path(name), std::ios::binary} << text;
    }
    std::string read(const std::string& name) const {
        std::ifstream file{path(name), std::ios::binary};
        return {std::istreambuf_iterator<char>{file}, {}};
    }

  private:
    static std::filesystem::path parent() {
        const std::filesystem::path memory = "/dev/shm";
        std::error_code ignored;
        return std::filesystem::is_directory(memory, ignored) ? memory : std::filesystem::temp_directory_path();
    }
    std::filesystem::path place_ = parent() / ("insonify_fuzz_" + std::to_string(std::random_device{}()));
};

} // namespace fuzz
#endif
