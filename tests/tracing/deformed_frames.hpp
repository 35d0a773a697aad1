#ifndef INSONIFY_TESTS_TRACING_DEFORMED_FRAMES_HPP
#define INSONIFY_TESTS_TRACING_DEFORMED_FRAMES_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <vector>

/// Envelopes of a calf that is pressed, and where windows of one are found in another.
namespace deformed_test {

using namespace insonify;

inline constexpr linear_array probe{.lines = 192, .width = 30_mm, .frequency = 7.5_MHz};
inline constexpr acquisition scan{.depth = 40_mm, .samples = 2000}; // 20 um

/// Tissue sinks below a probe, and less with depth.
struct pressed {
    float depth = 0;
    vec3 operator()(vec3 rest) const {
        const float across = std::exp(-rest.x * rest.x / (2 * 15_mm * 15_mm));
        return {rest.x, rest.y, rest.z + depth * across * std::exp(-std::fmax(rest.z, 0.0F) / 20_mm)};
    }
};

/// Fat, fascia, muscle and bone. Geometric depth is displayed depth for `model`.
inline scene calf() {
    scene body{tissue::muscle};
    body.add(make_box({-40_mm, -20_mm, -5_mm}, {40_mm, 20_mm, 4_mm}, 5), tissue::fat);
    body.add(make_box({-40_mm, -20_mm, 4_mm}, {40_mm, 20_mm, 4.5_mm}, 5), tissue::fascia);
    body.add(make_cylinder({0, -40_mm, 42_mm}, {0, 40_mm, 42_mm}, 9_mm, 64), tissue::bone);
    body.build(exec::par);
    return body;
}
inline physical<> model() { return {.timing = timing::uniform}; }

/// An envelope by line and depth.
struct frame {
    std::vector<float> values;

    explicit frame(const iq_lines& iq) {
        for (const vec2 v : convolve(exec::par_unseq, iq, pulse{}, probe).values) values.push_back(length(v));
    }
    /// At a line and a depth in metres, linear in between.
    float at(int line, float depth) const {
        const float sample = depth / scan.depth * static_cast<float>(scan.samples) - 0.5F;
        const auto below = static_cast<std::size_t>(sample);
        const float* first = values.data() + static_cast<std::size_t>(line) * scan.samples + below;
        const float part = sample - static_cast<float>(below);
        return (1 - part) * first[0] + part * first[1];
    }
};
inline frame frame_of(const scene& body) { return frame{trace(exec::par_unseq, body, probe, pose{}, model(), scan)}; }
inline float x_of(int line) { return probe.width * aperture_fraction(static_cast<float>(line), probe.lines); }

/// Normalised cross-correlation, value by value.
class correlation {
  public:
    void add(float a, float b) {
        const double x = static_cast<double>(a), y = static_cast<double>(b);
        n_ += 1, x_ += x, y_ += y, xx_ += x * x, yy_ += y * y, xy_ += x * y;
    }
    double value() const {
        return (xy_ / n_ - x_ * y_ / n_ / n_) /
               std::sqrt((xx_ / n_ - x_ * x_ / n_ / n_) * (yy_ / n_ - y_ * y_ / n_ / n_));
    }

  private:
    double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, yy_ = 0, xy_ = 0;
};

/// Where a window of one frame is found in another one, along the line.
struct match {
    float moved = 0;        ///< metres
    double correlation = 0; ///< there
};
/// @param stretch  of the window in `now`: metres for each metre at rest
inline match find_window(const frame& rest, const frame& now, int line, float depth, float stretch, float from,
                         float to) {
    constexpr float half = 1_mm, step = 0.02_mm;
    const auto at = [&](float moved) {
        correlation sum;
        for (int i = line - 4; i <= line + 4; ++i)
            for (float z = -half; z <= half; z += 0.02_mm)
                sum.add(rest.at(i, depth + z), now.at(i, depth + moved + stretch * z));
        return sum.value();
    };
    match best;
    for (float moved = from; moved <= to; moved += step)
        if (const double found = at(moved); found > best.correlation) best = {moved, found};
    const double before = at(best.moved - step), after = at(best.moved + step); // parabola through the peak
    const double bend = before - 2 * best.correlation + after;
    if (bend < 0) best.moved += step * static_cast<float>(0.5 * (before - after) / bend);
    return best;
}

} // namespace deformed_test
#endif
