#include <insonify/acoustics/tissue.hpp>
#include <insonify/doppler/colour_doppler.hpp>
#include <insonify/doppler/pulsed_doppler.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/motion/press.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <functional>
#include <string>

using namespace insonify;

namespace deformed_doppler_test {
namespace {

const linear_array probe{.lines = 64, .width = 24_mm, .frequency = 5_MHz};

struct at_rest {
    vec3 operator()(object_id, vec3, float) const { return {0, 0, 0}; }
};

/// A liver block in muscle. @param fibres  of the block
scene block(fibre_directions fibres = {}) {
    scene body{tissue::muscle};
    body.add(make_box({-9_mm, -15_mm, 10_mm}, {9_mm, 15_mm, 30_mm}, 4),
             fibres.varies() ? tissue::muscle : tissue::liver, {.fibres = fibres});
    body.build(exec::par);
    return body;
}

/// Difference of the first pulse of a train at rest from `trace`: rms over rms.
double error_of_rest(const scene& body, std::uint32_t planes) {
    const acquisition scan{.depth = 40_mm, .samples = 512, .planes = planes, .frame = 7};
    const ensemble_echoes found = trace_ensemble(exec::par_unseq, body, probe, pose{}, physical{}, at_rest{}, scan,
                                                 {.interval = 1 / 4_kHz, .count = 2});
    const iq_lines expected = trace(exec::par_unseq, body, probe, pose{}, physical{}, scan);
    double error = 0, power = 0;
    for (std::size_t i = 0; i < expected.values.size(); ++i) {
        const vec2 difference = found.resting.values[i] + found.moving[0].values[i] - expected.values[i];
        error += static_cast<double>(dot(difference, difference));
        power += static_cast<double>(dot(expected.values[i], expected.values[i]));
    }
    return std::sqrt(error / power);
}

} // namespace

TEST_CASE("a pulse train of deformed tissue at rest has the echoes of `trace`") {
    const auto curved = [](vec3 point) { return normalize(vec3{1, 0, 20 * point.x}); };
    const auto with = [](scene body, const std::function<vec3(vec3)>& map) {
        body.deform(exec::par, map);
        return body;
    };
    const auto compressed = [](vec3 p) { return vec3{p.x, p.y, 0.99F * p.z}; };
    const auto moved = [](vec3 p) { return p + vec3{0.3_mm, 0, 1_mm}; };
    const struct {
        std::string name;
        scene body;
    } cases[] = {{"compressed by 1 %", with(block(), compressed)},
                 {"moved by 1 mm", with(block(), moved)},
                 {"pressed", with(block(), indentation{.depth = 3_mm, .face = {20_mm, 8_mm}})},
                 {"curved fibres", block(curved)},
                 {"curved fibres, pressed", with(block(curved), indentation{.depth = 3_mm, .face = {20_mm, 8_mm}})}};
    for (const auto& one : cases)
        for (const std::uint32_t planes : {1U, 3U}) {
            const double error = error_of_rest(one.body, planes);
            MESSAGE(one.name, ", ", planes, " planes: differs by ", error, " of the rms, expected below 1e-3");
            CHECK(error < 1e-3);
        }
}

namespace {

/// A vessel at 35 degrees to the lines, in a block of liver.
struct vessel {
    static constexpr float radius = 4_mm;
    vec3 along{std::sin(35_deg), 0, std::cos(35_deg)};
    scene body{medium{.density = 1000, .sound_speed = display_speed}};
    poiseuille stream{};

