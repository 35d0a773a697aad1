// Covers tracing/aperture/aperture_view.hpp, tracing/find/line_layers.hpp.
#include "../device/frame_steps.hpp"

#include <insonify/insonify.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <utility>

using namespace insonify;

namespace frame_steps_test {
namespace {

// The largest difference of two samples, over the largest sample.
template <class Probe>
float difference_from_trace(const scene& body, const Probe& probe, const acquisition& scan) {
    frame_memory<physical<>> memory;
    const frame_steps<physical<>> all = memory.prepare(body, probe, physical{}, scan);
    for (const frame_step one : all_frame_steps)
        for (std::size_t i = 0; i < all.count(one); ++i) all.run(one, i);
    CHECK(std::none_of(all.too_small.begin(), all.too_small.end(), [](std::uint32_t one) { return one != 0; }));

    const iq_lines expected = trace(exec::par, body, probe, pose{}, physical{}, scan);
    REQUIRE(expected.values.size() == all.samples.size());
    float worst = 0, largest = 0;
    for (std::size_t i = 0; i < expected.values.size(); ++i) {
        worst = std::max(worst, length(expected.values[i] - all.samples[i]));
        largest = std::max(largest, length(expected.values[i]));
    }
    return worst / largest;
}

} // namespace

TEST_CASE("the steps of a default frame, one by one over flat arrays, give what trace does") {
    scene body{tissue::muscle};
    body.add(make_box({-60_mm, -20_mm, -1_mm}, {60_mm, 20_mm, 6_mm}, 2), tissue::fat);
    body.add(make_cylinder({-8_mm, -20_mm, 17_mm}, {-8_mm, 20_mm, 17_mm}, 4_mm, 64, 8), tissue::blood);
    body.add(make_needle(1.2_mm, 30_mm), tissue::steel,
             {.priority = 2, .at = look_at({9_mm, 0, 14_mm}, {23_mm, 0, 20_mm}, {0, 1, 0})});
    body.add(make_sphere({5_mm, 0, 34_mm}, 9_mm, 5), tissue::bone);
    body.build(exec::par);
    const auto each = [&](const char* name, const auto& probe) {
        for (const std::uint32_t planes : {1U, 5U}) {
            const acquisition scan{.depth = 40_mm, .samples = 1024, .planes = planes};
            CAPTURE(name);
            CAPTURE(planes);
            // Slices, which trace prefers to rays here, find the same crossings within rounding of 5 nm, a few degrees of phase.
            CHECK(difference_from_trace(body, probe, scan) < 1e-3F);
        }
    };
    each("linear", linear_array{.lines = 128, .width = 40_mm, .frequency = 7.5_MHz});
    each("convex", convex_array{.lines = 96, .radius = 50_mm, .field_of_view = 60_deg, .frequency = 3.5_MHz});
    each("phased", phased_array{.lines = 96, .width = 20_mm, .field_of_view = 80_deg, .frequency = 3_MHz});
}

} // namespace frame_steps_test
