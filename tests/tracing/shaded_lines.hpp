#ifndef INSONIFY_TESTS_TRACING_SHADED_LINES_HPP
#define INSONIFY_TESTS_TRACING_SHADED_LINES_HPP

#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>

/// Scenes and probes whose shadows are known.
namespace aperture_shading_test {

using namespace insonify;

/// A model whose samples are what arrives: x for surfaces, y for speckle.
struct arrival_model {
    using sample_type = vec2;
    physical<> model{};

    std::uint32_t samples(float, float) const { return detail::sound_profile::steps; }
    void arrivals(const traced_line& line, float spacing, view<vec2> out) const { model.arrivals(line, spacing, out); }
    template <class Policy>
    void operator()(const Policy&, const traced_line& line, float spacing, view<vec2> out) const {
        model.arrivals(line, spacing, out);
        for (std::size_t k = 0; k < out.size(); ++k) {
            const float along = out[k].x;
            const aperture_gain gain =
                line.gains.at_steps.empty() ? aperture_gain{} : line.gains.at_steps[k]; // at the end of sample k
            out[k] = {line.gains.amplitude(along, gain.surfaces), line.gains.amplitude(along, gain.speckle)};
        }
    }
    friend bool operator==(const arrival_model&, const arrival_model&) = default;
};

inline constexpr medium body{.density = 1000, .sound_speed = 1540};

inline constexpr medium absorber{.density = 1000, .sound_speed = 1540, .attenuation = 1e7F, .attenuation_power = 0};

inline constexpr acquisition scan{.depth = 64_mm, .samples = 64}; // sample k ends at k + 1 mm

inline constexpr linear_array fine{.lines = 768, .width = 38_mm, .frequency = 7.5_MHz, .focus = 20_mm};

/// A thin sheet at a depth, from one place to another across the lines.
inline scene sheet(float from, float to, float depth, const medium& of) {
    scene s{body};
    s.add(make_box({from, -30_mm, depth - 0.1_mm}, {to, 30_mm, depth}), of);
    s.build(exec::par);
    return s;
}

/// The largest deviation of all gains from 1.
template <class Probe>
float max_unevenness(const scene& s, const Probe& probe, const pose& at, const acquisition& how) {
    const iq_lines shaded = trace(exec::par_unseq, s, probe, at, arrival_model{}, how);
    const iq_lines alone = trace(exec::par_unseq, s, probe, at, arrival_model{}, how, straight_lines{.directions = 1});
    float worst = 0;
    for (std::size_t i = 0; i < shaded.values.size(); ++i) {
        if (!(alone.values[i].x > 1e-9F)) continue;
        worst = std::max(worst, std::fabs(shaded.values[i].x / alone.values[i].x - 1));
        worst = std::max(worst, std::fabs(shaded.values[i].y / alone.values[i].y - 1));
    }
    return worst;
}

} // namespace aperture_shading_test

#endif
