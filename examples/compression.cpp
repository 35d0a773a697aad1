// Compression ultrasound: a probe is pressed onto an artery and a vein. The vein collapses and its flow stops; the artery pulses on.
//
// Draws compression.png: above in systole, below in diastole, pressure increasing from left to right. A cycle of pressing and
// releasing as an animation (ffmpeg from Debian):
//
//     compression --frames cycle
//     ffmpeg -framerate 12 -i cycle/%03d.png -vf split[a][b],[a]palettegen[p],[b][p]paletteuse compression.gif
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "nerve_block_phantom.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

using namespace insonify;

namespace {

constexpr float heart_rate = 1.2_Hz,
                slope = 0.47F; // of the vessels, metres of depth for each metre along the limb: 25 degrees

/// A straight vessel along the limb, which descends to positive y.
struct vessel {
    vec2 middle; ///< x, z in the slice
    float radius, wall;
    object_id lumen{};

    vec3 axis_at(float y) const { return {middle.x, y, middle.y + slope * y}; }
    void add_to(scene& body, const char* name) {
        const auto tube = [&](float around, float half_length) {
            return nerve_block::make_along_limb(-half_length, half_length, 32, 96, [&](float y, float turn) {
                const float angle = 2 * pi * turn, up = around * std::sqrt(1 + slope * slope);
                return vec2{middle.x - around * std::cos(angle), axis_at(y).z - up * std::sin(angle)};
            });
        };
        body.add(tube(radius + wall, 16_mm), tissue::vessel_wall, {.priority = 1, .name = std::string{name} + " wall"});
        lumen = body.add(tube(radius, 15.5_mm), tissue::blood, {.priority = 1, .name = name});
    }
};

/// A groin: skin, fat, a fascia, two muscles, and the vessels between them in fat.
struct groin {
    vessel artery{.middle = {-6_mm, 16.5_mm}, .radius = 3.25_mm, .wall = 0.6_mm},
        vein{.middle = {3.5_mm, 17.5_mm}, .radius = 4.5_mm, .wall = 0.3_mm};
    scene body{tissue::air};

    groin() {
        using nerve_block::make_layer, nerve_block::wave, nerve_block::step;
        const auto below = [](float depth) { return [depth](float, float) { return depth; }; };
        const auto fascia = [](float x, float y) {
            return 8.2_mm + 1.2_mm * step(x, 3_mm, 8_mm) + 0.3_mm * wave(x, y, 24_mm, 70_mm, 0.1F);
        };
        const auto lower = [](float x, float y) {
            return 27.5_mm - 2_mm * step(x, -5_mm, 7_mm) + 0.4_mm * wave(x, y, 27_mm, 50_mm, 0.6F);
        };
        body.add(make_layer(50_mm, below(0), below(60_mm)), tissue::skin, {.name = "skin"});
        body.add(
            make_layer(
                49_mm, [](float x, float y) { return 1.5_mm + 0.1_mm * wave(x, y, 17_mm, 40_mm, 0.6F); }, below(59_mm)),
            tissue::fat, {.name = "fat"});
        const auto add_septum = [&](const auto& middle) {
            body.add(make_layer(
                         48.5_mm, [&](float x, float y) { return middle(x, y) - 0.12_mm; },
                         [&](float x, float y) { return middle(x, y) + 0.12_mm; }),
                     tissue::fascia, {.name = "septum"});
        };
        add_septum([](float x, float y) {
            return 3.4_mm + 1.3_mm * step(x, 4_mm, 6_mm) + 0.2_mm * wave(x, y, 16_mm, 40_mm, 0.4F);
        });
        add_septum([](float x, float y) {
            return 6.4_mm - 0.8_mm * step(x, -6_mm, 5_mm) + 0.25_mm * wave(x, y, 21_mm, 50_mm, 0.9F);
        });
        body.add(make_layer(48_mm, fascia, below(58_mm)), tissue::fascia, {.name = "fascia"});
        body.add(make_layer(
                     47_mm, [&](float x, float y) { return fascia(x, y) + 0.6_mm; }, lower),
                 tissue::muscle, {.name = "upper muscle", .fibres = {0.1F, 1, 0.2F}});
        body.add(make_layer(
                     47_mm, [&](float x, float y) { return lower(x, y) + 0.6_mm; }, below(57_mm)),
                 tissue::muscle, {.name = "lower muscle", .fibres = {0.6F, 1, 0}});
        artery.add_to(body, "artery");
        vein.add_to(body, "vein");
        body.build(exec::par);
    }
};

/// A vessel as a map deforms it: an ellipse. Its flow is that of the pressure gradient at rest, by Poiseuille's law.
struct stream : poiseuille {
    vec2 half{}; ///< axes of the ellipse: along x, and across it

