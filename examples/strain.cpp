// Strain from channel data: tissue is compressed by one per cent, a stiff layer in it by half of that; two frames of plane
// waves are beamformed, and the echoes are tracked from one to the other.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

using namespace insonify;

namespace strain {

const element_array array{.elements = 64};
const linear_array lines{.lines = 64, .width = 12.8_mm, .frequency = array.frequency};
const acquisition grid{.depth = 30_mm, .samples = 3000};
const float step = grid.depth / static_cast<float>(grid.samples); // from sample to sample

/// Displacement along z of tissue that was at a depth at rest: strain -1 %, and less in a Gaussian layer around 18 mm.
/// @param stiff  by how much less there, 0 to 1
float displacement(float z, float stiff) {
    const float width = 3_mm, middle = 18_mm;
    const float within = 0.5F * std::sqrt(pi) * width * (std::erf((z - middle) / width) + std::erf(middle / width));
    return -0.01F * (z - stiff * within);
}

iq_lines frame(const scene& body) {
    const channel_data received = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                                 plane_waves(array, 5, 10_deg), {.depth = 31_mm, .opening = 5_deg});
    return beamform(exec::par_unseq, received, lines, grid, {.fnumber = 2});
}

/// One sample of a line between its samples.
vec2 sample(const iq_lines& of, std::uint32_t line, float place) {
    const auto below = static_cast<std::uint32_t>(std::clamp(place, 0.0F, static_cast<float>(of.samples - 2)));
    const float part = place - static_cast<float>(below);
    return (1 - part) * of(line, below) + part * of(line, below + 1);
}

/// Displacement of the echoes from one frame to the next, of each sample, metres: where the phase of their correlation
/// over a window is 0. Each depth starts from the one above, so that phases are never ambiguous.
scan_lines track(const iq_lines& before, const iq_lines& after) {
    const int half = 75, windows_apart = 10;                          // samples: 0.75 and 0.1 mm
    const float per_metre = 4 * pi * array.frequency / display_speed; // radians
    scan_lines moved{before.count, before.samples, before.depth};
    for (std::uint32_t line = 0; line < before.count; ++line) {
        float shift = 0;
        for (int middle = 100; middle + half < static_cast<int>(before.samples); middle += windows_apart) {
            for (int again = 0; again < 3; ++again) {
                vec2 sum{0, 0};
                for (int k = middle - half; k <= middle + half; ++k) {
                    const vec2 a = before(line, static_cast<std::uint32_t>(k)),
                               b = sample(after, line, static_cast<float>(k) + shift / step);
                    sum += vec2{b.x * a.x + b.y * a.y, b.y * a.x - b.x * a.y};
                }
                const float phase = std::atan2(sum.y, sum.x) + per_metre * shift; // 0 where the shift is right
                shift -= std::remainder(phase, 2 * pi) / per_metre;
            }
            for (int k = middle; k < std::min(middle + windows_apart, static_cast<int>(before.samples)); ++k)
                moved(line, static_cast<std::uint32_t>(k)) = shift;
        }
    }
    return moved;
}

/// The slope of a straight line through the mean of all lines, over 2.4 mm.
std::vector<float> strain_of(const scan_lines& moved) {
    const int half = 120; // samples
    std::vector<float> mean(moved.samples, 0), strain(moved.samples, 0);
    for (std::uint32_t line = 0; line < moved.count; ++line)
        for (std::uint32_t k = 0; k < moved.samples; ++k) mean[k] += moved(line, k) / static_cast<float>(moved.count);
    for (int k = 200; k + half + 100 < static_cast<int>(moved.samples); ++k) {
        float along = 0, squares = 0;
        for (int i = -half; i <= half; ++i) {
            along += static_cast<float>(i) * mean[static_cast<std::size_t>(k + i)];
            squares += static_cast<float>(i * i);
        }
        strain[static_cast<std::size_t>(k)] = along / (squares * step);
    }
    return strain;
}

/// Grey by a value: black at 0, white at a value.
image drawn(uvec2 size, float white, const auto& value) {
    image picture{size};
    for (std::uint32_t y = 0; y < size.y; ++y)
        for (std::uint32_t x = 0; x < size.x; ++x) picture(x, y) = std::clamp(value(x, y) / white, 0.0F, 1.0F);
    return picture;
}

} // namespace strain

int main() {
    using namespace strain;
    const scene rest = scene{medium{.density = 1000, .sound_speed = display_speed, .backscatter = 1}}.build(exec::par);
    const iq_lines before = frame(rest);
    const auto compressed = [&](float stiff) {
        scene body = rest;
        body.deform(exec::par, [=](vec3 p) { return vec3{p.x, p.y, p.z + displacement(p.z, stiff)}; });
        return body;
    };

    // One per cent everywhere: from 4 to 28 mm, by a straight line.
    const scan_lines even = track(before, frame(compressed(0)));
    double along = 0, squares = 0;
    for (std::uint32_t k = 400; k < 2800; ++k)
        for (std::uint32_t line = 0; line < even.count; ++line) {
            const double z = (static_cast<double>(k) - 1599.5) * static_cast<double>(step);
            along += z * static_cast<double>(even(line, k));
            squares += z * z;
        }
    const double percent = 100 * along / squares;

    const scene layered = compressed(0.5F);
    const scan_lines moved = track(before, frame(layered));
    const std::vector<float> strain = strain_of(moved);
    const uvec2 size{128, 300};
    const tissue_maps truth =
        map_tissue(exec::par, layered, pose{}, {.from = {-6.4_mm, 0}, .spacing = 0.1_mm, .size = size});
    const float white = 0.3_mm;
    const auto column = [&](std::uint32_t x) { return x * lines.lines / size.x; };
    picture_strip strip{size.y};
    strip.add(scan_convert(exec::par_unseq,
                           log_compress(exec::par_unseq, envelope(exec::par_unseq, before), {.reference_db = -50}),
                           lines, {.size = {0, size.y}}));
    strip.add(drawn(size, white, [&](auto x, auto y) { return -moved(column(x), 10 * y); }));
    strip.add(drawn(size, white, [&](auto x, auto y) { return -truth.displacement[y * size.x + x].y; }));
    strip.add(drawn(size, 0.012F, [&](auto, auto y) { return -strain[10 * y]; }));
    strip.add(drawn(size, 0.012F, [&](auto x, auto y) { return -truth.strain[y * size.x + x].axial; }));
    write_png("strain.png", strip.picture());

    float worst = 0;
    for (std::uint32_t k = 400; k < 2700; ++k) {
        const float z = (static_cast<float>(k) + 0.5F) * step;
        const float expected = (displacement(z + 0.5_mm, 0.5F) - displacement(z - 0.5_mm, 0.5F)) / 1_mm;
        worst = std::max(worst, std::fabs(strain[k] - expected));
    }
    std::printf("strain %.4f %%, expected -1; with a stiff layer within %.2f %% of the truth at every depth\n", percent,
                100 * static_cast<double>(worst));
    return std::fabs(percent + 1) < 0.005 ? 0 : 1;
}
