// What `trace` approximates, beside what it stands for: elevation planes beside the whole beam, for an anechoic sphere and on a
// sector; tissue mirrored by a ball of bone, by straight lines and by paths.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <utility>
#include <vector>

using namespace insonify;

namespace {

constexpr medium speckled{.density = 1050, .sound_speed = 1540, .backscatter = 1},
    anechoic{.density = 1050, .sound_speed = 1540};

float decibels(double power) { return static_cast<float>(10 * std::log10(power + 1e-12)); }

physical<> model_of(std::uint32_t seed) { return {.scattering = {.seed = seed}}; }

/// Speckle by the elevation planes of `scan`.
iq_lines by_planes(const scene& body, const auto& probe, const acquisition& scan, std::uint32_t seed) {
    return trace(exec::par_unseq, body, probe, pose{}, model_of(seed), scan, straight_lines{.directions = 1});
}

/// Speckle by 49 parallel slices, weighted by the profile of the beam in elevation at each depth.
iq_lines by_slices(const scene& body, const auto& probe, acquisition scan) {
    constexpr int each_side = 24;
    scan.planes = 1;
    const beam_model beam = beam_of(probe, scan.depth);
    const float widest = 3 * std::fmax(beam.elevation_sigma(0), beam.elevation_sigma(scan.depth));
    iq_lines sum{probe.lines, scan.samples, scan.depth};
    std::vector<float> power(scan.samples, 0.0F);
    for (int i = -each_side; i <= each_side; ++i) {
        const float y = widest * static_cast<float>(i) / each_side;
        const iq_lines slice =
            trace(exec::par_unseq, body, probe, pose{.translation = {0, y, 0}},
                  model_of(static_cast<std::uint32_t>(100 + i)), scan, straight_lines{.directions = 1});
        for (std::uint32_t k = 0; k < scan.samples; ++k) {
            const float z = (static_cast<float>(k) + 0.5F) * scan.depth / static_cast<float>(scan.samples);
            const float u = y / beam.elevation_sigma(z), weight = std::exp(-0.5F * u * u);
            power[k] += weight * weight;
            for (std::uint32_t line = 0; line < sum.count; ++line) sum(line, k) += weight * slice(line, k);
        }
    }
    for (std::uint32_t k = 0; k < scan.samples; ++k)
        for (std::uint32_t line = 0; line < sum.count; ++line) sum(line, k) /= std::sqrt(power[k]);
    return sum;
}

iq_lines received(iq_lines echoes, const auto& probe) {
    return convolve(exec::par_unseq, std::move(echoes), nominal_pulse(probe), probe);
}

image picture_of(iq_lines echoes, const auto& probe, std::uint32_t height) {
    const scan_lines lines = envelope(exec::par_unseq, received(std::move(echoes), probe));
    return scan_convert(exec::par, log_compress(exec::par, lines, {.dynamic_range_db = 50, .reference_db = -42}), probe,
                        {.size = {0, height}});
}

/// Frames of different speckle; `echoes_of` takes a seed.
std::vector<iq_lines> frames_of(const auto& probe, const auto& echoes_of) {
    std::vector<iq_lines> frames;
    for (std::uint32_t seed = 1; seed <= 12; ++seed) frames.push_back(received(echoes_of(seed), probe));
    return frames;
}

/// Mean power around a point of a line.
double power_at(const std::vector<iq_lines>& frames, vec2 line_and_depth) {
    double sum = 0, count = 0;
    for (const iq_lines& seen : frames) {
        const auto line = static_cast<std::uint32_t>(std::lround(line_and_depth.x));
        const auto sample =
            static_cast<std::uint32_t>(line_and_depth.y / seen.depth * static_cast<float>(seen.samples));
        for (std::uint32_t i = line - 1; i <= line + 1; ++i)
            for (std::uint32_t k = sample - 6; k <= sample + 6; ++k, ++count)
                sum += static_cast<double>(dot(seen(i, k), seen(i, k)));
    }
    return sum / count;
}

/// Anechoic spheres by planes and by slices, and how far the middles of some of them fill by planes.
void spheres(const char* file, const auto& probe, const acquisition& scan, std::uint32_t height, float radius,
             std::initializer_list<vec2> middles) {
    scene body{speckled};
    for (const vec2 at : middles) body.add(make_sphere({at.x, 0, at.y}, radius, 5), anechoic);
    body.build(exec::par);
    picture_strip strip{height};
    strip.add(picture_of(by_planes(body, probe, scan, 1), probe, height));
    strip.add(picture_of(by_slices(body, probe, scan), probe, height));
    write_png(file, strip.picture());
    const beam_model beam = beam_of(probe, scan.depth);
    const auto frames = frames_of(probe, [&](std::uint32_t seed) { return by_planes(body, probe, scan, seed); });
    for (const vec2 at : middles) {
        const vec2 where = probe.locate(at);
        const double extent = static_cast<double>(radius / beam.elevation_sigma(where.y));
        std::printf("sphere of %.0f mm at (%.0f, %.0f) mm: %.1f dB by planes, expected %.1f dB\n", 2e3F * radius,
                    at.x / 1_mm, at.y / 1_mm, decibels(power_at(frames, where)) + 55, decibels(std::erfc(extent)));
    }
}

/// Tissue mirrored by a smooth ball of bone, by straight lines and by paths. Returns the largest deviation from the closed form.
float mirrored() {
    constexpr float radius = 4_mm, top = 15_mm;
    constexpr std::uint32_t height = 250;
    medium muscle = tissue::muscle, bone = tissue::bone;
    muscle.structure = structure{};
    muscle.sound_speed = display_speed;
    muscle.attenuation = 0;
    bone.roughness = 1e-9F;
    scene body{muscle};
    body.add(make_sphere({0, 0, top + radius}, radius, 6), bone);
    body.build(exec::par);
    const linear_array probe{.lines = 128, .width = 24_mm, .frequency = 5_MHz};
    const acquisition scan{.depth = 30_mm, .samples = 768};
    const auto by_paths = [&](std::uint32_t seed) {
        return trace(exec::par_unseq, body, probe, pose{}, model_of(seed), scan, paths{});
    };
    picture_strip strip{height};
    strip.add(picture_of(trace(exec::par_unseq, body, probe, pose{}, model_of(1), scan), probe, height));
    strip.add(picture_of(by_paths(1), probe, height));
    write_png("approximate_mirror.png", strip.picture());
    const float reflected = fresnel{}.energy_reflection(muscle, bone, 1);
    const float level = 20 * std::log10(muscle.backscatter) - 55;
    const auto frames = frames_of(probe, by_paths);
    float worst = 0;
    for (const float below : {1_mm, 2_mm, 6_mm, 8_mm}) {
        const float found = decibels(power_at(frames, probe.locate({0, top + below}))) - level;
        const float expected = 2 * decibels(static_cast<double>(reflected / (1 + 2 * below / radius)));
        std::printf("mirrored tissue %.0f mm below the top of a ball of 8 mm: %.1f dB, expected %.1f dB\n",
                    below / 1_mm, found, expected);
        worst = std::fmax(worst, std::fabs(found - expected));
    }
    return worst;
}

} // namespace

int main() {
    spheres("approximate_sphere.png", linear_array{.lines = 128, .width = 20_mm, .frequency = 7.5_MHz},
            {.depth = 42_mm, .samples = 1408, .planes = 5}, 250, 1.5_mm,
            {{4_mm, 20_mm}, {-4_mm, 29_mm}, {4_mm, 35_mm}});
    const auto at = [](float depth, float angle) { return vec2{depth * std::sin(angle), depth * std::cos(angle)}; };
    spheres(
        "approximate_sector.png", phased_array{}, {.depth = 130_mm, .samples = 1024, .planes = 5}, 200, 5_mm,
        {at(60_mm, 0), at(60_mm, 20_deg), at(60_mm, 40_deg), at(110_mm, 0), at(110_mm, 20_deg), at(110_mm, 40_deg)});
    return mirrored() < 2.5F ? 0 : 1;
}