    template <class Map>
    stream(const vessel& of, const Map& map, float peak_at_rest) {
        const vec3 middle = of.axis_at(0), up = normalize(vec3{0, -slope, 1});
        half = 0.5F * vec2{length(map(middle + vec3{of.radius, 0, 0}) - map(middle - vec3{of.radius, 0, 0})),
                           length(map(middle + of.radius * up) - map(middle - of.radius * up))};
        const float a = half.x / of.radius, b = half.y / of.radius;
        object = of.lumen;
        from = of.axis_at(-5_mm);
        to = of.axis_at(5_mm);
        radius = of.radius;
        peak_velocity = peak_at_rest * 2 * a * a * a * b * b * b / (a * a + b * b);
    }
};

/// How much of a lumen is coloured.
float filling(const image& velocities, const scan_map& map, const pose& at, const scene& body, const stream& of) {
    int inside = 0, coloured = 0;
    for (std::uint32_t y = 0; y < map.size.y; ++y)
        for (std::uint32_t x = 0; x < map.size.x; ++x) {
            const vec2 point = map.point(x, y);
            const vec3 rest = body.rest_of(at.point({point.x, 0, point.y}));
            if (length(cross(rest - of.from, normalize(of.to - of.from))) > 0.9F * of.radius) continue;
            ++inside;
            coloured += velocities(x, y) != 0 ? 1 : 0;
        }
    return inside > 0 ? static_cast<float>(coloured) / static_cast<float>(inside) : 0;
}

/// One moment of the examination.
struct view_of_vessels {
    colour_image picture{};
    float pressure = 0;                       ///< Pa
    float artery_height = 0, vein_height = 0; ///< metres
    float artery_filling = 0, vein_filling = 0;
};

class examination_of_groin {
  public:
    examination_of_groin() {
        settings_.depth = 33_mm;
        settings_.size = {190, 0};
        machine_.settings = settings_;
    }

    /// @param depth  of the face in the body at rest, metres
    view_of_vessels at(float depth, float time) {
        const pose face{.translation = {0, 0, depth}};
        const contact& touch = pressing_.press(own_.body, probe_, face, {.stiffness = 250, .decay = 30_mm});
        view_of_vessels seen;
        seen.pressure = touch.pressure;
        const auto map = compose(pulsation{.from = own_.artery.axis_at(0),
                                           .to = own_.artery.axis_at(1_mm),
                                           .radius = own_.artery.radius,
                                           .amplitude = 0.25_mm,
                                           .rate = heart_rate,
                                           .time = time},
                                 collapse{.from = own_.vein.axis_at(0),
                                          .to = own_.vein.axis_at(1_mm),
                                          .radius = own_.vein.radius,
                                          .outside = seen.pressure,
                                          .inside = 8_mmHg},
                                 touch.deformation);
        own_.body.deform(exec::par, map);
        const stream in_artery{own_.artery, map, -0.5_m_per_s * beat_(time)}, in_vein{own_.vein, map, 0.2_m_per_s};
        const auto flow = [&](object_id object, vec3 point, float at_time) {
            return in_artery(object, point, at_time) + in_vein(object, point, at_time);
        };
        ++machine_.settings.frame;
        const image& grey = machine_.scan(exec::par_unseq, own_.body, face);
        const flow_lines moving = machine_.colour(exec::par_unseq, own_.body, flow,
                                                  {.prf = 5.5_kHz, .ensemble = 10, .box = box_, .time = time});
        constexpr float slowest = 0.03_m_per_s;
        seen.picture =
            colour_overlay(exec::par, grey, moving, probe_, {.max_velocity = 0.2_m_per_s, .min_velocity = slowest});
        const image velocities =
            doppler_picture(exec::par, moving, probe_, {.size = settings_.size, .min_velocity = slowest});
        const scan_map pixels = make_scan_map(exec::par, probe_, {.depth = settings_.depth}, {.size = settings_.size});
        seen.artery_height = 2 * in_artery.half.y;
        seen.vein_height = 2 * in_vein.half.y;
        seen.artery_filling = filling(velocities, pixels, face, own_.body, in_artery);
        seen.vein_filling = filling(velocities, pixels, face, own_.body, in_vein);
        return seen;
    }

