#include <insonify/core/error.hpp>
#include <insonify/core/random.hpp>
#include <insonify/io/png.hpp>
#include "temporary_folder.hpp"
#include <cstdint>
#include <doctest/doctest.h>
#include <limits>
#include <string>
#include <vector>

// The program's own stb, in whatever translation unit this is: the library's copy must not meet it.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#if __has_include(<stb_image_write.h>)
#include <stb_image.h>
#include <stb_image_write.h>
#else
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#endif

using namespace insonify;

namespace png_test {
namespace {

struct decoded {
    int columns = 0, rows = 0, channels = 0;
    std::vector<int> grey{};
};

decoded decode(const std::string& path) {
    decoded picture;
    unsigned char* pixels = stbi_load(path.c_str(), &picture.columns, &picture.rows, &picture.channels, 1);
    REQUIRE(pixels != nullptr);
    picture.grey.assign(pixels, pixels + picture.columns * picture.rows);
    stbi_image_free(pixels);
    return picture;
}

template <class Error, class Call>
std::string sentence(const Call& call) {
    try {
        call();
    } catch (const Error& e) {
        return e.what();
    }
    return "no such error";
}

} // namespace

TEST_CASE("a PNG has 8 bits of grey, in rows from the top, rounded to nearest") {
    const temporary_folder folder;
    image picture{{3, 2}};
    picture.pixels = {0, 1, 0.5F, 100.4F / 255, 100.6F / 255, 254.6F / 255};
    write_png(folder.path("a.png"), picture);
    const decoded read = decode(folder.path("a.png"));
    CHECK(read.columns == 3);
    CHECK(read.rows == 2);
    CHECK(read.channels == 1);
    CHECK(read.grey == std::vector<int>{0, 255, 128, 100, 101, 255});
}

TEST_CASE("values out of range are clamped in a PNG, and NaN is black") {
    const temporary_folder folder;
    image picture{{6, 1}};
    picture.pixels = {-0.1F,
                      1.1F,
                      std::numeric_limits<float>::infinity(),
                      -std::numeric_limits<float>::infinity(),
                      std::numeric_limits<float>::quiet_NaN(),
                      -std::numeric_limits<float>::quiet_NaN()};
    write_png(folder.path("a.png"), picture);
    CHECK(decode(folder.path("a.png")).grey == std::vector<int>{0, 255, 255, 0, 0, 0});
}

TEST_CASE("a PNG of noise is decoded unchanged, and equals that of the program's own stb") {
    const temporary_folder folder;
    image picture{{317, 211}};
    std::vector<unsigned char> expected(picture.pixels.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        expected[i] = static_cast<unsigned char>(hash_bits(7, i));
        picture.pixels[i] = static_cast<float>(expected[i]) / 255;
    }
    write_png(folder.path("a.png"), picture);
    CHECK(decode(folder.path("a.png")).grey == std::vector<int>(expected.begin(), expected.end()));
    REQUIRE(stbi_write_png(folder.path("own.png").c_str(), 317, 211, 1, expected.data(), 317) != 0);
    CHECK(folder.read("a.png") == folder.read("own.png"));
}

TEST_CASE("write_png refuses invalid images and paths with a sentence") {
    const temporary_folder folder;
    const std::string path = folder.path("a.png");
    const auto refusal = [&](const image& picture) { return sentence<usage_error>([&] { write_png(path, picture); }); };
    CHECK(refusal(image{}).find("write_png: size 0x0 has no pixels") != std::string::npos);
    CHECK(refusal(image{{5, 0}}).find("write_png: size 5x0 has no pixels") != std::string::npos);

    image wrong{{2, 2}};
    wrong.pixels.pop_back();
    CHECK(refusal(wrong) == "write_png: size 2x2 needs as many pixels, not 3");
    wrong.size = {~0U, ~0U};
    CHECK(refusal(wrong).find("size 4294967295x4294967295 exceeds 16384 pixels a side") != std::string::npos);
    CHECK(!std::filesystem::exists(path));

    const std::string nowhere = folder.path("no/such/folder.png");
    CHECK(sentence<io_error>([&] {
              write_png(nowhere, image{{1, 1}});
          }) == nowhere + ": the file cannot be created; check that its folder exists and is writable");
    if (std::filesystem::exists("/dev/full"))
        CHECK(sentence<io_error>([&] {
                  write_png("/dev/full", image{{64, 64}});
              }) == "/dev/full: writing failed before the end of the file; check the free space on the disk");
}

TEST_CASE("a PNG of a colour image has 8 bits of red, green and blue") {
    const temporary_folder folder;
    colour_image picture{{2, 1}};
    picture(0, 0) = {1, 0.5F, 0};
    picture(1, 0) = {-1, 2, std::numeric_limits<float>::quiet_NaN()};
    write_png(folder.path("c.png"), picture);
    int columns = 0, rows = 0, channels = 0;
    unsigned char* const pixels = stbi_load(folder.path("c.png").c_str(), &columns, &rows, &channels, 0);
    REQUIRE(pixels != nullptr);
    CHECK(columns == 2);
    CHECK(rows == 1);
    REQUIRE(channels == 3);
    const std::vector<int> found(pixels, pixels + 6), expected{255, 128, 0, 0, 255, 0};
    CHECK(found == expected);
    stbi_image_free(pixels);
    picture.pixels.pop_back();
    CHECK_THROWS_AS(write_png(folder.path("c.png"), picture), usage_error);
}

} // namespace png_test
