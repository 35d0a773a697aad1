#include <insonify/signal/gain.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>
#include <utility>

using namespace insonify;

namespace gain_test {
namespace {

scan_lines ramp_of_decibels() {
    scan_lines lines{3, 5000, 0.05F};
    for (std::size_t i = 0; i < lines.values.size(); ++i)
        lines.values[i] =
            static_cast<float>(std::pow(10.0, (static_cast<double>(i) / 100 - 120) / 20)); // -120 to 30 dB
    return lines;
}

} // namespace

TEST_CASE("log_compress: 30 dB below the reference with a range of 60 dB is the middle grey of 8 bits") {
    for (const float reference : {-25.0F, 0.0F, 12.5F}) {
        const log_compress_settings settings{.dynamic_range_db = 60, .reference_db = reference};
        const auto amplitude = static_cast<float>(std::pow(10.0, (static_cast<double>(reference) - 30) / 20));
        const long grey = std::lround(255 * settings.grey(amplitude));
        CHECK((grey == 127 || grey == 128));
    }
}

TEST_CASE("log_compress: brightness is linear in decibels and clamped to black and white") {
    const scan_lines lines = ramp_of_decibels();
    const scan_lines grey = log_compress(exec::seq, lines, {.dynamic_range_db = 50, .reference_db = -10, .gain_db = 4});
    CHECK(grey.count == 3);
    CHECK(grey.samples == 5000);
    CHECK(grey.depth == 0.05F);
    for (std::size_t i = 0; i < lines.values.size(); ++i) {
        const double level = static_cast<double>(i) / 100 - 120 + 4;
        const double expected = level <= -60 ? 0 : level >= -10 ? 1 : (level + 60) / 50;
        REQUIRE(std::fabs(static_cast<double>(grey.values[i]) - expected) < 1e-5);
    }
}

TEST_CASE("log_compress: zero is black, infinity white, and nothing is NaN") {
    const log_compress_settings settings{};
    const float infinite = std::numeric_limits<float>::infinity();
    for (const float none : {0.0F, -0.0F, -1.0F, -infinite, std::numeric_limits<float>::quiet_NaN()})
        CHECK(settings.grey(none) == 0);
    CHECK(settings.grey(infinite) == 1);
    CHECK(settings.grey(std::numeric_limits<float>::denorm_min()) == 0);
    CHECK(settings.grey(std::numeric_limits<float>::max()) == 1);
}

TEST_CASE("log_compress: levels below the rejection are black, those above are unchanged") {
    const log_compress_settings all{.dynamic_range_db = 60, .reference_db = 0, .gain_db = 10};
    log_compress_settings some = all;
    some.reject_db = -20;
    CHECK(some.grey(0.1F) == all.grey(0.1F));   // -20 + 10 dB
    CHECK(some.grey(0.04F) == all.grey(0.04F)); // -28 + 10 dB
    CHECK(all.grey(0.02F) > 0.6F);              // -34 + 10 dB
    CHECK(some.grey(0.02F) == 0);
}

TEST_CASE("log_compress: bit-equal for any number of threads, and a moved buffer is reused") {
    const scan_lines lines = ramp_of_decibels();
    const scan_lines reference = log_compress(exec::seq, lines);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
        CHECK(log_compress(exec::par.threads(threads), lines) == reference);
    scan_lines own = lines;
    const float* buffer = own.values.data();
    own = log_compress(exec::par, std::move(own));
    CHECK(own.values.data() == buffer);
    CHECK(log_compress(exec::seq, scan_lines{}).values.empty());
}

TEST_CASE("log_compress: settings out of range are refused") {
    const float infinite = std::numeric_limits<float>::infinity();
    const float not_a_number = std::numeric_limits<float>::quiet_NaN();
    for (const float bad : {0.0F, -60.0F, infinite, not_a_number})
        CHECK_THROWS_AS(log_compress(exec::seq, scan_lines{}, {.dynamic_range_db = bad}), usage_error);
    for (const float bad : {infinite, not_a_number}) {
        CHECK_THROWS_AS(log_compress(exec::seq, scan_lines{}, {.reference_db = bad}), usage_error);
        CHECK_THROWS_AS(log_compress(exec::seq, scan_lines{}, {.gain_db = bad}), usage_error);
        CHECK_THROWS_AS(log_compress(exec::seq, scan_lines{}, {.reject_db = bad}), usage_error);
    }
}

TEST_CASE("tgc: the automatic gain is 2 a f z, up to its limit") {
    const scan_lines ones = [] {
        scan_lines lines{2, 1000, 0.1F};
        for (float& value : lines.values) value = 0.5F;
        return lines;
    }();
    const scan_lines lines = tgc(exec::par, ones, 5e6F, {.attenuation = 70, .max_db = 40});
    CHECK(lines.count == 2);
    CHECK(lines.depth == 0.1F);
    for (std::uint32_t k = 0; k < 1000; ++k) {
        const double db = std::min(2 * 0.7 * 5 * (k + 0.5) * 0.1 / 1000 * 100, 40.0); // 0.7 dB/(cm MHz), 5 MHz
        REQUIRE(lines(1, k) == doctest::Approx(0.5 * std::pow(10, db / 20)).epsilon(1e-4).scale(1e-30));
    }
    CHECK(tgc(exec::seq, ones, 5e6F)(0, 499) ==
          doctest::Approx(0.5 * std::pow(10, 24.975 / 20)).epsilon(1e-4).scale(1e-30));
    CHECK(tgc(exec::seq, ones, 0) == ones);
}

TEST_CASE("tgc: eight sliders from the face to the end add their gain, interpolated linearly") {
    const tgc_settings settings{.attenuation = 0, .sliders = {0, 6, -3, 0, 0, 0, 0, 7}};
    CHECK(settings.gain_db(0, 0.07F, 5e6F) == 0);
    CHECK(settings.gain_db(0.01F, 0.07F, 5e6F) == doctest::Approx(6).scale(1e-30));
    CHECK(settings.gain_db(0.015F, 0.07F, 5e6F) == doctest::Approx(1.5).scale(1e-30));
    CHECK(settings.gain_db(0.02F, 0.07F, 5e6F) == doctest::Approx(-3).scale(1e-30));
    CHECK(settings.gain_db(0.065F, 0.07F, 5e6F) == doctest::Approx(3.5).scale(1e-30));
    CHECK(settings.gain_db(0.07F, 0.07F, 5e6F) == doctest::Approx(7).scale(1e-30));
    tgc_settings with_automatic = settings;
    with_automatic.attenuation = 50;
    CHECK(with_automatic.gain_db(0.01F, 0.07F, 5e6F) == doctest::Approx(6 + 5).scale(1e-30));
}

TEST_CASE("tgc: a curve replaces the automatic gain") {
    const tgc_settings settings{.sliders = {1, 1, 1, 1, 1, 1, 1, 1}, .curve = {{0.01F, 3}, {0.03F, 13}, {0.04F, 8}}};
    CHECK(settings.gain_db(0, 0.05F, 5e6F) == doctest::Approx(4).scale(1e-30));
    CHECK(settings.gain_db(0.02F, 0.05F, 5e6F) == doctest::Approx(9).scale(1e-30));
    CHECK(settings.gain_db(0.035F, 0.05F, 5e6F) == doctest::Approx(11.5).scale(1e-30));
    CHECK(settings.gain_db(0.05F, 0.05F, 5e6F) == doctest::Approx(9).scale(1e-30));
    iq_lines iq{1, 50, 0.05F};
    iq(0, 49) = {3, -4};
    iq = tgc(exec::par, std::move(iq), 5e6F, {.curve = {{0, 20}}});
    CHECK(iq(0, 49).x == doctest::Approx(30).scale(1e-30));
    CHECK(iq(0, 49).y == doctest::Approx(-40).scale(1e-30));
}

TEST_CASE("tgc: settings out of range are refused") {
    const float infinite = std::numeric_limits<float>::infinity();
    const float not_a_number = std::numeric_limits<float>::quiet_NaN();
    for (const float bad : {-1.0F, infinite, not_a_number}) {
        CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, bad), usage_error);
        CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, 5e6F, {.attenuation = bad}), usage_error);
        CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, 5e6F, {.max_db = bad}), usage_error);
    }
    for (const float bad : {infinite, not_a_number}) {
        CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, 5e6F, {.sliders = {0, 0, bad}}), usage_error);
        CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, 5e6F, {.curve = {{0, bad}}}), usage_error);
        CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, 5e6F, {.curve = {{bad, 0}}}), usage_error);
    }
    CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, 5e6F, {.curve = {{0.02F, 1}, {0.01F, 2}}}), usage_error);
    CHECK_THROWS_AS(tgc(exec::seq, scan_lines{}, 5e6F, {.curve = {{0.02F, 1}, {0.02F, 2}}}), usage_error);
}

} // namespace gain_test
