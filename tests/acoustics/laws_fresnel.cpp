#include <insonify/acoustics/laws.hpp>
#include <insonify/core/random.hpp>
#include <doctest/doctest.h>
#include <initializer_list>
#include <type_traits>

using namespace insonify;

namespace fresnel_test {
namespace {

static_assert(interface_law<fresnel> && std::is_empty_v<fresnel> && std::is_aggregate_v<fresnel>);

constexpr medium fat{.density = 930, .sound_speed = 1455};
constexpr medium muscle{.density = 1075, .sound_speed = 1580};
constexpr medium bone{.density = 1910, .sound_speed = 3500};

float cosine_of_degrees(float degrees) { return std::cos(degrees * pi / 180); }

medium of_impedance(float rayl, float speed = 1500) { return {.density = rayl / speed, .sound_speed = speed}; }

// Double precision reference for r, and the change of r for a rounding error of 1e-7 in x = cos^2 t, |dr/dx| 1e-7: the
// error that is unavoidable in float.
struct exact_reflection {
    double r = 1;
    double uncertainty = 0;
};
exact_reflection reflect_exactly(const medium& before, const medium& after, float cosine) {
    const double c1 = before.sound_speed, c2 = after.sound_speed, eta = c2 / c1, i = cosine;
    const double squared = (c1 - c2) * (c1 + c2) / (c1 * c1) + eta * eta * i * i;
    const double rounding = 2e-7 * (std::fabs(1 - eta * eta) + eta * eta * i * i);
    const double z1 = before.density * c1, z2 = after.density * c2;
    const auto r_of = [&](double cosine_squared) {
        if (cosine_squared <= 0) return 1.0;
        const double t = std::sqrt(cosine_squared);
        return (z2 * i - z1 * t) / (z2 * i + z1 * t);
    };
    return {r_of(squared), std::fabs(r_of(squared + rounding) - r_of(squared - rounding))};
}

// The angle between a refracted ray and the normal.
double refracted_degrees(const medium& before, const medium& after, double degrees) {
    const double angle = degrees * 3.14159265358979 / 180;
    const vec3 direction{static_cast<float>(std::sin(angle)), 0, static_cast<float>(std::cos(angle))};
    const vec3 onward = refracted(direction, {0, 0, -1}, before, after);
    return std::atan2(static_cast<double>(onward.x), static_cast<double>(onward.z)) * 180 / 3.14159265358979;
}

} // namespace

// V1
TEST_CASE("fresnel: energies at normal incidence agree with the literature to 1e-6") {
    struct {
        float z1, z2, reflected;
    } const rows[] = {{1.70_MRayl, 7.80_MRayl, 0.412299F},   {1.38_MRayl, 1.70_MRayl, 0.010794F},
                      {1.63_MRayl, 0.0004_MRayl, 0.999019F}, {1.63_MRayl, 1.48_MRayl, 0.002326F},
                      {1.70_MRayl, 1.61_MRayl, 0.000739F},   {1.38_MRayl, 1.62_MRayl, 0.006400F}};
    for (const auto& row : rows) {
        const medium a = of_impedance(row.z1), b = of_impedance(row.z2, 1600);
        const float measured = fresnel{}.energy_reflection(a, b, 1);
        MESSAGE("R of " << row.z1 << " to " << row.z2 << " rayl: measured " << measured << ", expected "
                        << row.reflected);
        CHECK(std::fabs(measured - row.reflected) < 1e-6F);
        CHECK(std::fabs(fresnel{}.energy_reflection(b, a, 1) - row.reflected) < 1e-6F);
        CHECK(std::fabs(fresnel{}.energy_transmission(a, b, 1) - (1 - row.reflected)) < 2e-6F);
    }
}

// V2; the table's 1e-12 is for double, 1e-5 for float.
TEST_CASE("fresnel: R + T = 1 and T12 = T21 for every impedance ratio and angle") {
    double worst_sum = 0, worst_pair = 0, worst_ratio = 0, worst_r = 0;
    for (float decades = -4; decades <= 4; decades += 0.25F)
        for (const float speed : {750.0F, 1400.0F, 1499.9F, 1500.0F, 1580.0F, 3500.0F, 6000.0F})
            for (int step = 0; step <= 900; ++step) {
                const medium a = of_impedance(1.5_MRayl), b = of_impedance(std::pow(10.0F, decades) * 1.5_MRayl, speed);
                const float cosine = cosine_of_degrees(step < 900 ? static_cast<float>(step) / 10 : 89.95F);
                const exact_reflection expected = reflect_exactly(a, b, cosine);
                const double r = fresnel{}.pressure_reflection(a, b, cosine);
                const double there = fresnel{}.energy_transmission(a, b, cosine);
                worst_sum = std::fmax(
                    worst_sum, std::fabs(static_cast<double>(fresnel{}.energy_reflection(a, b, cosine)) + there - 1));
                worst_r = std::fmax(worst_r, std::fabs(r - expected.r) - expected.uncertainty);
                const float onward = refracted_cosine(a, b, cosine);
                if (onward == 0) {
                    CHECK(there == 0);
                    continue;
                }
                const double back = fresnel{}.energy_transmission(b, a, onward);
                const double uncertainty = expected.uncertainty + reflect_exactly(b, a, onward).uncertainty;
                worst_pair = std::fmax(worst_pair, std::fabs(back - there) - 2 * uncertainty);
                if (cosine > 0.3F && onward > 0.3F)
                    worst_ratio = std::fmax(worst_ratio, std::fabs(back - there) / there);
            }
    MESSAGE("largest |R + T - 1| " << worst_sum << ", expected below 1e-6");
    MESSAGE("largest |T12 - T21| / T12 " << worst_ratio << " up to 72 degrees, expected below 1e-5");
    MESSAGE("beyond the rounding error of the cosine: |T12 - T21| " << worst_pair << ", |r - exact| " << worst_r
                                                                    << ", expected below 1e-6");
    CHECK(worst_ratio < 1e-5);
    CHECK(worst_sum < 1e-6);
    CHECK(worst_pair < 1e-6);
    CHECK(worst_r < 1e-6);
}

// V3: its bone row, whose muscle has 1065 kg/m^3
TEST_CASE("fresnel: oblique reflection from muscle to bone agrees with the table to 1e-4, up to total reflection") {
    const medium before{.density = 1065, .sound_speed = 1580};
    struct {
        float degrees, reflected;
    } const rows[] = {{0, 0.3574F}, {10, 0.3822F}, {20, 0.4933F}, {25, 0.6759F}, {30, 1.0000F}};
    for (const auto& row : rows) {
        const float measured = fresnel{}.energy_reflection(before, bone, cosine_of_degrees(row.degrees));
        MESSAGE("R at " << row.degrees << " degrees: measured " << measured << ", expected " << row.reflected);
        CHECK(std::fabs(measured - row.reflected) < 1e-4F);
    }
}

// V4
TEST_CASE("fresnel: refraction follows Snell's law with the sound speeds, to 1e-3 degrees") {
    struct {
        float c1, c2;
        double degrees, expected;
    } const rows[] = {
        {1455, 1580, 20, 21.8022}, {1455, 1580, 40, 44.2676}, {1580, 1455, 30, 27.4157},
        {1482, 1570, 30, 31.9845}, {1580, 3500, 20, 49.2565},
    };
    for (const auto& row : rows) {
        // The impedances change the other way, so a law that used them would fail.
        const medium a{.density = 5000, .sound_speed = row.c1}, b{.density = 500, .sound_speed = row.c2};
        const double measured = refracted_degrees(a, b, row.degrees);
        MESSAGE("from " << row.c1 << " to " << row.c2 << " m/s at " << row.degrees << ": measured " << measured
                        << ", expected " << row.expected);
        CHECK(std::fabs(measured - row.expected) < 1e-3);
    }
}

TEST_CASE("fresnel: critical angles follow from the sound speeds; there is none into a slower medium") {
    struct {
        float c1, c2, degrees;
    } const rows[] = {{1580, 3500, 26.8354F}, {1540, 4080, 22.1759F}, {1455, 1580, 67.056F}, {1580, 5740, 15.9776F}};
    for (const auto& row : rows) {
        const medium a{.density = 1000, .sound_speed = row.c1}, b{.density = 2000, .sound_speed = row.c2};
        const float critical = fresnel{}.critical_angle(a, b);
        CHECK(std::fabs(critical * 180 / pi - row.degrees) < 1e-3F);
        CHECK(fresnel{}.critical_angle(b, a) == doctest::Approx(pi / 2).scale(1e-30));
        CHECK(fresnel{}.critical_angle(a, a) == doctest::Approx(pi / 2).scale(1e-30));

        const float below = std::cos(critical - 0.01_deg), above = std::cos(critical + 0.01_deg);
        CHECK(fresnel{}.pressure_reflection(a, b, below) < 1);
        CHECK(fresnel{}.energy_transmission(a, b, below) > 0);
        for (const float cosine : {above, 0.1F, 0.0F}) {
            CHECK(fresnel{}.pressure_reflection(a, b, cosine) == 1);
            CHECK(fresnel{}.energy_reflection(a, b, cosine) == 1);
            CHECK(fresnel{}.energy_transmission(a, b, cosine) == 0);
            CHECK(fresnel{}({.before = a, .after = b, .cosine = cosine}).transmitted == 0);
            const vec3 direction{std::sqrt(1 - cosine * cosine), 0, cosine};
            CHECK(refracted(direction, {0, 0, -1}, a, b) == vec3{0, 0, 0});
        }
    }
}

// Snell's law with impedances and the optical form of r; inverted Snell's law without cos t.
TEST_CASE("fresnel: results differ from two incorrect forms found in other simulators") {
    struct {
        medium before, after;
        float degrees, right, optical, inverted;
    } const rows[] = {{muscle, bone, 20, 0.489999F, 0.21561F, 0.32985F},
                      {fat, muscle, 40, 0.0214083F, 0.00636F, 0.00038F},
                      {fat, muscle, 60, 0.0883517F, 0.00624F, 0.05235F}};
    for (const auto& row : rows) {
        const float measured = fresnel{}.energy_reflection(row.before, row.after, cosine_of_degrees(row.degrees));
        MESSAGE("R at " << row.degrees << " degrees: measured " << measured << ", expected " << row.right << ", not "
                        << row.optical << " nor " << row.inverted);
        CHECK(measured == doctest::Approx(row.right).scale(1e-30).epsilon(2e-5));
        CHECK(std::fabs(measured - row.optical) > 0.01F);
        CHECK(std::fabs(measured - row.inverted) > 0.01F);
    }
    const medium dense{.density = 4000, .sound_speed = 1500}, light{.density = 500, .sound_speed = 1500};
    const medium slow{.density = 3000, .sound_speed = 1000}, fast{.density = 1000, .sound_speed = 3000};
    CHECK(refracted_degrees(dense, light, 40) == doctest::Approx(40).scale(1e-30));    // equal speeds: no refraction
    CHECK(refracted_degrees(fast, slow, 40) == doctest::Approx(12.3723).scale(1e-30)); // equal impedances: refraction
}

TEST_CASE("fresnel: equal media reflect exactly 0 at any angle; for equal speeds r does not depend on the angle") {
    for (const float density : {1.2F, 998.0F, 1071.3F, 7900.0F})
        for (const float speed : {343.0F, 1482.1F, 1540.0F, 5740.7F}) {
            const medium a{.density = density, .sound_speed = speed};
            const medium same_impedance{density, speed, 100, 1.1F, 0.5F, 20_um};
            const medium denser{.density = 3 * density, .sound_speed = speed};
            for (int step = 0; step <= 1000; ++step) {
                const float cosine = static_cast<float>(step) / 1000;
                const response same =
                    fresnel{}({.before = a, .after = same_impedance, .cosine = cosine, .frequency = 5_MHz});
                REQUIRE(same.reflected == 0);
                REQUIRE(same.transmitted == 1);
                REQUIRE(fresnel{}.pressure_reflection(a, denser, cosine) == doctest::Approx(0.5).scale(1e-30));
            }
            const vec3 direction = normalize(vec3{0.3F, -0.5F, 0.2F});
            CHECK(refracted(direction, {0, 0, -1}, a, same_impedance) == direction);
        }
}

TEST_CASE("fresnel: the sign of r is that of the impedance change, and the response is r and 1 - r^2") {
    const medium air{.density = 1.2F, .sound_speed = 343};
    CHECK(fresnel{}.pressure_reflection(muscle, bone, 1) > 0);
    CHECK(fresnel{}.pressure_reflection(bone, muscle, 1) < 0);
    CHECK(fresnel{}.pressure_reflection(muscle, air, 1) == doctest::Approx(-0.99952).scale(1e-30));
    CHECK(fresnel{}.pressure_reflection(bone, muscle, 0) == -1); // grazing
    const auto both = {muscle, fat};
    for (const medium& before : both)
        for (const medium& after : {muscle, fat, bone, air})
            for (const float degrees : {0.0F, 10.0F, 25.0F, 60.0F, 85.0F}) {
                const float cosine = cosine_of_degrees(degrees);
                const float r = fresnel{}.pressure_reflection(before, after, cosine);
                const response answer = fresnel{}({.before = before, .after = after, .cosine = cosine});
                CHECK(answer.reflected == r);
                CHECK(std::fabs(answer.transmitted - (1 - r * r)) < 2e-7F);
                const float onward = refracted_cosine(before, after, cosine);
                if (onward == 0) continue;
                const float back = fresnel{}.pressure_reflection(after, before, onward);
                CHECK((1 + r) * (1 + back) ==
                      doctest::Approx(answer.transmitted).scale(0.1).epsilon(1e-5)); // pressure, both ways
            }
}

TEST_CASE("fresnel: a refracted direction has length 1, stays in the plane of incidence, and is reversible") {
    constexpr std::uint64_t seed = 11;
    CAPTURE(seed);
    for (std::uint64_t i = 0; i < 10'000; ++i) {
        const auto direction_of = [&](std::uint64_t at) {
            const vec2 xy = hash_normal(seed, 4 * i + at);
            return normalize(vec3{xy.x, xy.y, hash_normal(seed, 4 * i + at + 1).x});
        };
        const vec3 direction = direction_of(0), normal = direction_of(2);
        const vec3 onward = refracted(direction, normal, muscle, fat);
        REQUIRE(std::fabs(length(onward) - 1) < 1e-6F);
        REQUIRE(std::fabs(dot(cross(direction, normal), onward)) < 1e-6F);
        REQUIRE(dot(direction, normal) * dot(onward, normal) >= 0);
        REQUIRE(onward == refracted(direction, -normal, muscle, fat));
        // sin t / sin i, against the speeds
        REQUIRE(length(cross(onward, normal)) * 1580 ==
                doctest::Approx(length(cross(direction, normal)) * 1455).scale(1e-30).epsilon(1e-4));
        if (std::fabs(dot(direction, normal)) < 0.1F) continue; // grazing after refraction
        REQUIRE(length(refracted(onward, normal, fat, muscle) - direction) < 1e-5F);
    }
}

TEST_CASE("fresnel: R + T = 1 within 1e-6 for a million random interfaces") {
    constexpr std::uint64_t seed = 2026;
    double worst = 0;
    bool amplitudes_hold = true;
    for (std::uint64_t i = 0; i < 1'000'000; ++i) {
        const auto uniform = [&](std::uint64_t at) { return hash_uniform(seed, 5 * i + at); };
        const medium before{.density = std::pow(10.0F, 4 * uniform(0)), .sound_speed = 300 + 6000 * uniform(1)};
        const medium after{.density = std::pow(10.0F, 4 * uniform(2)), .sound_speed = 300 + 6000 * uniform(3)};
        const float cosine = uniform(4);
        const double reflected = fresnel{}.energy_reflection(before, after, cosine);
        const double transmitted = fresnel{}.energy_transmission(before, after, cosine);
        worst = std::fmax(worst, std::fabs(reflected + transmitted - 1));
        const response answer = fresnel{}({.before = before, .after = after, .cosine = cosine});
        amplitudes_hold = amplitudes_hold && std::fabs(answer.reflected) <= 1 && answer.transmitted >= 0 &&
                          answer.transmitted <= 1.000001F;
    }
    MESSAGE("seed " << seed << ": largest |R + T - 1| " << worst << ", expected below 1e-6");
    CHECK(worst < 1e-6);
    CHECK(amplitudes_hold);
}

} // namespace fresnel_test
