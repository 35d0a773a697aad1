#include <insonify/probe/presets.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("presets: the four real probes have the published values") {
    struct {
        float frequency, bandwidth, height, focus;
        double megahertz, percent, height_mm, focus_mm;
    } const rows[] = {{presets::l11_5v.frequency, presets::l11_5v.bandwidth, presets::l11_5v.elevation_height,
                       presets::l11_5v.elevation_focus, 7.6, 77, 5, 18},
                      {presets::l12_3v.frequency, presets::l12_3v.bandwidth, presets::l12_3v.elevation_height,
                       presets::l12_3v.elevation_focus, 7.54, 93, 5, 20},
                      {presets::c5_2v.frequency, presets::c5_2v.bandwidth, presets::c5_2v.elevation_height,
                       presets::c5_2v.elevation_focus, 3.57, 79, 13.5, 60},
                      {presets::p4_2v.frequency, presets::p4_2v.bandwidth, presets::p4_2v.elevation_height,
                       presets::p4_2v.elevation_focus, 2.72, 74, 14, 60}};
    for (const auto& row : rows) {
        CHECK(row.frequency == doctest::Approx(row.megahertz * 1e6).scale(1e-30));
        CHECK(row.bandwidth == doctest::Approx(row.percent / 100).scale(1e-30));
        CHECK(row.height == doctest::Approx(row.height_mm * 1e-3).scale(1e-30));
        CHECK(row.focus == doctest::Approx(row.focus_mm * 1e-3).scale(1e-30));
    }
    CHECK(presets::l11_5v.width == doctest::Approx(38.4e-3).scale(1e-30)); // 128 x 0.30 mm
    CHECK(presets::l12_3v.width == doctest::Approx(38.4e-3).scale(1e-30)); // 192 x 0.20 mm
    CHECK(presets::c5_2v.radius * presets::c5_2v.field_of_view ==
          doctest::Approx(65.024e-3).scale(1e-30)); // 128 x 0.508 mm
    CHECK(presets::c5_2v.field_of_view * 180 / std::acos(-1.0F) == doctest::Approx(75.16).epsilon(1e-3).scale(1e-30));
    CHECK(presets::p4_2v.width == doctest::Approx(19.2e-3).scale(1e-30)); // 64 x 0.30 mm
}

TEST_CASE("presets: the real probes pass their own checks") {
    presets::l11_5v.check();
    presets::l12_3v.check();
    presets::c5_2v.check();
    presets::p4_2v.check();
}
