#include <insonify/core/units.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include "scan_lines.hpp"
#include <doctest/doctest.h>
#include <limits>
#include <string>

using namespace insonify;

namespace scan_convert_test {
namespace {

// Counts its checks: one for each map.
struct counted : linear_array {
    static inline int checks = 0;
    void check() const {
        ++checks;
        linear_array::check();
    }
    friend bool operator==(const counted&, const counted&) = default;
};

// Not equality comparable.
struct incomparable : counted {
    friend bool operator==(const incomparable&, const incomparable&) = delete;
};

} // namespace

TEST_CASE("scan_map: points and pixels convert into each other, pixel centres are at half-integers") {
    const linear_array probe{.lines = 10, .width = 40_mm};
    const scan_map map = make_scan_map(exec::seq, probe, {.depth = 40_mm, .samples = 10}, {.size = {400, 400}});
    CHECK(map.point(0, 0).x == doctest::Approx(-0.01995).scale(1e-30));
    CHECK(map.point(0, 0).y == doctest::Approx(0.00005).scale(1e-3));
    CHECK(map.point({0, 400}).x == doctest::Approx(-0.02).scale(1e-30));
    CHECK(map.point({0, 400}).y == doctest::Approx(0.04).scale(1e-30));
    CHECK(map.pixel({0, 20_mm}).x == doctest::Approx(200).scale(1e-30));
    CHECK(map.pixel({0, 20_mm}).y == doctest::Approx(200).scale(1e-30));
    CHECK(map.pixel({10.05_mm, 0.25_mm}).x == doctest::Approx(300.5).scale(1e-30));
    CHECK(map.pixel({10.05_mm, 0.25_mm}).y == doctest::Approx(2.5).scale(1e-30));
}

TEST_CASE("scan_convert: a map that is kept gives the same image as a temporary one, for any number of threads") {
    const convex_array probe{.lines = 64};
    scan_lines lines{64, 100, 90_mm};
    for (std::size_t i = 0; i < lines.values.size(); ++i) lines.values[i] = static_cast<float>((i * 7919) % 997) / 997;
    const scan_convert_settings settings{.size = {201, 173}, .background = 0.1F};
    const image reference = scan_convert(exec::seq, lines, probe, settings);
    const scan_map map = make_scan_map(exec::par.threads(3), probe, {.depth = 90_mm, .samples = 100}, settings);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U}) {
        CHECK(scan_convert(exec::par.threads(threads), lines, map) == reference);
        CHECK(scan_convert(exec::par_unseq.threads(threads), lines, probe, settings) == reference);
    }
}

TEST_CASE(
    "kept_scan_map: a map is made again where the probe, the lines or the settings have changed, and only there") {
    kept_scan_map<counted> kept;
    counted::checks = 0;
    int made = 0;
    const counted probe{{.lines = 20, .width = 40_mm}}, wider{{.lines = 20, .width = 50_mm}};
    const acquisition scan{.depth = 40_mm, .samples = 10}, deeper{.depth = 50_mm, .samples = 10},
        finer{.depth = 40_mm, .samples = 20};
    const scan_convert_settings settings{.size = {40, 40}}, smaller{.size = {30, 40}},
        brighter{.size = {40, 40}, .background = 1};
    const auto check_next = [&](const counted& with, const acquisition& lines, const scan_convert_settings& asked) {
        ++made;
        for (int again = 0; again < 2; ++again) {
            const scan_map& map = kept(exec::seq, with, lines, asked);
            CHECK(counted::checks == made);
            CHECK(map.depth == lines.depth);
            CHECK(map.samples == lines.samples);
            CHECK(map.size == asked.size);
            CHECK(map.background == asked.background);
        }
    };
    check_next(probe, scan, settings);
    check_next(wider, scan, settings);
    check_next(probe, scan, settings);
    check_next(probe, deeper, settings);
    check_next(probe, scan, settings);
    check_next(probe, finer, settings);
    check_next(probe, scan, settings);
    check_next(probe, scan, smaller);
    check_next(probe, scan, settings);
    check_next(probe, scan, brighter);
    check_next(probe, scan, settings);

    kept_scan_map<incomparable> never;
    counted::checks = 0;
    for (int i = 1; i < 4; ++i) {
        never(exec::seq, incomparable{probe}, scan, settings);
        CHECK(counted::checks == i);
    }
}

