#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>
#include <string>

using namespace insonify;

namespace transducer_test {
namespace {

/// A minimal transducer: one line along z.
struct pencil {
    std::uint32_t lines = 1;
    float frequency = 1e6F;
    ray beam(float) const { return {}; }
    vec2 locate(vec2 point) const { return {0, point.y}; }
    void check() const {}
};
static_assert(transducer<pencil>);

struct without_lines {
    float frequency = 1e6F;
    ray beam(float) const { return {}; }
    vec2 locate(vec2 point) const { return point; }
    void check() const {}
};
struct without_locate {
    std::uint32_t lines = 1;
    float frequency = 1e6F;
    ray beam(float) const { return {}; }
    void check() const {}
};
struct with_signed_lines {
    int lines = 1;
    float frequency = 1e6F;
    ray beam(float) const { return {}; }
    vec2 locate(vec2 point) const { return point; }
    void check() const {}
};
static_assert(!transducer<without_lines> && !transducer<without_locate> && !transducer<with_signed_lines>);
static_assert(!transducer<int> && !transducer<ray>);

template <class Change>
std::string complaint(const Change& change) {
    linear_array array{};
    change(array);
    try {
        check_array(array);
    } catch (const usage_error& e) {
        return e.what();
    }
    return "";
}

} // namespace

TEST_CASE("transducer: lines are at the centres of equal parts of the aperture") {
    CHECK(aperture_fraction(0, 4) == -0.375F);
    CHECK(aperture_fraction(3, 4) == 0.375F);
    CHECK(aperture_fraction(0, 1) == 0);
    CHECK(aperture_fraction(1, 3) == 0);
    CHECK(aperture_fraction(-0.5F, 192) == -0.5F);
    CHECK(aperture_fraction(191.5F, 192) == 0.5F);
    for (const float line : {-0.5F, 0.0F, 17.25F, 191.0F})
        CHECK(line_at_fraction(aperture_fraction(line, 192), 192) == doctest::Approx(line).scale(1).epsilon(1e-5));
}

TEST_CASE("transducer: a setting out of range is named in the error") {
    CHECK(complaint([](linear_array&) {}).empty());
    CHECK(complaint([](linear_array& a) { a.lines = 0; }).find("lines is 0") != std::string::npos);
    const float infinite = std::numeric_limits<float>::infinity();
    for (const float bad : {-1.0F, infinite, std::numeric_limits<float>::quiet_NaN()}) {
        CHECK(complaint([=](linear_array& a) { a.frequency = bad; }).find("frequency is ") != std::string::npos);
        CHECK(complaint([=](linear_array& a) { a.fnumber = bad; }).find("fnumber is ") != std::string::npos);
        CHECK(complaint([=](linear_array& a) { a.focus = bad; }).find("focus is ") != std::string::npos);
        CHECK(complaint([=](linear_array& a) { a.elevation_height = bad; }).find("elevation_height is ") !=
              std::string::npos);
        CHECK(complaint([=](linear_array& a) { a.elevation_focus = bad; }).find("elevation_focus is ") !=
              std::string::npos);
    }
    CHECK(complaint([](linear_array& a) { a.focus = 0; }).empty());
    CHECK(complaint([](linear_array& a) { a.fnumber = 0; }).find("fnumber is ") != std::string::npos);
}

} // namespace transducer_test
