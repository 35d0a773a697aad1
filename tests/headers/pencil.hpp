#ifndef INSONIFY_TESTS_HEADERS_PENCIL_HPP
#define INSONIFY_TESTS_HEADERS_PENCIL_HPP

#include <insonify/probe/transducer.hpp>

/// A minimal transducer: one line along z.
struct pencil {
    std::uint32_t lines = 1;
    float frequency = 5e6F;
    insonify::ray beam(float) const { return {}; }
    insonify::vec2 locate(insonify::vec2 point) const { return {0, point.y}; }
    void check() const {}
    friend bool operator==(const pencil&, const pencil&) = default;
};

#endif
