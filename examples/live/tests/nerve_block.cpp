/// The recorded nerve block, without pictures: where the needle ends, and what is measured there. live_tests nerve_block FILE
#include "../recording.hpp"
#include <cmath>
#include <cstdio>

namespace nerve_block_test {

using namespace insonify;

int run(const std::string& recording) {
    std::uint32_t frames = 0;
    float nearest = 1;
    live::session one;
    for (const live::step& next : live::load_recording(recording).steps) {
        if (next.what && next.what->name == "freeze") one.frame(exec::par_unseq); // there must be a picture
        for (live::player steps{{next}}; steps.advance(one); ++frames) {
            one.advance(exec::par_unseq);
            nearest = std::min(nearest, one.tip_distance("epineurium").value_or(1));
        }
    }
    const float measured = one.measured.empty() ? 0 : one.measured.back().length;
    std::printf("%u frames; needle to nerve: %.2f mm by geometry, %.2f mm measured; 2 mm expected\n", frames,
                1e3 * static_cast<double>(nearest), 1e3 * static_cast<double>(measured));
    const bool holds = frames == 1800 && std::fabs(nearest - 2_mm) < 0.1_mm && std::fabs(measured - 2_mm) < 0.3_mm;
    return holds ? 0 : 1;
}

} // namespace nerve_block_test
