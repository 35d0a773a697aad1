#ifndef INSONIFY_TESTS_TRACING_PHYSICAL_SCENES_HPP
#define INSONIFY_TESTS_TRACING_PHYSICAL_SCENES_HPP

#include <insonify/acoustics/physical.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include "echoes.hpp"

/// Slabs and probes of the tests of traced physical echoes.
namespace physical_test {

using namespace insonify;

using echoes_test::echo, echoes_test::echoes_of;

inline mesh slab(float from, float to) { return make_box({-60_mm, -60_mm, from}, {60_mm, 60_mm, to}); }

inline medium of_impedance(float rayl, float speed, float attenuation) {
    return {.density = rayl / speed, .sound_speed = speed, .attenuation = attenuation};
}

inline constexpr linear_array probe(float frequency) { return {.lines = 16, .width = 10_mm, .frequency = frequency}; }

// Attenuates the carrier alone, as closed forms for a single frequency do.
inline constexpr physical<> carrier_alone{.bandwidth = pulse_bandwidth::narrow};

// One scatterer in the middle of what it is asked for.
struct one_scatterer {
    template <class Emit>
    void scatter(const material_line&, float begin, float end, float, Emit&& emit) const {
        const float real = 1, imaginary = 0;
        emit(scatterer_run{.first = 0.5F * (begin + end), .count = 1, .real = &real, .imaginary = &imaginary});
    }
    float covariance(float, float) const { return 0; }
};

} // namespace physical_test

#endif
