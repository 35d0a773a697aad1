#ifndef INSONIFY_TESTS_SCENE_CROSSING_MEMORY_HPP
#define INSONIFY_TESTS_SCENE_CROSSING_MEMORY_HPP

#include <insonify/scene/layers.hpp>
#include <vector>

/// Memory in which tests search one line.
struct crossing_memory {
    std::vector<insonify::crossing> crossings = std::vector<insonify::crossing>(4096);
    std::vector<std::uint32_t> inside = std::vector<std::uint32_t>(512);
    std::vector<insonify::layer> layers = std::vector<insonify::layer>(2048);

    insonify::line_crossings found() {
        return {.room = insonify::view<insonify::crossing>{crossings},
                .inside = {.ranks = insonify::view<std::uint32_t>{inside}}};
    }
};

#endif
