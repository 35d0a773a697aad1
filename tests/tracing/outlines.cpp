#include <insonify/insonify.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace outlines_test {

constexpr vec2 centre{0, 20_mm};
constexpr float radius = 10_mm;

/// Grey levels, 0 to 255, of the outline of a round body in fat that runs across the picture: the brightest within 0.8 mm,
/// in directions of two degrees from its top to its side, averaged over several pictures.
struct outline {
    std::vector<float> grey = std::vector<float>(46, 0.0F); ///< of the angles 0, 2, ... 90 degrees
    float unevenness = 0;                                   ///< deviation over mean along an outline

    float mean(int from, int to) const {
        float sum = 0;
        for (int i = from / 2; i <= to / 2; ++i) sum += grey[static_cast<std::size_t>(i)];
        return sum / static_cast<float>(to / 2 - from / 2 + 1);
    }
};

outline outline_of(const medium& inside) {
    constexpr int pictures = 6;
    std::vector<tube_section> line;
    for (int i = -20; i <= 20; ++i)
        line.push_back({{centre.x, static_cast<float>(i) * 2_mm, centre.y}, {radius, radius}});
    outline all;
    scene body{tissue::fat};
    body.set_background_fibres({1, 0, 0}, {0, 0, 1});
    body.add(make_tube(line, {.segments = 192}), inside, {.fibres = vec3{0, 1, 0}});
    body.build(exec::par);
    const examination<linear_array>& chosen = presets::nerve_block;
    b_mode_settings settings = chosen.settings;
    settings.tgc = 0;
    for (int k = 0; k < pictures; ++k) {
        const vec3 place{0, (static_cast<float>(k) - 2.5F) * 6_mm, 0};
        scanner<linear_array> machine;
        machine.probe = chosen.probe;
        machine.settings = settings;
        const image& seen = machine.scan(exec::par_unseq, body, pose{mat3{1}, place});
        const auto brightest = [&](float angle) {
            float grey = 0;
            for (float away = radius - 0.8_mm; away <= radius + 0.8_mm; away += 0.1_mm) {
                const vec2 at = machine.map().pixel(centre + away * vec2{std::sin(angle), -std::cos(angle)});
                grey = std::max(grey, seen(static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y)));
            }
            return 255 * grey;
        };
        double sum = 0, squares = 0;
        for (std::size_t i = 0; i < all.grey.size(); ++i) {
            const float angle = static_cast<float>(2 * i) * 1_deg, grey = 0.5F * (brightest(angle) + brightest(-angle));
            all.grey[i] += grey / pictures;
            sum += double{grey};
            squares += double{grey} * double{grey};
        }
        const double mean = sum / 46;
        all.unevenness += static_cast<float>(std::sqrt(squares / 46 - mean * mean) / mean / pictures);
    }
    return all;
}

} // namespace outlines_test

TEST_CASE("outlines: the side walls of muscles, nerves and vessels drop out") {
    // As in real pictures of limbs across, where they cannot be followed. The outline of a muscle is also uneven.
    for (const medium& inside : {tissue::muscle, tissue::nerve, tissue::vessel_wall}) {
        const outlines_test::outline seen = outlines_test::outline_of(inside);
        const float facing = seen.mean(0, 10);
        CAPTURE(facing);
        CAPTURE(seen.unevenness);
        CHECK(facing - seen.mean(60, 74) >= 60);
        CHECK(facing - seen.mean(76, 90) >= 60);
        if (inside == tissue::muscle) CHECK(seen.unevenness >= 0.2F);
    }
}
