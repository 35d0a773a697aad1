#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace steered_trace_test {
namespace {

constexpr medium silent{.density = 1000, .sound_speed = 1540};
constexpr medium echoing{.density = 1000, .sound_speed = 1540, .backscatter = 1};
constexpr medium hard{.density = 2000, .sound_speed = 1540}; // reflects a third

template <class Probe>
scan_lines received(const scene& body, const Probe& probe, const acquisition& scan, const physical<>& model = {},
                    straight_lines how = {}) {
    return envelope(exec::par_unseq,
                    convolve(exec::par_unseq, trace(exec::par_unseq, body, probe, pose{}, model, scan, how),
                             nominal_pulse(probe), probe));
}

double decibels(double amplitude) { return 20 * std::log10(amplitude); }

// A plate whose near face is normal to lines at this angle, through a point of the slice plane.
mesh plate(float angle, vec2 through) {
    const vec3 along{std::sin(angle), 0, std::cos(angle)}, across{std::cos(angle), 0, -std::sin(angle)};
    mesh box = make_box({-60_mm, -30_mm, 0}, {60_mm, 30_mm, 5_mm});
    for (vec3& p : box.positions) p = vec3{through.x, p.y, through.y} + p.x * across + p.z * along;
    return box;
}

// Centre of the echo power of a frame in the slice plane, metres.
template <class Probe>
glm::dvec2 centre(const scan_lines& lines, const Probe& probe) {
    glm::dvec2 sum{0, 0};
    double all = 0;
    for (std::uint32_t i = 0; i < lines.count; ++i)
        for (std::uint32_t k = 0; k < lines.samples; ++k) {
            const double power = static_cast<double>(lines(i, k)) * static_cast<double>(lines(i, k));
            const vec3 p = probe.beam(static_cast<float>(i))
                               .at((static_cast<float>(k) + 0.5F) * lines.depth / static_cast<float>(lines.samples));
            sum += power * glm::dvec2{p.x, p.z};
            all += power;
        }
    return sum / all;
}

template <class Probe>
void check_target(const Probe& probe, vec2 at, float depth, std::uint32_t samples) {
    const float radius = 1_mm;
    medium opaque = hard;
    opaque.attenuation = 1e6F;
    scene body{silent};
    body.add(make_cylinder({at.x, -20_mm, at.y}, {at.x, 20_mm, at.y}, radius, 512), opaque);
    body.build(exec::seq);
    for (const float angle : {-15_deg, -10_deg, 0.0F, 10_deg, 15_deg}) {
        const steered<Probe> look{probe, angle};
        const glm::dvec2 found = centre(received(body, look, {.depth = depth, .samples = samples}), look);
        const vec3 along = look.beam(look.locate(at).x).direction;
        const glm::dvec2 error = found - glm::dvec2{at - radius * vec2{along.x, along.z}};
        MESSAGE((angle / 1_deg), " degrees: ", error.x * 1e6, ", ", error.y * 1e6, " um off");
        CHECK(glm::length(error) < 50e-6);
    }
}

// Level of a plate normal to the lines in the middle of the frame, dB.
template <class Probe>
double plate_level(const Probe& look, std::uint32_t planes) {
    const float middle = 0.5F * static_cast<float>(look.lines) - 0.5F;
    const ray line = look.beam(middle);
    const vec3 foot = line.at(24_mm);
    const float angle = std::atan2(line.direction.x, line.direction.z);
    const scene body = [&] {
        scene made{silent};
        made.add(plate(angle, {foot.x, foot.z}), hard);
        return std::move(made).build(exec::seq);
    }();
    const scan_lines lines = received(body, look, {.depth = 40_mm, .samples = 8192, .planes = planes});
    float peak = 0;
    for (std::uint32_t k = 0; k < lines.samples; ++k) peak = max(peak, lines(look.lines / 2, k));
    return decibels(static_cast<double>(peak));
}

// Level of speckle over the lines in the middle half, dB, and the same of the outermost two lines.
struct levels {
    double middle, border;
};
template <class Probe>
levels speckle_level(const Probe& look, float depth, std::uint32_t samples, std::uint32_t planes) {
    double middle = 0, border = 0;
    std::size_t in_middle = 0, at_border = 0;
    for (std::uint32_t seed = 1; seed <= 16; ++seed) {
        const scene body = scene{echoing}.build(exec::seq);
        const scan_lines lines = received(body, look, {.depth = depth, .samples = samples, .planes = planes},
                                          physical<>{.scattering = {.seed = seed}});
        for (std::uint32_t i = 0; i < lines.count; ++i)
            for (std::uint32_t k = samples / 10; k < samples * 9 / 10; ++k) {
                const double power = static_cast<double>(lines(i, k)) * static_cast<double>(lines(i, k));
                if (i >= lines.count / 4 && i < lines.count * 3 / 4) middle += power, ++in_middle;
                if (i < 2 || i + 2 >= lines.count) border += power, ++at_border;
            }
    }
    return {10 * std::log10(middle / static_cast<double>(in_middle)),
            10 * std::log10(border / static_cast<double>(at_border))};
}

} // namespace

TEST_CASE("steered lines: a wire is drawn in the same place at any angle, within 0.05 mm") {
    check_target(linear_array{.lines = 1024, .width = 38_mm, .frequency = 9_MHz}, {3_mm, 22_mm}, 40_mm, 1800);
    check_target(convex_array{.lines = 1024, .frequency = 3.5_MHz}, {-8_mm, 40_mm}, 70_mm, 1600);
}

