// Reverberation: a steel needle in muscle, by straight lines without ringing, and by paths, which add its comet tail.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>

#include <cstdio>

using namespace insonify;

int main() {
    medium smooth_steel = tissue::steel;
    smooth_steel.roughness = 0.001_um; // a mirror; 0 would leave it to the muscle
    scene body{tissue::muscle};
    body.add(make_cylinder({0, -20_mm, 12_mm}, {0, 20_mm, 12_mm}, 0.6_mm, 192),
             smooth_steel); // normal to the slice plane
    body.add(make_box({-20_mm, -20_mm, 30_mm}, {20_mm, 20_mm, 31_mm}), tissue::fascia);
    body.build(exec::par);

    const linear_array probe{.lines = 256, .width = 20_mm, .frequency = 7.5_MHz, .focus = 12_mm};
    const acquisition scan{.depth = 25_mm, .samples = 1600, .planes = 1};
    const auto draw = [&](const char* file, const iq_lines& echoes) {
        scan_lines lines = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, pulse{}, probe));
        lines = tgc(exec::par, std::move(lines), probe.frequency, {.attenuation = 100});
        write_png(file, scan_convert(exec::par, log_compress(exec::par, lines), probe, {.size = {300, 0}}));
        return lines;
    };
    const scan_lines straight =
        draw("needle_straight.png", trace(exec::par_unseq, body, probe, pose{}, physical<>{.min_ringing = 1}, scan));
    const scan_lines bouncing = draw(
        "needle_paths.png", trace(exec::par_unseq, body, probe, pose{}, physical<>{}, scan, paths{{.bounces = 20}}));

    // Straight lines give no echo below the needle. Sound that reverberates in the needle returns later each time.
    const auto below = [&](const scan_lines& lines) {
        float largest = 0;
        for (std::uint32_t k = 0; k < lines.samples; ++k)
            if (const float z = (static_cast<float>(k) + 0.5F) * lines.depth / static_cast<float>(lines.samples);
                z > 13_mm && z < 15_mm)
                largest = std::max(largest, lines(128, k));
        return largest;
    };
    std::printf("largest echo 1.6 to 3.6 mm below the needle: %g straight, %g by paths\n",
                static_cast<double>(below(straight)), static_cast<double>(below(bouncing)));
    return below(bouncing) > 10 * below(straight) ? 0 : 1;
}
