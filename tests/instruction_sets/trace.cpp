#include <insonify/insonify.hpp>
#include <cmath>

// A cube of bone, 20 mm to 40 mm deep in muscle, at 5 MHz. Before it, inside it and behind it the intensity is the
// product of attenuation (1 and 5 dB/cm/MHz) and of the interfaces' transmission, T = 4 Z1 Z2 / (Z1 + Z2)^2.
namespace INSTRUCTION_SET {

bool agrees();

bool agrees() {
    using namespace insonify;
    const medium muscle{.density = 1000, .sound_speed = 1700, .attenuation = 1.0_dB_per_cm};
    const medium bone{.density = 2000, .sound_speed = 3900, .attenuation = 5.0_dB_per_cm};
    scene body{muscle};
    body.add(make_box({-10_mm, -10_mm, 20_mm}, {10_mm, 10_mm, 40_mm}), bone);
    body.build(exec::par);

    const double transmission = 4 * 1.7 * 7.8 / (9.5 * 9.5);
    const double expected[3] = {std::pow(10, -5 / 20.0), transmission * std::pow(10, -35 / 20.0),
                                transmission * transmission * std::pow(10, -65 / 20.0)};
    const auto holds = [&](const auto& policy) {
        const linear_array probe{.lines = 8, .width = 10_mm, .frequency = 5_MHz};
        const scan_lines lines = trace(policy, body, probe, pose{}, law2011{}, {.depth = 60_mm, .samples = 3});
        for (std::uint32_t line = 0; line < 8; ++line)
            for (std::uint32_t sample = 0; sample < 3; ++sample)
                if (!(std::abs(lines(line, sample) / expected[sample] - 1) < 1e-5)) return false;
        return true;
    };
    return holds(exec::seq) && holds(exec::par) && holds(exec::unseq) && holds(exec::par_unseq);
}

} // namespace INSTRUCTION_SET
