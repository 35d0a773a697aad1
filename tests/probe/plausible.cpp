#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <doctest/doctest.h>
#include <limits>
#include <string>

using namespace insonify;

namespace plausible_test {
namespace {

template <class Check>
std::string sentence(const Check& check) {
    try {
        check();
    } catch (const usage_error& e) {
        return e.what();
    }
    return "none";
}

const float nan = std::numeric_limits<float>::quiet_NaN();

} // namespace

TEST_CASE("plausible: a number in the wrong unit is refused with the likely one") {
    CHECK(sentence([] { check_depth(80, "trace"); }) == "trace: depth is 80 m: did you mean 80_mm?");
    CHECK(sentence([] { linear_array{.width = 38}.check(); }) == "probe: width is 38 m: did you mean 38_mm?");
    CHECK(sentence([] { convex_array{.radius = 49.57F}.check(); }) ==
          "probe: radius is 49.57 m: did you mean 49.57_mm?");
    CHECK(sentence([] { linear_array{.focus = 18}.check(); }) == "probe: focus is 18 m: did you mean 18_mm?");
    CHECK(sentence([] { linear_array{.elevation_height = 5}.check(); }) ==
          "probe: elevation_height is 5 m: did you mean 5_mm?");
    CHECK(sentence([] { linear_array{.frequency = 7.5F}.check(); }) ==
          "probe: frequency is 7.5 Hz: did you mean 7.5_MHz?");
    CHECK(sentence([] { radial_array{.frequency = 5}.check(); }) == "probe: frequency is 5 Hz: did you mean 5_MHz?");
    CHECK(sentence([] { convex_array{.field_of_view = 60}.check(); }) ==
          "convex_array: field_of_view is 60 rad: did you mean 60_deg?");
    CHECK(sentence([] { phased_array{.field_of_view = 90}.check(); }) ==
          "phased_array: field_of_view is 90 rad: did you mean 90_deg?");
}

TEST_CASE("plausible: a number that fits no unit is refused with the range") {
    CHECK(sentence([] { check_depth(0, "trace"); }) == "trace: depth is 0 m; it must be from 1 nm to 10 m");
    CHECK(sentence([] { check_depth(1e6F, "trace"); }) == "trace: depth is 1e+06 m; it must be from 1 nm to 10 m");
    CHECK(sentence([] { linear_array{.width = -38}.check(); }) == "probe: width is -38 m; it must be from 1 nm to 1 m");
    CHECK(sentence([] { linear_array{.width = nan}.check(); }) == "probe: width is nan m; it must be from 1 nm to 1 m");
    CHECK(sentence([] { linear_array{.frequency = 0}.check(); }) ==
          "probe: frequency is 0 Hz; it must be from 1 kHz to 10 GHz");
    CHECK(sentence([] { linear_array{.frequency = 7.5e12F}.check(); }) ==
          "probe: frequency is 7.5e+12 Hz; it must be from 1 kHz to 10 GHz");
    CHECK(sentence([] { phased_array{.field_of_view = 1000}.check(); }) ==
          "phased_array: field_of_view is 1000 rad; it must be from 1e-9 rad to 180_deg");
    CHECK(sentence([] { linear_array{.fnumber = 0}.check(); }) ==
          "probe: fnumber is 0; it must be a number from 1e-9 to 1e12");
}

TEST_CASE("plausible: ranges include their ends") {
    CHECK(sentence([] { check_depth(max_scan_depth, "trace"); }) == "none");
    CHECK(sentence([] { check_depth(1e-9F, "trace"); }) == "none");
    CHECK(sentence([] { linear_array{.width = max_aperture, .frequency = min_frequency}.check(); }) == "none");
    CHECK(sentence([] { linear_array{.frequency = max_frequency}.check(); }) == "none");
    CHECK(sentence([] { convex_array{.field_of_view = 2 * pi}.check(); }) == "none");
    CHECK(sentence([] { phased_array{.field_of_view = pi}.check(); }) == "none");
}

} // namespace plausible_test