  private:
    groin own_{};
    linear_array probe_ = presets::nerve_block.probe;
    b_mode_settings settings_ = presets::nerve_block.settings;
    colour_box box_{.from = 6_mm, .to = 25_mm, .first_line = 40, .lines = 180};
    pulsatile beat_{.heart_rate = heart_rate, .resistive_index = 0.85F};
    scanner<linear_array> machine_{probe_, settings_};
    presser pressing_{};
};

constexpr float systole = 0.125F, diastole = 0.7F; // seconds

/// Pressing and releasing in five heart beats.
void write_cycle(const std::filesystem::path& folder) {
    examination_of_groin own;
    std::filesystem::create_directories(folder);
    constexpr int frames = 50;
    for (int i = 0; i < frames; ++i) {
        const float time = static_cast<float>(i) / (10 * heart_rate);
        const float pressed = 0.5F - 0.5F * std::cos(2 * pi * static_cast<float>(i) / frames);
        char name[16];
        std::snprintf(name, sizeof name, "%03d.png", i);
        write_png((folder / name).string(), own.at(0.3_mm + 4.2_mm * pressed, time).picture);
    }
}

} // namespace

int main(int count, char** words) {
    if (count == 3 && std::strcmp(words[1], "--frames") == 0) {
        write_cycle(words[2]);
        return 0;
    }
    examination_of_groin own;
    colour_image strip;
    bool as_expected = true;
    float artery_at_rest = 0;
    for (std::uint32_t column = 0; column < 3; ++column)
        for (std::uint32_t row = 0; row < 2; ++row) {
            const float depths[] = {0.3_mm, 0.85_mm, 4.5_mm};
            const view_of_vessels seen = own.at(depths[column], row == 0 ? systole : diastole);
            const uvec2 size = seen.picture.size, step = size + 4U;
            if (strip.pixels.empty()) strip = colour_image{uvec2{3, 2} * step - 4U};
            for (std::uint32_t y = 0; y < size.y; ++y)
                for (std::uint32_t x = 0; x < size.x; ++x) {
                    const vec3 levels = 40.0F * seen.picture(x, y) + 0.5F; // rounded: a smaller file
                    strip(column * step.x + x, row * step.y + y) = vec3{uvec3{levels}} / 40.0F;
                }
            if (column == 0 && row == 0) artery_at_rest = seen.artery_height;
            std::printf("%4.1f mmHg, %s: artery %.1f mm high, %3.0f %% coloured; vein %.1f mm, %3.0f %%\n",
                        seen.pressure / 1_mmHg, row == 0 ? "systole " : "diastole", seen.artery_height / 1_mm,
                        100 * seen.artery_filling, seen.vein_height / 1_mm, 100 * seen.vein_filling);
            const bool closed = column == 2;
            as_expected = as_expected && seen.artery_height > 0.8F * artery_at_rest &&
                          (row == 0 ? seen.artery_filling > 0.9F : seen.artery_filling < 0.8F) &&
                          (closed ? seen.vein_height < 1_mm && seen.vein_filling < 0.05F : seen.vein_filling > 0.5F);
        }
    write_png("compression.png", strip);
    return as_expected ? 0 : 1;
}
