// Channel data, element by element: a wave front that passes fat and bone; a nerve block sent by plane waves; and its
// picture by delay and sum beside that of `b_mode`.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "nerve_block_phantom.hpp"
#include "picture_strip.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

using namespace insonify;

/// What all elements receive of one transmit: elements from left to right, time downwards; grey is 0.
image record(const channel_data& data, std::uint32_t transmit, float seconds, float white, uvec2 size) {
    image picture{size};
    for (std::uint32_t y = 0; y < size.y; ++y)
        for (std::uint32_t x = 0; x < size.x; ++x) {
            const std::uint32_t element = x * data.elements / size.x;
            const float time = seconds * (static_cast<float>(y) + 0.5F) / static_cast<float>(size.y);
            const auto sample = static_cast<std::uint32_t>((time - data.start) * data.sampling_frequency);
            const float value = sample < data.samples ? data(transmit, element, sample) : 0.0F;
            // The cube root shows weak echoes beside strong ones.
            picture(x, y) = std::clamp(0.5F + 0.5F * std::cbrt(value / white), 0.0F, 1.0F);
        }
    return picture;
}

float largest(const channel_data& data) {
    float size = 0;
    for (const float value : data.values) size = std::max(size, std::fabs(value));
    return size;
}

int main() {
    const element_array array = presets::l11_5v_elements;
    const std::uint32_t height = 400;

    // One wave from 30 mm deep, through muscle alone, and with a lens of fat and a bone in its way: it comes late behind
    // the fat, and behind the bone not at all.
    const std::vector<point_scatterer> source{{{0, 0, 30_mm}, 1e-3F}};
    medium silent = tissue::muscle;
    silent.backscatter = 0;
    scene body{silent};
    medium fat = tissue::fat;
    fat.backscatter = 0;
    mesh lens = make_sphere({0, 0, 0}, 1, 5);
    for (vec3& p : lens.positions) p = vec3{-7_mm, 0, 14_mm} + p * vec3{5_mm, 30_mm, 4_mm};
    body.add(lens, fat);
    body.add(make_sphere({9_mm, 0, 16_mm}, 3_mm, 5), tissue::bone);
    body.build(exec::par);
    const std::vector<transmit> middle{full_synthetic_aperture(array)[64]};
    const channel_data wave = trace_channels(exec::par_unseq, body, array, pose{}, physical{}, middle,
                                             {.depth = 34_mm, .surfaces = false, .points = source});
    picture_strip strip{height};
    const float until = 60e-6F;
    strip.add(record(wave, 0, until, largest(wave), {256, height}));

    // A nerve block by eleven plane waves.
    const scene block = nerve_block_phantom().build(exec::par);
    const std::vector<transmit> sent = plane_waves(array, 11, 20_deg);
    const channel_data received =
        trace_channels(exec::par_unseq, block, array, pose{}, physical{}, sent, {.depth = 36_mm, .opening = 10_deg});
    strip.add(record(received, 5, until, 0.1F * largest(received), {256, height}));

    // Delay and sum, and what follows it; beside it the same from lines alone.
    linear_array probe = presets::l11_5v;
    probe.lines = 256;
    const float depth = 36_mm;
    iq_lines lines = beamform(exec::par_unseq, received, probe, {.depth = depth, .samples = 1536}, {.fnumber = 1.5F});
    scan_lines seen =
        tgc(exec::par_unseq, envelope(exec::par_unseq, lines), probe.frequency,
            {.attenuation = automatic_tgc(exec::par_unseq, block, probe, pose{}, depth), .bandwidth = probe.bandwidth});
    // Plane waves focus less sharply than single beams do: their mirrors and speckle are weaker by about 14 dB.
    seen = log_compress(exec::par_unseq, std::move(seen), {.reference_db = -39});
    strip.add(scan_convert(exec::par_unseq, seen, probe, {.size = {0, height}}));
    strip.add(b_mode(exec::par_unseq, block, probe, pose{}, {.depth = depth, .size = {0, height}}));
    write_png("channel_data.png", strip.picture());
    std::printf("%u transmits, %u elements, %u samples at %.1f MHz\n", received.transmits, received.elements,
                received.samples, static_cast<double>(received.sampling_frequency) * 1e-6);
    return 0;
}
