#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <doctest/doctest.h>
#include <limits>
#include <thread>

using namespace insonify;

namespace trace_test {
namespace {

scene phantom() {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 4), tissue::bone);
    body.add(make_sphere({-15_mm, 0, 25_mm}, 4_mm, 4), tissue::blood);
    body.add(make_box({-30_mm, -30_mm, 0}, {30_mm, 30_mm, 8_mm}, 3), tissue::fat);
    body.build(exec::par);
    return body;
}

struct depth_of_object { // a user's own model, the smallest there is
    using sample_type = std::uint32_t;
    std::uint32_t samples(float, float) const { return 50; }
    void operator()(const auto&, const traced_line& line, float spacing, view<std::uint32_t> out) const {
        for (std::size_t k = 0, i = 0; k < out.size(); ++k) {
            while (i + 1 < line.layers.size() && (static_cast<float>(k) + 0.5F) * spacing >= line.layers[i].end) ++i;
            out[k] = line.layers[i].object;
        }
    }
};
static_assert(acoustic_model<depth_of_object>);

} // namespace
} // namespace trace_test

TEST_CASE("the paper's base scene, traced, has the intensities of its closed form, to 1e-5") {
    // Samples of 1 mm with the face at -0.5 mm in a medium that does not attenuate: sample k stands at k mm of muscle.
    const medium muscle{.density = 1000, .sound_speed = 1700, .attenuation = 1_dB_per_cm};
    scene body{medium{.density = 1000, .sound_speed = 1700}};
    body.add(make_box({-50_mm, -50_mm, 0}, {50_mm, 50_mm, 70_mm}), muscle);
    body.add(make_box({-20_mm, -20_mm, 20_mm}, {20_mm, 20_mm, 40_mm}, 2),
             medium{.density = 2000, .sound_speed = 3900, .attenuation = 5_dB_per_cm});
    body.build(exec::par);
    struct {
        float depth, bare, attenuated; // 5 MHz
    } const rows[] = {{10_mm, 0.5623413F, 0.5623413F},     {19.5_mm, 0.7377610F, 0.4596494F},
                      {20.5_mm, 0.1609371F, 0.1609371F},   {30_mm, 0.01045096F, 0.01045096F},
                      {39.5_mm, 0.2429872F, 9.584799e-4F}, {40.5_mm, 3.355928e-4F, 3.355928e-4F},
                      {50_mm, 1.942283e-4F, 1.942283e-4F}};
    const linear_array probe{.lines = 65, .width = 30_mm, .frequency = 5_MHz};
    for (const float shift : {0.5_mm, 0.25_mm}) { // whole millimetres, and halves
        const pose at{.translation = {0, 0, -shift}};
        const std::uint32_t samples = shift == 0.5_mm ? 60 : 120;
        const acquisition scan{.depth = 60_mm, .samples = samples};
        for (const auto& row : rows)
            for (const auto weakened : {law2011::reflection::bare, law2011::reflection::attenuated}) {
                const float place = (row.depth + shift) / 60_mm * static_cast<float>(samples) - 0.5F;
                const auto k = static_cast<std::uint32_t>(std::lround(place));
                if (std::fabs(place - static_cast<float>(k)) > 1e-3F) continue; // no sample stands there
                const law2011 model{.reflection = weakened};
                const scan_lines simd = trace(exec::par_unseq, body, probe, at, model, scan);
                const scan_lines pixels = trace_pixels(exec::par, body, probe, at, model, scan);
                const float expected = weakened == law2011::reflection::bare ? row.bare : row.attenuated;
                for (std::uint32_t line = 0; line < probe.lines; line += 8) {
                    CHECK(simd(line, k) == doctest::Approx(expected).epsilon(1e-5).scale(1e-30));
                    CHECK(pixels(line, k) == doctest::Approx(expected).epsilon(1e-5).scale(1e-30));
                }
            }
    }
}

TEST_CASE("results are bit-equal on any number of threads, and scalar and SIMD differ by rounding only") {
    const scene body = trace_test::phantom();
    const convex_array probe{.lines = 101, .radius = 40_mm, .field_of_view = 60_deg};
    const acquisition scan{.depth = 60_mm, .samples = 777};
    const scan_lines reference = trace(exec::seq, body, probe, pose{}, law2011{}, scan);
    const scan_lines simd = trace(exec::unseq, body, probe, pose{}, law2011{}, scan);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U}) {
        CHECK(trace(exec::par.threads(threads), body, probe, pose{}, law2011{}, scan) == reference);
        CHECK(trace(exec::par_unseq.threads(threads), body, probe, pose{}, law2011{}, scan) == simd);
    }
    for (std::size_t i = 0; i < reference.values.size(); ++i)
        REQUIRE(simd.values[i] == doctest::Approx(reference.values[i]).epsilon(1e-5).scale(1e-30));
}

