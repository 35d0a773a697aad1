// The stages of a convex array's image: echoes, received echoes, the same with gain, and the scan-converted image. The
// first three are drawn line beside line, as they are in memory.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cstdio>

int main() {
    using namespace insonify;
    medium even = tissue::liver; // without mottling, so that levels at two depths can be compared
    even.structure = structure{};
    scene body{even};
    body.add(make_cylinder({-15_mm, -60_mm, 45_mm}, {-15_mm, 60_mm, 45_mm}, 12_mm, 96), tissue::bile);
    body.add(make_cylinder({20_mm, -60_mm, 75_mm}, {20_mm, 60_mm, 75_mm}, 10_mm, 96), tissue::bone);
    body.build(exec::par);
    const convex_array probe{.lines = 160};
    const acquisition scan{.depth = 120_mm, .planes = 5};

    const iq_lines echoes = trace(exec::par_unseq, body, probe, pose{}, physical{}, scan);
    const iq_lines received = convolve(exec::par_unseq, echoes, nominal_pulse(probe), probe);
    const scan_lines amplitude = envelope(exec::par_unseq, received);
    const scan_lines raised = tgc(exec::par_unseq, amplitude, probe.frequency, {.bandwidth = probe.bandwidth});
    const scan_lines grey = log_compress(exec::par_unseq, raised);

    constexpr std::uint32_t height = 170;
    picture_strip strip{height};
    strip.add(log_compress(exec::par_unseq, envelope(exec::par_unseq, echoes)));
    strip.add(log_compress(exec::par_unseq, amplitude));
    strip.add(grey);
    strip.add(scan_convert(exec::par, grey, probe, {.size = {0, height}}));
    write_png("stages.png", strip.picture());

    // Echoes lose what the pulse loses in liver, 0.52 f^1.05 dB/cm. Gain restores that but for 3 dB, since `tgc` assumes 0.5 f.
    const auto level = [&](const scan_lines& lines, std::uint32_t begin,
                           std::uint32_t end) { // dB, mean of the outer lines
        double power = 0, count = 0;
        for (std::uint32_t line = 0; line < 20; ++line)
            for (std::uint32_t k = begin * lines.samples / 6; k < end * lines.samples / 6; ++k, ++count)
                power += static_cast<double>(lines(line, k)) * static_cast<double>(lines(line, k));
        return 10 * std::log10(power / count);
    };
    const double lost = level(amplitude, 1, 2) - level(amplitude, 5, 6),
                 left = level(raised, 1, 2) - level(raised, 5, 6);
    const auto loss = [&](float shown) {
        const float depth = shown * even.sound_speed / display_speed;
        return attenuated(echo_loss(even, probe.frequency) * depth, probe.frequency, probe.bandwidth).loss_db;
    };
    const double expected = loss(110_mm) - loss(30_mm);
    std::printf("from 30 to 110 mm the echoes lose %.1f dB, expected %.1f, with gain %.1f dB\n", lost, expected, left);
    return std::fabs(lost - expected) < 1 && std::fabs(left - 3) < 1 ? 0 : 1;
}