TEST_CASE("steered lines: a plate normal to them returns its reflection, at any angle") {
    const double expected = decibels(1.0 / 3);
    const auto check = [&](const char* name, const auto& probe, float angle, std::uint32_t planes) {
        const double found = plate_level(steered{probe, angle}, planes);
        MESSAGE(std::string{name}, ", ", (angle / 1_deg), " degrees, ", planes, " planes: ", found, " dB; expected ",
                expected);
        CHECK(std::fabs(found - expected) < 0.1);
    };
    for (const float angle : {-20_deg, -10_deg, 0.0F, 5_deg, 20_deg}) {
        check("linear", linear_array{.lines = 256, .frequency = 9_MHz}, angle, 1);
        check("linear", linear_array{.lines = 256, .frequency = 9_MHz}, angle, 5);
    }
}

TEST_CASE("steered lines: speckle keeps its level at any angle") {
    const auto check = [](const char* name, const auto& look, float depth, std::uint32_t samples,
                          std::uint32_t planes) {
        const levels found = speckle_level(look, depth, samples, planes);
        MESSAGE(std::string{name}, ", ", (look.steering / 1_deg), " degrees, ", planes, " planes: ", found.middle,
                " dB, border ", found.border, "; expected -55");
        CHECK(std::fabs(found.middle + 55) < 0.3);
        CHECK(std::fabs(found.border + 55) < 0.5);
    };
    for (const float angle : {-20_deg, -10_deg, 0.0F, 5_deg, 15_deg}) {
        check("linear", steered{linear_array{.lines = 192, .width = 38_mm, .frequency = 7.5_MHz}, angle}, 40_mm, 1344,
              1);
        check("convex", steered{convex_array{.lines = 192, .frequency = 3.5_MHz}, angle}, 80_mm, 1344, 1);
    }
    check("linear", steered{linear_array{.lines = 192, .width = 38_mm, .frequency = 7.5_MHz}, 10_deg}, 40_mm, 1344, 5);
}

TEST_CASE("steered lines: the shadow of a strip fills as it does behind a straight line") {
    // An absorbing strip, 0.72 mm wide, 10 mm deep and normal to the line in the middle; a sum of waves has -3.0 dB 10 mm behind.
    const linear_array probe{.lines = 193, .width = 38_mm, .frequency = 7.5_MHz};
    medium absorbing = silent;
    absorbing.attenuation = 1e6F;
    const auto shadow = [&](float angle, float behind) {
        const vec3 along{std::sin(angle), 0, std::cos(angle)}, across{std::cos(angle), 0, -std::sin(angle)};
        mesh strip = make_box({-0.36_mm, -20_mm, 0}, {0.36_mm, 20_mm, 0.1_mm});
        for (vec3& p : strip.positions) p = p.y * vec3{0, 1, 0} + p.x * across + (10_mm + p.z) * along;
        const vec3 foot = (10_mm + behind) * along;
        const auto level = [&](bool shaded) {
            scene body{silent};
            if (shaded) body.add(strip, absorbing);
            body.add(plate(angle, {foot.x, foot.z}), hard);
            body.build(exec::seq);
            const steered look{probe, angle};
            const iq_lines echoes = trace(exec::par_unseq, body, look, pose{}, physical{},
                                          {.depth = 45_mm, .samples = 4096}, straight_lines{.directions = 64});
            double sum = 0; // an echo is divided between two samples
            for (std::uint32_t k = 0; k < echoes.samples; ++k) sum += static_cast<double>(length(echoes(96, k)));
            return sum;
        };
        return decibels(level(true) / level(false));
    };
    for (const float behind : {5_mm, 10_mm, 20_mm}) {
        const double straight = shadow(0, behind);
        for (const float angle : {-15_deg, 10_deg}) {
            const double found = shadow(angle, behind);
            MESSAGE((behind / 1_mm), " mm behind, at ", (angle / 1_deg), " degrees: ", found, " dB; straight ",
                    straight);
            CHECK(std::fabs(found - straight) < 0.5);
        }
    }
}

TEST_CASE("steered lines: slices and rays find the same echoes") {
    scene body{tissue::muscle};
    body.add(make_sphere({4_mm, 0, 18_mm}, 6_mm, 4), tissue::blood);
    body.add(make_sphere({-9_mm, 1_mm, 22_mm}, 7_mm, 4), tissue::bone);
    body.build(exec::seq);
    const auto differing = [&](const auto& look) {
        const acquisition scan{.depth = 40_mm, .samples = 800};
        const iq_lines rays = trace(exec::seq, body, look, pose{}, physical{}, scan, straight_lines{line_search::rays}),
                       slices =
                           trace(exec::seq, body, look, pose{}, physical{}, scan, straight_lines{line_search::slices});
        std::size_t apart = 0;
        for (std::size_t i = 0; i < rays.values.size(); ++i)
            apart += length(rays.values[i] - slices.values[i]) > 1e-4F ? 1U : 0U;
        return apart;
    };
    CHECK(differing(steered{linear_array{.lines = 128}, 10_deg}) < 30);
    CHECK(differing(steered{convex_array{.lines = 128, .frequency = 5_MHz}, 10_deg}) == 0); // traced by rays
}

} // namespace steered_trace_test