TEST_CASE("scan_convert: lines and settings out of range are refused") {
    const linear_array probe{.lines = 20};
    const auto refused = [&](const scan_lines& lines, const scan_convert_settings& settings) {
        CHECK_THROWS_AS(scan_convert(exec::seq, lines, probe, settings), usage_error);
    };
    const scan_lines good = filled(20, 10, 40_mm, 1);
    const float infinite = std::numeric_limits<float>::infinity();
    const float not_a_number = std::numeric_limits<float>::quiet_NaN();
    CHECK_NOTHROW(scan_convert(exec::seq, good, probe));

    refused(scan_lines{}, {});
    refused(filled(19, 10, 40_mm, 1), {}); // not the probe's lines
    refused(filled(20, 0, 40_mm, 1), {});
    for (const float depth : {0.0F, -40_mm, infinite, not_a_number}) refused(filled(20, 10, depth, 1), {});
    scan_lines torn = good;
    torn.values.pop_back();
    refused(torn, {});

    refused(good, {.size = {1000000, 1000000}});
    refused(good, {.size = {~0U, 0}});
    refused(good, {.size = {100000, 0}});
    refused(good, {.background = not_a_number});
    CHECK_THROWS_AS(scan_convert(exec::seq, good, linear_array{.lines = 20, .width = -1}), usage_error);
    CHECK_THROWS_AS(make_scan_map(exec::seq, linear_array{.lines = ~0U}, acquisition{.depth = 40_mm, .samples = 2}),
                    usage_error);

    const scan_map map = make_scan_map(exec::seq, probe, {.depth = 40_mm, .samples = 10});
    CHECK_NOTHROW(scan_convert(exec::seq, good, map));
    CHECK_THROWS_AS(scan_convert(exec::seq, filled(20, 11, 40_mm, 1), map), usage_error);
    CHECK_THROWS_AS(scan_convert(exec::seq, filled(20, 10, 41_mm, 1), map), usage_error);
    scan_lines fewer = good, shorter = good; // as many values, but they say that there are fewer
    fewer.count = 19;
    shorter.samples = 9;
    CHECK_THROWS_AS(scan_convert(exec::seq, fewer, map), usage_error);
    CHECK_THROWS_AS(scan_convert(exec::seq, shorter, map), usage_error);
}

TEST_CASE("make_scan_map: a number of samples of 0 is chosen for the pulse of the probe") {
    const auto samples = [](const auto& probe) { return make_scan_map(exec::seq, probe, {.depth = 40_mm}).samples; };
    CHECK(samples(linear_array{}) == 1344);                  // two for each 0.0597 mm, in blocks of 64
    CHECK(samples(linear_array{.frequency = 5_MHz}) == 896); // 0.0896 mm
    CHECK(samples(linear_array{.bandwidth = 0.322F}) == 704);
    CHECK(samples(steered_array{}) == 896); // no bandwidth stated: 2.5 cycles
}

TEST_CASE("scan_convert: an image with more than 16384 pixels a side is refused with its size and the likely cause") {
    const auto sentence = [](const linear_array& probe, float depth, uvec2 size) -> std::string {
        try {
            make_scan_map(exec::seq, probe, {.depth = depth, .samples = 64}, {.size = size});
        } catch (const usage_error& e) {
            return e.what();
        }
        return "none";
    };
    const linear_array probe{.lines = 4};
    CHECK(sentence(probe, 80, {0, 0}) == "scan_convert: depth is 80 m: did you mean 80_mm?");
    CHECK(sentence(probe, 8, {0, 0}) ==
          "scan_convert: size 512x107790 exceeds 16384 pixels a side; depth is 8 m: did you mean 8_mm?");
    CHECK(
        sentence({.lines = 4, .width = 1_mm}, 80_mm, {0, 0}) ==
        "scan_convert: size 512x40960 exceeds 16384 pixels a side; the field of view is 0.001 m wide and 0.08 m high; "
        "ask for fewer");
    CHECK(sentence(probe, 80_mm, {16384, 1}) == "none");
    CHECK(sentence(probe, 80_mm, {16385, 1}).find("size 16385x1 exceeds") != std::string::npos);
}

} // namespace scan_convert_test
