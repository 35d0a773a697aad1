#include <insonify/signal/persistence.hpp>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

namespace persistence_test {
namespace {

scan_lines frame_of(float grey, std::uint32_t lines = 3) {
    scan_lines frame{lines, 2000, 0.04F};
    for (float& value : frame.values) value = grey;
    return frame;
}

} // namespace

TEST_CASE("persistence: the output decays exponentially from frame to frame") {
    persistence fade{0.75F};
    CHECK(fade.add(exec::seq, frame_of(0.8F), pose{}).values[5] == 0.8F);
    double expected = 0.8;
    for (int i = 0; i < 6; ++i) {
        expected = 0.75 * expected + 0.25 * 0.2;
        const scan_lines& shown = fade.add(exec::par, frame_of(0.2F), pose{});
        CHECK(shown.count == 3);
        CHECK(shown.values.front() == doctest::Approx(expected).scale(1e-30));
        CHECK(shown.values.back() == doctest::Approx(expected).scale(1e-30));
    }
}

TEST_CASE("persistence: by default every frame is shown unchanged") {
    persistence none{};
    none.add(exec::seq, frame_of(0.8F), pose{});
    CHECK(none.add(exec::seq, frame_of(0.2F), pose{}) == frame_of(0.2F));
}

TEST_CASE("persistence: restarts where the probe moves or the grid changes, and on request") {
    persistence fade{0.5F};
    pose moved{};
    moved.translation = {0.001F, 0, 0};
    fade.add(exec::seq, frame_of(1), pose{});
    CHECK(fade.add(exec::seq, frame_of(0), moved).values[0] == 0);
    fade.add(exec::seq, frame_of(1), moved);
    CHECK(fade.add(exec::seq, frame_of(0, 4), moved).values[0] == 0);
    fade.add(exec::seq, frame_of(1, 4), moved);
    scan_lines deeper = frame_of(0, 4);
    deeper.depth = 0.05F;
    CHECK(fade.add(exec::seq, deeper, moved).values[0] == 0);
    deeper = frame_of(1, 4);
    deeper.depth = 0.05F;
    fade.add(exec::seq, deeper, moved);
    fade.reset();
    CHECK(fade.add(exec::seq, frame_of(0.25F), moved).values[0] == 0.25F);
}

TEST_CASE("persistence: weights out of range are refused") {
    for (const float bad : {-0.1F, 1.0F, 2.0F, std::numeric_limits<float>::quiet_NaN()})
        CHECK_THROWS_AS(persistence{bad}, usage_error);
}

} // namespace persistence_test
