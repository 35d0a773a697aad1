// Any picture under any name: it is refused, or the file is a PNG of its size and pixels.
#define INSONIFY_IMPLEMENTATION
#include <insonify/io.hpp>
#include "folder.hpp"
#include "input.hpp"
#include "memory.hpp"
#include <cstdio>

using namespace insonify;

namespace {

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8U | static_cast<std::uint8_t>(bytes[at + i]);
    return value;
}

/// Source: the CRC of the PNG specification, annex D.
std::uint32_t checksum(const std::string& bytes, std::size_t begin, std::size_t end) {
    std::uint32_t sum = ~0U;
    for (std::size_t i = begin; i < end; ++i) {
        sum ^= static_cast<std::uint8_t>(bytes[i]);
        for (int bit = 0; bit < 8; ++bit) sum = (sum & 1U) != 0 ? 0xEDB88320U ^ sum >> 1U : sum >> 1U;
    }
    return ~sum;
}

void check_file(const std::string& bytes, uvec2 size) {
    fuzz::require(bytes.size() > 45 && bytes.compare(0, 8, "\x89PNG\r\n\x1a\n") == 0, "a PNG file says that it is one");
    fuzz::require(big_endian(bytes, 16) == size.x && big_endian(bytes, 20) == size.y, "a PNG file has the size");
    for (std::size_t at = 8, next = 0; at < bytes.size(); at = next) {
        fuzz::require(at + 12 <= bytes.size(), "a chunk is whole");
        next = at + 12 + big_endian(bytes, at);
        fuzz::require(next <= bytes.size(), "a chunk is whole");
        fuzz::require(checksum(bytes, at + 4, next - 4) == big_endian(bytes, next - 4), "a chunk has its checksum");
        fuzz::require((bytes.compare(at + 4, 4, "IEND") == 0) == (next == bytes.size()), "a PNG file ends as one");
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::folder scratch;
    const fuzz::allowance small{std::size_t{1} << 20U};
    fuzz::input in{data, size};
    std::string name = in.below(4) == 0 ? in.text(in.byte()) : "a.png";
    for (char& c : name)
        if (c == '/') c = '_';
    image picture;
    picture.size = {in.below(32), in.below(8)};
    if (in.below(8) == 0) picture.size.x = in.bits();
    if (in.below(8) == 0) picture.size.y = in.bits();
    const std::uint64_t pixels = std::uint64_t{picture.size.x} * picture.size.y;
    if (in.below(8) != 0 && pixels < 1024) picture.pixels.resize(pixels);
    for (float& pixel : picture.pixels) pixel = in.number();

    const std::string path = scratch.path(name);
    try {
        write_png(path, picture);
        fuzz::require(pixels > 0 && picture.pixels.size() == pixels, "a picture that is not whole is refused");
        fuzz::require(name.find('\0') == std::string::npos, "a name with a NUL in it is no name");
        check_file(scratch.read(name), picture.size);
        std::remove(path.c_str());
    } catch (const usage_error&) {
    } catch (const io_error&) {
    }
    return 0;
}
