#ifndef INSONIFY_TESTS_ACOUSTICS_EMITTED_ECHOES_HPP
#define INSONIFY_TESTS_ACOUSTICS_EMITTED_ECHOES_HPP

#include <insonify/acoustics/physical.hpp>
#include <insonify/core/units.hpp>
#include <array>
#include <cmath>
#include <vector>

/// Records what `physical` emits along a line.
namespace physical_law_test {

using namespace insonify;

struct surface_echo {
    float depth = 0, amplitude = 0;
    vec2 slope{0, 0};
};

struct rough_echo {
    float depth = 0, amplitude = 0;
    vec2 slope{0, 0};
    vec2 value{0, 0}, deeper{0, 0}; // of the random field, at the surface and 0.1 mm deeper
};

struct speckle_run {
    scatterer_echoes echoes{}; // without the amplitudes, which are gone after the call
    double power = 0;          // sum of their squares
    double inner = 0;          // the same without the first and the last, which may be cut
};

/// Stands in place of an `echo_line` and records what a model emits.
struct recorder {
    float end = 0;
    std::vector<surface_echo>* surfaces = nullptr;
    std::vector<rough_echo>* rough = nullptr;
    std::vector<speckle_run>* speckle = nullptr;

    float depth() const { return end; }
    void surface(float depth, float amplitude, vec2 slope) const { surfaces->push_back({depth, amplitude, slope}); }
    void curved_surface(const curved_echo& one) const {
        surface(one.depth, one.amplitude * one.collected.x * one.collected.y, one.slope);
    }
    template <class Value>
    void rough_surface(float depth, float amplitude, vec2 slope, vec3 /* curvature */, const Value& value) const {
        rough->push_back({depth, amplitude, slope, value(0.0F), value(0.1e-3F)});
    }
    void scatterers(const scatterer_echoes& run) const {
        const auto power = [&](std::uint32_t i) {
            return static_cast<double>(run.real[i]) * run.real[i] +
                   static_cast<double>(run.imaginary[i]) * run.imaginary[i];
        };
        double inner = 0;
        for (std::uint32_t i = 1; i + 1 < run.count; ++i) inner += power(i);
        const double ends = power(0) + (run.count > 1 ? power(run.count - 1) : 0);
        speckle->push_back({run, inner + ends, inner});
    }
};

struct emitted {
    std::vector<surface_echo> surfaces{};
    std::vector<rough_echo> rough{};
    std::vector<speckle_run> speckle{};
};

template <class Model>
emitted emit(const Model& model, const traced_line& line, float depth) {
    emitted found;
    model.emit(line, recorder{depth, &found.surfaces, &found.rough, &found.speckle});
    return found;
}

inline double wide(float value) { return static_cast<double>(value); }

// Fat, muscle, fat, bone: the third layer is another object of the same medium as the background.
inline constexpr std::array<medium, 3> media{
    medium{.density = 930, .sound_speed = 1455, .attenuation = 60},
    medium{.density = 1075, .sound_speed = 1580, .attenuation = 100, .attenuation_power = 1.1F},
    medium{.density = 1910, .sound_speed = 3500, .attenuation = 500}};

inline constexpr std::array<layer, 4> layers{layer{0, 10_mm, 0}, layer{10_mm, 14_mm, 1, 1}, layer{14_mm, 20_mm, 0, 2},
                                             layer{20_mm, 60_mm, 2, 3}};

inline double level(double decibels) { return std::pow(10.0, decibels / 20); }

inline double reflection(const medium& a, const medium& b) {
    const double z1 = wide(a.density) * a.sound_speed, z2 = wide(b.density) * b.sound_speed;
    return (z2 - z1) / (z2 + z1);
}

// dB there and back
inline double loss(const medium& m, double metres, double megahertz) {
    return 2 * wide(m.attenuation) * std::pow(megahertz, wide(m.attenuation_power)) * metres;
}

} // namespace physical_law_test

#endif
