// The stages one by one: every arrow of the pipeline is a value that the caller holds. The scene is the paper's: a cube
// of bone in muscle, where the answer is known in closed form.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <cstdio>

int main() {
    using namespace insonify;

    constexpr medium muscle{1000, 1700, 1.0_dB_per_cm}, bone{1000, 7800, 5.0_dB_per_cm};
    scene body{muscle};
    body.add(make_box({-10_mm, -10_mm, 20_mm}, {10_mm, 10_mm, 40_mm}), bone);
    body.build(exec::par);

    const linear_array probe{.lines = 512, .width = 60_mm, .frequency = 5_MHz};
    const pose at = look_at({0, 0, 0}, {0, 0, 1}, {1, 0, 0}); // from, towards, lateral
    const acquisition scan{.depth = 45_mm, .samples = 384};
    const law2011 law{.reflection_length = 1_mm};

    // The paper's picture, and the same by its own algorithm, pixel by pixel.
    const scan_lines lines = trace(exec::par_unseq, body, probe, at, law, scan);
    const scan_lines pixels = trace_pixels(exec::par, body, probe, at, law, scan);

    // From lines to pixels, by tables that serve every frame; then the noise, made once, and the radial blur.
    const scan_map map = make_scan_map(exec::par, probe, scan, {.size = {512, 384}});
    const image noise = make_noise(exec::par, map.size, {.strength = 0.5F});
    const image picture = scan_convert(exec::par, lines, map);
    const image noisy = add_noise(exec::par, picture, noise);
    write_png("paper_pictures.png", radial_blur(exec::par, noisy, probe, map));

    // Instead of the intensities themselves, decibels.
    const scan_lines grey = log_compress(exec::par, lines, {.dynamic_range_db = 60, .reference_db = 0});
    write_png("paper_pictures_db.png", scan_convert(exec::par, grey, map));

    // I = I_a I_t + I_r where the sound has run through `above` mm of muscle and `inside` mm of bone.
    const auto intensity = [&](double above, double inside, double transmitted, double reflected) {
        return std::pow(10, -(1.0 * above + 5.0 * inside) / 10 * 5 / 20) * transmitted + reflected;
    };
    const double r = std::pow((7.8 - 1.7) / (7.8 + 1.7), 2), t = 1 - r;
    const double spacing = 45.0 / scan.samples;
    double worst = 0;
    for (std::uint32_t k = 0; k < scan.samples; ++k) {
        const double z = (k + 0.5) * spacing;
        const double exact = z < 20   ? intensity(z, 0, 1, z > 19 ? r : 0)
                             : z < 40 ? intensity(20, z - 20, t, z > 39 ? r * t : 0)
                                      : intensity(z - 20, 20, t * t, 0);
        for (const scan_lines* found : {&lines, &pixels})
            worst = std::max(worst, std::fabs((*found)(256, k) / exact - 1));
    }
    std::printf("largest relative deviation from the closed form: %.1e\n", worst);
    return worst < 1e-4 ? 0 : 1;
}