    explicit vessel(const pose& at = {}) {
        const vec3 middle{0, 0, 20_mm};
        stream = {
            .from = middle - 50_mm * along, .to = middle + 50_mm * along, .radius = radius, .peak_velocity = 0.3F};
        medium blood = tissue::blood, around = tissue::liver;
        blood.sound_speed = around.sound_speed = display_speed; // so that scanner and field mean the same velocity
        around.structure = {};
        body.add(make_box(middle - vec3{60_mm}, middle + vec3{60_mm}, 6), around, {.at = at});
        stream.object = body.add(make_cylinder(stream.from, stream.to, radius, 96, 24), blood, {.at = at});
        body.build(exec::par);
    }
};

/// A scene at rest, as `map` moves it.
template <class Map>
scene deformed(scene body, const Map& map) {
    body.deform(exec::par, map);
    return body;
}

/// What colour Doppler shows of the whole picture: the mean power, and the mean velocity weighted with it.
struct mean_flow {
    double velocity = 0, power = 0;
};
template <class Field>
mean_flow colour_of(const scene& body, const Field& field, wall_filter wall = {}) {
    const flow_lines seen = colour_doppler(exec::par_unseq, body, probe, pose{}, field,
                                           {.depth = 40_mm, .prf = 6_kHz, .wall = wall, .noise_db = no_level_db});
    mean_flow sum;
    for (const flow_sample& one : seen.values) {
        sum.velocity += static_cast<double>(one.velocity * one.power);
        sum.power += static_cast<double>(one.power);
    }
    return {sum.velocity / sum.power, sum.power / static_cast<double>(seen.values.size())};
}
void check_same(const char* what, const mean_flow& found, const mean_flow& expected) {
    MESSAGE(std::string{what}, ": velocity ", found.velocity, " m/s, expected ", expected.velocity, "; power times ",
            found.power / expected.power, ", expected 1");
    CHECK(std::fabs(found.velocity / expected.velocity - 1) < 0.02);
    CHECK(std::fabs(found.power / expected.power - 1) < 0.02);
}

const pose moves[] = {{.translation = {0, 0, 8_mm}},
                      {.translation = {2_mm, 0, -8_mm}},
                      look_at({1_mm, 2_mm, -3_mm}, {9_mm, 4_mm, 30_mm}, {1, 0.3F, -0.2F})};

} // namespace

TEST_CASE("a rigid map of a vessel gives the velocity and the power of one that is placed there, by colour and power "
          "Doppler") {
    for (const pose& moved : moves) {
        const vessel rest, placed{moved};
        const scene body = deformed(rest.body, [&moved](vec3 p) { return moved.point(p); });
        check_same("blood", colour_of(body, rest.stream), colour_of(placed.body, placed.stream));
    }
}

TEST_CASE("a rigid map of tissue that moves gives what `place` gives, by tissue Doppler") {
    const auto moves_as_one = [](object_id of, vec3, float) {
        return of == background_object ? vec3{0, 0, 0} : vec3{0.01F, 0, -0.04F};
    };
    for (const pose& moved : moves) {
        const auto block_at = [](const pose& at) {
            scene body{medium{.density = 1000, .sound_speed = 1540}};
            body.add(make_box({-30_mm, -30_mm, 8_mm}, {30_mm, 30_mm, 33_mm}, 5), tissue::liver, {.at = at});
            return body.build(exec::par), body;
        };
        const scene body = deformed(block_at({}), [&moved](vec3 p) { return moved.point(p); });
        const wall_filter none{.type = wall_filter::kind::none};
        check_same("tissue", colour_of(body, moves_as_one, none), colour_of(block_at(moved), moves_as_one, none));
    }
}

TEST_CASE("a rigid map of a vessel gives the spectrum of one that is placed there, by pulsed Doppler") {
    const pose moved{.translation = {0, 0, 8_mm}};
    const vessel rest, placed{moved};
    const auto mean_velocity = [](const scene& body, const poiseuille& stream) {
        const doppler_spectrum seen = pulsed_doppler(exec::par_unseq, body, probe, pose{}, stream,
                                                     {.line = 32, .gate = 28_mm, .prf = 6_kHz, .duration = 0.1F});
        double power = 0, sum = 0;
        for (std::uint32_t window = 0; window < seen.windows; ++window)
            for (std::uint32_t bin = 0; bin < seen.bins; ++bin) {
                const double here = static_cast<double>(seen(window, bin));
                power += here;
                sum += here * static_cast<double>(seen.lowest_velocity + seen.step * static_cast<float>(bin));
            }
        return mean_flow{sum / power, power};
    };
    const scene body = deformed(rest.body, [&moved](vec3 p) { return moved.point(p); });
    check_same("gate", mean_velocity(body, rest.stream), mean_velocity(placed.body, placed.stream));
}

TEST_CASE("a press that narrows a vessel keeps its flow") {
    // A face that covers all: only depths change, so that the flow through each plane of one depth is that at rest where the
    // velocity along the lines is that at rest of the same blood.
    const vessel rest;
    const indentation press{.depth = 6_mm, .face = {1, 1}, .decay = 18_mm};
    const scene body = deformed(rest.body, press);
    const auto mean_along_lines = [&](const scene& seen_in) {
        const flow_lines seen =
            colour_doppler(exec::par_unseq, seen_in, probe, {.translation = {0, 0, 6_mm}}, rest.stream,
                           {.depth = 30_mm,
                            .prf = 9_kHz,
                            .ensemble = 12,
                            .wall = {.type = wall_filter::kind::none},
                            .average_length = 0.5_mm,
                            .average_lines = 1,
                            .burst = 1,
                            .noise_db = no_level_db});
        double sum = 0, area = 0;
        for (std::uint32_t line = 0; line < seen.count; ++line)
            for (std::uint32_t k = 0; k < seen.samples; ++k) {
                const vec3 now{((static_cast<float>(line) + 0.5F) / 64 - 0.5F) * probe.width, 0,
                               6_mm + (static_cast<float>(k) + 0.5F) / static_cast<float>(seen.samples) * seen.depth};
                const vec3 point = seen_in.rest_of(now) - vec3{0, 0, 20_mm};
                const float r = length(point - dot(point, rest.along) * rest.along);
                if (!(r < vessel::radius) || now.z < 10_mm) continue;
                sum -= static_cast<double>(r * seen(line, k).velocity); // away from the probe
                area += static_cast<double>(r);
            }
        return sum / area;
    };
    const double expected = 0.5 * static_cast<double>(rest.stream.peak_velocity * rest.along.z),
                 found = mean_along_lines(body), at_rest = mean_along_lines(rest.body);
    MESSAGE("mean velocity along the lines ", found, " m/s, expected ", expected, "; of the vessel at rest ", at_rest);
    CHECK(std::fabs(found / at_rest - 1) < 0.02);
    CHECK(std::fabs(found / expected - 1) < 0.1);
}

TEST_CASE("a vessel that collapses and descends out of the slice has the velocity of its flow along the lines") {
    // Of the volume flow V A, the lumen's area being A times its opening: V / opening along the axis.
    const vec3 along = normalize(vec3{0, 1, 0.47F}), middle{0, 0, 17.5_mm};
    scene body{tissue::muscle};
    medium blood = tissue::blood;
    blood.sound_speed = display_speed;
    const object_id vein =
        body.add(make_cylinder(middle - 40_mm * along, middle + 40_mm * along, 4.5_mm, 64, 64), blood);
    body.build(exec::par);
    collapse wall{.from = middle, .to = middle + along, .radius = 4.5_mm, .outside = 8.4_mmHg, .inside = 8_mmHg};
    body.deform(exec::par, wall);
    const poiseuille stream{
        .object = vein, .from = middle, .to = middle + along, .radius = 4.5_mm, .peak_velocity = 0.15F};
    const flow_lines seen =
        colour_doppler(exec::par_unseq, body, probe, pose{}, stream,
                       {.depth = 33_mm, .prf = 5_kHz, .wall = {.order = 0}, .noise_db = no_level_db});
    double found = 0, count = 0; // in the middle of the lumen
    for (std::uint32_t line = 30; line < 34; ++line)
        for (float z = 17.2_mm; z < 17.8_mm; z += 0.1_mm) {
            found -= static_cast<double>(
                seen(line, static_cast<std::uint32_t>(z / 33_mm * static_cast<float>(seen.samples))).velocity);
            count += 1;
        }
    const double expected = static_cast<double>(0.15F / wall.opening() * along.z);
    MESSAGE("opening ", wall.opening(), ": ", found / count, " m/s along the lines, expected ", expected);
    CHECK(std::fabs(found / count / expected - 1) < 0.1);
}

TEST_CASE("a velocity field is asked in coordinates of the object where fibres are curved") {
    const auto by_side = [](object_id of, vec3 point, float) {
        return of == background_object ? vec3{0, 0, 0} : vec3{0, 0, -4 * point.x};
    };
    const auto bent = [](vec3 point) { return vec3{std::cos(40 * point.z), 0, std::sin(40 * point.z)}; };
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.add(make_box({-30_mm, -30_mm, 8_mm}, {30_mm, 30_mm, 35_mm}), tissue::muscle, {.fibres = bent});
    body.build(exec::par);
    const flow_lines seen = colour_doppler(exec::par_unseq, body, probe, pose{}, by_side,
                                           {.depth = 32_mm, .prf = 4_kHz, .wall = {.type = wall_filter::kind::none}});
    double error = 0, count = 0;
    for (std::uint32_t line = 0; line < seen.count; ++line)
        for (std::uint32_t k = seen.samples / 3; k < seen.samples; ++k) {
            const float x = ((static_cast<float>(line) + 0.5F) / 64 - 0.5F) * probe.width;
            error += std::fabs(static_cast<double>(seen(line, k).velocity - 4 * x));
            count += 1;
        }
    MESSAGE("velocities differ by ", error / count, " m/s on average, expected below 0.002; the largest is 0.048");
    CHECK(error / count < 0.002);
}

TEST_CASE(
    "an object that is placed elsewhere after it was deformed keeps its speckle, its velocity and its displacement") {
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    const object_id block = body.add(make_box({-30_mm, -30_mm, 2_mm}, {30_mm, 30_mm, 33_mm}, 5), tissue::liver);
    body.build(exec::par);
    body.deform(exec::par, indentation{.depth = 3_mm, .face = {20_mm, 20_mm}});
    const auto falls = [](object_id of, vec3, float) {
        return of == background_object ? vec3{0, 0, 0} : vec3{0, 0, -0.04F};
    };
    const auto seen = [&](const pose& at) {
        const iq_ensemble echoes =
            doppler_ensemble(exec::par_unseq, body, probe, at, physical{}, falls, {.depth = 30_mm, .pulses = 2});
        return echoes;
    };
    const iq_ensemble before = seen({});
    for (const vec3 way : {vec3{0, 0, 5_mm}, vec3{30_mm, 0, 0}, vec3{0, 20_mm, 100_mm}}) {
        body.place(block, {.translation = way});
        const iq_ensemble after = seen({.translation = way});
        for (std::size_t pulse = 0; pulse < 2; ++pulse) {
            double difference = 0, power = 0;
            for (std::size_t i = 0; i < before.pulses[pulse].values.size(); ++i) {
                const vec2 was = before.pulses[pulse].values[i], apart = after.pulses[pulse].values[i] - was;
                difference += static_cast<double>(dot(apart, apart));
                power += static_cast<double>(dot(was, was));
            }
            CHECK(difference < 1e-4 * power);
        }
    }
}

} // namespace deformed_doppler_test
