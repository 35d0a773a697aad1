#include "pictures.hpp"

using namespace insonify;

scene make_body() {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 15_mm}, 6_mm, 4), tissue::blood);
    body.add(make_box({6_mm, -10_mm, 20_mm}, {16_mm, 10_mm, 25_mm}), tissue::bone);
    body.build(exec::par);
    return body;
}

image picture_of_linear_array(const scene& body) {
    return b_mode(exec::par_unseq, body, linear_array{}, pose{}, {.depth = 30_mm});
}

image stages_of_linear_array(const scene& body) {
    const linear_array probe{};
    iq_lines echoes = trace(exec::par_unseq, body, probe, pose{}, physical{}, {.depth = 30_mm, .planes = 3});
    echoes = convolve(exec::par_unseq, std::move(echoes), nominal_pulse(probe), probe);
    echoes = add_electronic_noise(exec::par_unseq, std::move(echoes));
    scan_lines lines = tgc(exec::par_unseq, envelope(exec::par_unseq, echoes), probe.frequency, {.attenuation = 70});
    lines = log_compress(exec::par_unseq, std::move(lines), {.reference_db = -25});
    return scan_convert(exec::par_unseq, lines, probe);
}

iq_lines echoes_of_physical(const scene& body) {
    return trace(exec::par, body, linear_array{}, pose{}, physical{}, {.depth = 30_mm});
}
