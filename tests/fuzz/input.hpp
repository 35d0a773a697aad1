#ifndef INSONIFY_TESTS_FUZZ_INPUT_HPP
#define INSONIFY_TESTS_FUZZ_INPUT_HPP

#include <insonify/geometry/ray.hpp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace fuzz {

/// Stops the program where something that must hold does not: libFuzzer then keeps the input.
inline void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s\n", what);
    std::abort();
}

/// Bytes read as settings and numbers. Any bytes are legal, and after the last come zeros.
class input {
  public:
    input(const std::uint8_t* data, std::size_t size) : data_{data}, left_{size} {}

    bool empty() const { return left_ == 0; }

    std::uint8_t byte() {
        if (left_ == 0) return 0;
        --left_;
        return *data_++;
    }
    std::uint32_t below(std::uint32_t n) { return byte() % n; }

    std::uint32_t bits() {
        std::uint32_t value = 0;
        for (int i = 0; i < 4; ++i) value = value << 8U | byte();
        return value;
    }

    /// A digit is itself, another sign below 0x60 a sixteenth of its place after '@', a small letter one of the numbers
    /// that break programs, and all above 0x7F takes four more bytes as the bits of a float.
    float number() {
        constexpr std::uint32_t awkward[32] = {
            0x80000000, 0x00000001, 0x80000001, 0x007FFFFF, 0x00800000, 0x80800000, 0x0DA24260, 0x1E3CE508, // tiny
            0x33D6BF95, 0xB3D6BF95, 0x3F800001, 0x3F7FFFFF, 0xBF800001, 0x3EAAAAAB, 0xBF800000, 0x7FC00000, // near 1
            0xFFC00000, 0x7F800000, 0xFF800000, 0x7F7FFFFF, 0xFF7FFFFF, 0x7E967699, 0x6258D727, 0xE258D727, // large
            0x5F800000, 0xDF800000, 0x4B7FFFFF, 0x447A0000, 0x3A83126F, 0x358637BD, 0x7F800001, 0x40490FDB};
        const std::uint8_t sign = byte();
        if (sign >= '0' && sign <= '9') return static_cast<float>(sign - '0');
        if (sign < 0x60) return static_cast<float>(sign - '@') / 16;
        return __builtin_bit_cast(float, sign < 0x80 ? awkward[sign - 0x60] : bits());
    }
    insonify::vec3 point() {
        const float x = number(), y = number(), z = number();
        return {x, y, z};
    }

    std::string text(std::size_t size) {
        const std::size_t count = size < left_ ? size : left_;
        std::string value(reinterpret_cast<const char*>(data_), count);
        data_ += count;
        left_ -= count;
        return value;
    }
    std::string rest() { return text(left_); }

  private:
    const std::uint8_t* data_;
    std::size_t left_;
};

/// What a tree makes of a ray: steps below 1e-30 are none, and a ray that is not finite or goes nowhere meets nothing.
inline bool legal(insonify::ray& r) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::fabs(r.direction[axis]) <= 1e-30F) r.direction[axis] = 0;
    return insonify::is_finite(r.origin) && insonify::is_finite(r.direction) && r.direction != insonify::vec3{0, 0, 0};
}

/// Neither NaN nor infinite, for any number of numbers.
template <class Range>
bool all_finite(const Range& numbers) {
    for (const float number : numbers)
        if (!insonify::is_finite(number)) return false;
    return true;
}

} // namespace fuzz
#endif
