#include <insonify/motion/body_motion.hpp>
#include "deformed_frames.hpp"
#include <atomic>
#include <doctest/doctest.h>
#include <thread>

using namespace insonify;

/// One thread deforms a scene while another one draws a copy of it, as in the guide.
namespace double_buffering_test {
namespace {

constexpr int frames = 12;
constexpr linear_array probe{.lines = 24, .width = 20_mm, .frequency = 5_MHz};

pulsation map_at(int frame) {
    return {.from = {0, 0, 20_mm},
            .to = {0, 1, 20_mm},
            .radius = 4_mm,
            .amplitude = 1_mm,
            .time = 0.07F * static_cast<float>(frame)};
}
scene vessel() {
    scene body{tissue::muscle};
    body.add(make_cylinder({0, -20_mm, 20_mm}, {0, 20_mm, 20_mm}, 4_mm, 48, 8), tissue::blood);
    body.build(exec::par);
    return body;
}

} // namespace
} // namespace double_buffering_test

TEST_CASE("double buffering: one scene is drawn while its copy is deformed by another thread") {
    using namespace double_buffering_test;
    const auto drawn = [](const scene& body) {
        return trace(exec::par_unseq.threads(2), body, probe, pose{}, physical{}, {.depth = 40_mm, .samples = 512});
    };
    scene buffers[2] = {vessel(), vessel()};
    std::atomic<int> deformed{0}, seen{0}; // numbers of frames; frame i is in buffer i % 2
    std::thread simulation{[&] {
        for (int frame = 0; frame < frames; ++frame) {
            while (seen.load(std::memory_order_acquire) < frame - 1) std::this_thread::yield();
            buffers[frame % 2].deform(exec::par.threads(2), map_at(frame));
            deformed.store(frame + 1, std::memory_order_release);
        }
    }};
    std::vector<iq_lines> pictures;
    for (int frame = 0; frame < frames; ++frame) {
        while (deformed.load(std::memory_order_acquire) <= frame) std::this_thread::yield();
        pictures.push_back(drawn(buffers[frame % 2]));
        seen.store(frame + 1, std::memory_order_release);
    }
    simulation.join();
    scene alone = vessel();
    for (int frame = 0; frame < frames; ++frame) {
        alone.deform(exec::seq, map_at(frame));
        CHECK(drawn(alone) == pictures[static_cast<std::size_t>(frame)]);
    }
    CHECK(pictures[0].values != pictures[2].values);
}
