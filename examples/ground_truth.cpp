// Training data: an image, the object that each pixel shows, and how much sound arrives there.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <cstdio>

int main() {
    using namespace insonify;
    scene body{tissue::muscle};
    const object_id fat = body.add(make_box({-40_mm, -40_mm, -5_mm}, {40_mm, 40_mm, 8_mm}), tissue::fat);
    const object_id vessel = body.add(make_sphere({-8_mm, 0, 20_mm}, 5_mm, 5), tissue::blood);
    const object_id bone = body.add(make_sphere({9_mm, 0, 28_mm}, 6_mm, 5), tissue::bone);
    body.build(exec::par);

    const linear_array probe{};
    const float depth = 45_mm;
    const uvec2 size{240, 0};
    const image picture = b_mode(exec::par_unseq, body, probe, pose{}, {.depth = depth, .size = size});

    // On the displayed grid, so that labels and echoes have the same depth.
    const label_settings settings{.depth = depth, .samples = 500, .grid = label_settings::depth_grid::displayed};
    const ground_truth_lines truth = ground_truth(exec::par, body, probe, pose{}, settings);
    const scan_map map = make_scan_map(exec::par, probe, {.depth = depth, .samples = 500}, {.size = size});
    const label_image labels = scan_convert(exec::par, truth.label, map);
    const image arriving = scan_convert(exec::par, truth.transmitted, map);

    // To look at: one brightness per label, and 60 dB of shadow from white to black.
    image greys{map.size}, shadow{map.size};
    for (std::size_t i = 0; i < greys.pixels.size(); ++i) {
        greys.pixels[i] =
            labels.pixels[i] == background_label ? 0.2F : 0.4F + 0.3F * static_cast<float>(labels.pixels[i]);
        shadow.pixels[i] = 1 + std::log10(max(arriving.pixels[i], 1e-6F)) / 3;
    }
    write_png("ground_truth_picture.png", picture);
    write_png("ground_truth_labels.png", greys);
    write_png("ground_truth_shadow.png", shadow);

    // Blood must be darker than muscle, and sound must be lost behind bone but not behind blood.
    const auto grey_of = [&](label_id id) {
        double sum = 0, pixels = 0;
        for (std::size_t i = 0; i < labels.pixels.size(); ++i)
            if (labels.pixels[i] == id) sum += static_cast<double>(picture.pixels[i]), ++pixels;
        return sum / pixels;
    };
    const auto arriving_at = [&](float x, float z) {
        const vec2 pixel = map.pixel({x, z});
        return arriving(static_cast<std::uint32_t>(pixel.x), static_cast<std::uint32_t>(pixel.y));
    };
    const double blood = grey_of(static_cast<label_id>(vessel)), muscle = grey_of(background_label);
    const float free = arriving_at(0, 40_mm), behind_bone = arriving_at(9_mm, 40_mm),
                behind_blood = arriving_at(-8_mm, 40_mm);
    std::printf(
        "brightness of blood %.2f, of muscle %.2f; amplitude at 40 mm %.1e, behind bone %.1e, behind blood %.1e\n",
        blood, muscle, static_cast<double>(free), static_cast<double>(behind_bone), static_cast<double>(behind_blood));
    return picture.size == labels.size && labels(120, 6) == static_cast<label_id>(fat) &&
                   labels(176, 150) == static_cast<label_id>(bone) && blood < 0.8 * muscle &&
                   behind_bone < 0.01F * free && behind_blood > 2 * free
               ? 0
               : 1;
}
