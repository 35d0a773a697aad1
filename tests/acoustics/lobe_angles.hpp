#ifndef INSONIFY_TESTS_ACOUSTICS_LOBE_ANGLES_HPP
#define INSONIFY_TESTS_ACOUSTICS_LOBE_ANGLES_HPP

#include <insonify/acoustics/laws.hpp>
#include <cmath>

/// Levels and angles of specular lobes.
namespace specular_test {

using namespace insonify;

inline constexpr double radians = 3.14159265358979 / 180;

// The angle in degrees at which a lobe falls to a level, by bisection.
inline float degrees_at(const specular_return& lobe, float level_db, float fnumber, float wavelengths) {
    float above = 0, below = 90;
    for (int i = 0; i < 40; ++i) {
        const float middle = (above + below) / 2;
        const float amplitude = lobe(middle * static_cast<float>(radians), fnumber, wavelengths);
        (amplitude > std::pow(10.0F, level_db / 20) ? above : below) = middle;
    }
    return above;
}

// A published simulation: an F/2 array focused on a plate 30 mm deep in 1540 m/s, echo level against tilt.
struct tilted_plate {
    float megahertz;
    float at_6_db; // degrees, interpolated in the full table
    struct {
        float degrees, db;
    } rows[9];
};

inline constexpr tilted_plate table[] = {
    {2.5F,
     7.693F,
     {{1, -0.091F},
      {2.5F, -0.606F},
      {4, -1.714F},
      {5, -2.811F},
      {6, -4.031F},
      {7.5F, -5.751F},
      {9, -8.066F},
      {10, -10.26F},
      {10.5F, -11.512F}}},
    {5,
     7.501F,
     {{1, -0.121F},
      {2.5F, -0.871F},
      {4, -2.334F},
      {5, -3.314F},
      {6, -4.245F},
      {7.5F, -5.999F},
      {9, -8.137F},
      {10, -10.053F},
      {10.5F, -11.32F}}},
    {7.5F,
     7.416F,
     {{1, -0.14F},
      {2.5F, -1.076F},
      {4, -2.503F},
      {5, -3.358F},
      {6, -4.359F},
      {7.5F, -6.102F},
      {9, -8.307F},
      {10, -10.107F},
      {10.5F, -11.228F}}},
};

} // namespace specular_test

#endif
