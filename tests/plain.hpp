#ifndef INSONIFY_TESTS_PLAIN_HPP
#define INSONIFY_TESTS_PLAIN_HPP

#include <insonify/acoustics/medium.hpp>

/// A medium with speckle alone, for tests of its statistics and its level in decibels.
inline insonify::medium plain(insonify::medium m) {
    m.structure = insonify::structure{};
    return m;
}

#endif