TEST_CASE("a scene that has not changed may be traced from many threads at once") {
    const scene body = trace_test::phantom();
    const scan_lines reference =
        trace(exec::par, body, linear_array{}, pose{}, law2011{}, {.depth = 60_mm, .samples = 300});
    std::vector<scan_lines> found(4);
    std::vector<std::thread> callers;
    for (scan_lines& lines : found)
        callers.emplace_back([&] {
            lines = trace(exec::par, body, linear_array{}, pose{}, law2011{}, {.depth = 60_mm, .samples = 300});
        });
    for (std::thread& caller : callers) caller.join();
    for (const scan_lines& lines : found) CHECK(lines == reference);
}

TEST_CASE("a user's own acoustic model makes samples of its own type") {
    const scene body = trace_test::phantom();
    const auto lines = trace(exec::par, body, linear_array{.lines = 3, .width = 1_mm}, pose{},
                             trace_test::depth_of_object{}, {.depth = 50_mm});
    CHECK(lines.samples == 50);
    CHECK(lines(1, 4) == 2);
    CHECK(lines(1, 15) == ~0U);
    CHECK(lines(1, 30) == 0);
    CHECK(lines(1, 45) == ~0U);
}

TEST_CASE("water in water is invisible, and an empty scene is its background") {
    scene body{tissue::water};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 4), tissue::water);
    body.build(exec::par);
    const scene nothing = scene{tissue::water}.build(exec::par);
    CHECK(trace(exec::par, body, linear_array{}, pose{}, law2011{}, {.depth = 60_mm, .samples = 400}) ==
          trace(exec::par, nothing, linear_array{}, pose{}, law2011{}, {.depth = 60_mm, .samples = 400}));
}

TEST_CASE("no sample is ever NaN, negative or infinite, whatever the media") {
    scene body{tissue::air};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 3), medium{.density = 1e-3F, .sound_speed = 10, .attenuation = 1e6F});
    body.add(make_sphere({0, 0, 30_mm}, 5_mm, 3), medium{.density = 1e5F, .sound_speed = 1e5F});
    body.build(exec::par);
    for (const auto& lines :
         {trace(exec::seq, body, linear_array{}, pose{}, law2011{}, {.depth = 60_mm, .samples = 400}),
          trace(exec::unseq, body, linear_array{}, pose{}, law2011{}, {.depth = 60_mm, .samples = 400})})
        for (const float value : lines.values) {
            REQUIRE(is_finite(value));
            REQUIRE(value >= 0);
        }
}

TEST_CASE("what cannot be traced is refused with a sentence") {
    scene body{tissue::water};
    const auto with = [&](const auto& probe, const pose& at, const acquisition& scan) {
        return trace(exec::par, body, probe, at, law2011{}, scan);
    };
    CHECK_THROWS_WITH_AS(with(linear_array{}, pose{}, {}),
                         "scene: call build(policy) after the last add or remove, before tracing or update",
                         usage_error);
    body.build(exec::par);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_AS(with(linear_array{}, pose{}, {.depth = 0}), usage_error);
    CHECK_THROWS_AS(with(linear_array{}, pose{}, {.depth = -1}), usage_error);
    CHECK_THROWS_AS(with(linear_array{}, pose{}, {.depth = nan}), usage_error);
    CHECK_THROWS_AS(with(linear_array{.lines = 0}, pose{}, {}), usage_error);
    CHECK_THROWS_AS(with(linear_array{.width = -1_mm}, pose{}, {}), usage_error);
    CHECK_THROWS_AS(with(linear_array{}, pose{.rotation = mat3{2}}, {}), geometry_error);
    CHECK_THROWS_AS(with(linear_array{.lines = ~0U}, pose{}, {.samples = ~0U}), usage_error);
    CHECK(with(linear_array{}, pose{}, {}).samples % 64 == 0);
    CHECK(with(linear_array{}, pose{}, {.depth = max_scan_depth}).samples == 65536); // bounded
}
