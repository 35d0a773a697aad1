#include <insonify/acoustics/tissue.hpp>
#include <insonify/channels.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <utility>
#include <vector>

using namespace insonify;

namespace trace_channels_test {
namespace {

using complex = std::complex<double>;
constexpr double full_turn = 6.283185307179586;
const complex imaginary_unit{0, 1};

const element_array row_of_24{.elements = 24, .pitch = 0.3_mm, .element_width = 0.27_mm};
const medium medium_1540{.density = 1000, .sound_speed = 1540};

// Spectrum of an RF record at a frequency, that of the pulse, and what lies between the two.
complex spectrum(const channel_data& data, std::uint32_t transmit, std::uint32_t element, double frequency) {
    complex sum = 0;
    for (std::uint32_t k = 0; k < data.samples; ++k)
        sum += static_cast<double>(data(transmit, element, k)) *
               std::exp(-imaginary_unit * full_turn * frequency * (k / static_cast<double>(data.sampling_frequency)));
    return sum / static_cast<double>(data.sampling_frequency);
}
double deviation_of(const channel_data& data) { return static_cast<double>(data.bandwidth * data.frequency) / 2.3548; }
double pulse_spectrum(const channel_data& data, double frequency) { // of the real pulse
    const double sigma = deviation_of(data), offset = (frequency - static_cast<double>(data.frequency)) / sigma;
    return std::sqrt(full_turn) / (full_turn * sigma) * std::exp(-0.5 * offset * offset) / 2;
}
complex transfer(const channel_data& data, std::uint32_t transmit, std::uint32_t element, double frequency) {
    return spectrum(data, transmit, element, frequency) / pulse_spectrum(data, frequency);
}

// Rayleigh's integral over the face of an element with its lens, soft baffle.
// @param across, along  pieces of the face
complex element_field_at(const element_array& of, std::uint32_t element, double x, double y, double z, double frequency,
                         int across = 24, int along = 160) {
    const double k = full_turn * frequency / static_cast<double>(of.sound_speed),
                 w = static_cast<double>(of.element_width), h = static_cast<double>(of.height),
                 focus = static_cast<double>(of.elevation_focus);
    const double centre = static_cast<double>(of.element(element).origin.x);
    complex sum = 0;
    for (int a = 0; a < across; ++a)
        for (int b = 0; b < along; ++b) {
            const double from_x = centre + w * ((a + 0.5) / across - 0.5), from_y = h * ((b + 0.5) / along - 0.5);
            const double r = std::sqrt((x - from_x) * (x - from_x) + (y - from_y) * (y - from_y) + z * z);
            const double lens = std::sqrt(focus * focus + from_y * from_y) - focus;
            sum += std::exp(imaginary_unit * k * (lens - r)) * z / (r * r);
        }
    return imaginary_unit * k / full_turn * sum * (w / across) * (h / along);
}

double decibels_of(complex ratio) { return 20 * std::log10(std::abs(ratio)); }
double nanoseconds(complex ratio, double frequency) { return 1e9 * std::arg(ratio) / (full_turn * frequency); }

channel_data echoes(const scene& body, const element_array& of, const channel_settings& settings) {
    return trace_channels(exec::par_unseq, body, of, pose{}, physical{}, full_synthetic_aperture(of), settings);
}

// Kirchhoff's integral over perfect mirrors that are the same along y, by pieces of their contour in the slice.
const medium mirror{.density = 1e12F, .sound_speed = 1540};
const double carrier = static_cast<double>(row_of_24.frequency), wavelength = 1540 / carrier;

struct contour_piece {
    double x, z, normal_x, normal_z, length;
};

// From 1 to 0: the ends of what stands for an infinite plate must not reflect.
double faded(double place, double from, double to) {
    return 0.5 + 0.5 * std::cos(full_turn / 2 * std::clamp((place - from) / (to - from), 0.0, 1.0));
}

complex kirchhoff(const std::vector<contour_piece>& contour, std::uint32_t n, std::uint32_t m) {
    const double k = full_turn / wavelength, step_y = wavelength / 2;
    complex sum = 0;
    for (const contour_piece& at : contour) {
        const auto cosine = [&](std::uint32_t element) {
            const double to_x = static_cast<double>(row_of_24.element(element).origin.x) - at.x;
            return (to_x * at.normal_x - at.z * at.normal_z) / std::hypot(to_x, at.z);
        };
        if (!(cosine(n) > 0) || !(cosine(m) > 0)) continue;
        for (double y = step_y / 2; y < 3.5e-3; y += step_y) { // and the same at -y
            const complex there = element_field_at(row_of_24, n, at.x, y, at.z, carrier),
                          back = n == m ? there : element_field_at(row_of_24, m, at.x, y, at.z, carrier);
            sum += 2 * at.length * step_y * (cosine(n) + cosine(m)) * there * back;
        }
    }
    return sum * imaginary_unit * k / (2 * full_turn) * full_turn /
           (imaginary_unit * k * static_cast<double>(row_of_24.element_width * row_of_24.height));
}

struct agreement {
    double decibels = 0, nanoseconds = 0; // the worst of them
};
agreement against_kirchhoff(const scene& body, const std::vector<contour_piece>& contour,
                            const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
    const channel_data data = echoes(body, row_of_24, {.depth = 25_mm, .opening = 50_deg});
    agreement worst;
    for (const auto& [n, m] : pairs) {
        const complex ratio = transfer(data, n, m, carrier) / kirchhoff(contour, n, m);
        worst.decibels = std::max(worst.decibels, std::fabs(decibels_of(ratio)));
        worst.nanoseconds = std::max(worst.nanoseconds, std::fabs(nanoseconds(ratio, carrier)));
    }
    return worst;
}

} // namespace

TEST_CASE("channels: a point returns what Rayleigh's integral over the elements says") {
    const scene body = scene{medium_1540}.build(exec::par);
    const double f0 = static_cast<double>(row_of_24.frequency);
    for (const vec3 place : {vec3{0, 0, 20_mm}, vec3{2_mm, 0, 16_mm}, vec3{1_mm, 1.5_mm, 25_mm}}) {
        const std::vector<point_scatterer> points{{place, 1e-3F}};
        const channel_data data =
            echoes(body, row_of_24, {.depth = 30_mm, .sampling_frequency = 60.8_MHz, .points = points});
        const double k = full_turn * f0 / 1540;
        double worst_db = 0, worst_ns = 0, worst_band = 0;
        for (const std::uint32_t n : {0U, 7U, 12U, 23U})
            for (const std::uint32_t m : {3U, 12U, 23U}) {
                const auto expected = [&](double frequency) {
                    const auto p = [&](std::uint32_t element) {
                        return element_field_at(row_of_24, element, static_cast<double>(place.x),
                                                static_cast<double>(place.y), static_cast<double>(place.z), frequency);
                    };
                    return 1e-3 * p(n) * p(m) * full_turn /
                           (imaginary_unit * k * frequency / f0 *
                            static_cast<double>(row_of_24.element_width * row_of_24.height));
                };
                const complex at_carrier = transfer(data, n, m, f0) / expected(f0);
                worst_db = std::max(worst_db, std::fabs(decibels_of(at_carrier)));
                worst_ns = std::max(worst_ns, std::fabs(nanoseconds(at_carrier, f0)));
                for (const double frequency : {0.75 * f0, 1.25 * f0})
                    worst_band = std::max(
                        worst_band, std::fabs(decibels_of(transfer(data, n, m, frequency) / expected(frequency))));
            }
        MESSAGE("at x ", place.x * 1e3F, " y ", place.y * 1e3F, " z ", place.z * 1e3F, " mm: within ", worst_db,
                " dB and ", worst_ns, " ns at the carrier, ", worst_band, " dB at 0.75 and 1.25 of it");
        const bool side_lobe = place.y != 0; // of the beam out of the slice: its amplitude changes fast with frequency
        CHECK(worst_db < (side_lobe ? 0.5 : 0.1));
        CHECK(worst_ns < 0.3);
        CHECK(worst_band < (side_lobe ? 1.0 : 0.3));
    }
}

TEST_CASE("channels: each element of a convex array receives a point in front of it, on the flanks as in the middle") {
    convex_element_array array = presets::c5_2v_elements;
    array.height = 2_mm; // 8 mm is far from it, and the lens does nothing
    const element_array flat{.elements = 1,
                             .pitch = array.pitch,
                             .element_width = array.element_width,
                             .frequency = array.frequency,
                             .height = array.height,
                             .elevation_focus = array.elevation_focus,
                             .sound_speed = array.sound_speed};
    const scene body = scene{medium_1540}.build(exec::par);
    const std::vector<transmit> each = full_synthetic_aperture(array);
    const double f0 = static_cast<double>(array.frequency), k = full_turn * f0 / 1540;
    const complex field = element_field_at(flat, 0, 0, 0, 8e-3, f0);
    const complex expected = 1e-3 * field * field * full_turn /
                             (imaginary_unit * k * static_cast<double>(array.element_width * array.height));
    for (const std::uint32_t element : {0U, 10U, 30U, 63U}) {
        const ray face = array.element(element);
        const std::vector<transmit> alone{each[element]};
        const auto received = [&](float distance) {
            const std::vector<point_scatterer> points{{face.at(distance), 1e-3F}};
            return trace_channels(exec::par_unseq, body, array, pose{}, physical{}, alone,
                                  {.depth = 20_mm, .points = points});
        };
        const channel_data data = received(8_mm);
        const complex ratio = transfer(data, 0, element, f0) / expected;
        const iq_channel_data envelope = demodulate(exec::seq, data);
        std::uint32_t peak = 0;
        for (std::uint32_t i = 0; i < data.samples; ++i)
            if (length(envelope(0, element, i)) > length(envelope(0, element, peak))) peak = i;
        CHECK(std::fabs(static_cast<float>(peak) / data.sampling_frequency - 2 * 8_mm / 1540) < 70e-9F); // a sample
        MESSAGE("element ", element, ", point at z = ", face.at(8_mm).z * 1e3F, " mm: ", decibels_of(ratio), " dB, ",
                nanoseconds(ratio, f0), " ns");
        CHECK(std::fabs(decibels_of(ratio)) < 0.1);
        CHECK(std::fabs(nanoseconds(ratio, f0)) < 2); // of 280, a period
        const channel_data behind = received(-2_mm);
        CHECK(std::all_of(behind.values.begin(), behind.values.end(), [](float value) { return value == 0; }));
    }
}

TEST_CASE("channels: a plate returns Kirchhoff's integral over its surface") {
    for (const float degrees : {0.0F, 10.0F}) {
        const float tilt = degrees * pi / 180;
        const vec3 down{std::sin(tilt), 0, std::cos(tilt)}, along{std::cos(tilt), 0, -std::sin(tilt)};
        scene body{medium_1540};
        body.add(make_box({-100_mm, -100_mm, 0}, {100_mm, 100_mm, 30_mm}), mirror,
                 {.at = look_at({0, 0, 15_mm}, vec3{0, 0, 15_mm} + down, along)});
        std::vector<contour_piece> contour;
        for (double s = -14e-3; s < 14e-3; s += wavelength / 3)
            contour.push_back({s * static_cast<double>(along.x), 15e-3 + s * static_cast<double>(along.z),
                               -static_cast<double>(down.x), -static_cast<double>(down.z),
                               wavelength / 3 * faded(std::fabs(s), 8e-3, 14e-3)});
        const agreement found = against_kirchhoff(body.build(exec::par), contour, {{12U, 12U}, {4U, 15U}, {20U, 9U}});
        MESSAGE("tilted by ", degrees, " degrees: within ", found.decibels, " dB, ", found.nanoseconds, " ns");
        CHECK(found.decibels < (degrees == 0 ? 0.25 : 0.4));
        CHECK(found.nanoseconds < 0.6);
    }
}

TEST_CASE("channels: cylinders return Kirchhoff's integral over what each element sees of them") {
    for (const double radius : {1.5e-3, 6e-3}) {
        const auto around = [radius](double angle) { // from the point nearest to the array
            return std::pair{radius * std::sin(angle), 15e-3 + radius * (1 - std::cos(angle))};
        };
        mesh cylinder;
        constexpr std::uint32_t corners = 600;
        for (std::uint32_t i = 0; i < corners; ++i)
            for (const float y : {-100_mm, 100_mm}) {
                const auto [x, z] = around(full_turn * i / corners);
                cylinder.positions.push_back({static_cast<float>(x), y, static_cast<float>(z)});
            }
        for (const float y : {-100_mm, 100_mm})
            cylinder.positions.push_back({0, y, static_cast<float>(15e-3 + radius)});
        for (std::uint32_t i = 0; i < corners; ++i) {
            const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % corners);
            for (const uvec3 face : {uvec3{a, b, a + 1}, uvec3{b, b + 1, a + 1}, uvec3{a, 2 * corners, b},
                                     uvec3{a + 1, b + 1, 2 * corners + 1}})
                cylinder.faces.push_back(face);
        }
        scene body{medium_1540};
        const object_id added = body.add(cylinder, mirror);
        body.build(exec::par);
        REQUIRE_FALSE(body.is_inside_out(added));
        std::vector<contour_piece> contour;
        const double step = wavelength / 4 / radius;
        for (double angle = -1.7 + step / 2; angle < 1.7; angle += step) {
            const auto [x, z] = around(angle);
            contour.push_back({x, z, std::sin(angle), -std::cos(angle), wavelength / 4});
        }
        const agreement found = against_kirchhoff(body, contour, {{12U, 12U}, {2U, 17U}});
        MESSAGE("radius ", radius * 1e3, " mm: within ", found.decibels, " dB, ", found.nanoseconds, " ns");
        CHECK(found.decibels < 0.4);
        CHECK(found.nanoseconds < 0.6);
    }
}

TEST_CASE("channels: the edge of a plate returns Kirchhoff's integral over the plate") {
    scene body{medium_1540};
    body.add(make_box({0.5_mm, -100_mm, 15_mm}, {100_mm, 100_mm, 16_mm}), mirror);
    std::vector<contour_piece> contour;
    const double step = wavelength / 4;
    for (double x = 0.5e-3 + step / 2; x < 14e-3; x += step)
        contour.push_back({x, 15e-3, 0, -1, step * faded(x, 8e-3, 14e-3)});
    const agreement found = against_kirchhoff(body.build(exec::par), contour, {{12U, 12U}, {6U, 21U}});
    MESSAGE("within ", found.decibels, " dB, ", found.nanoseconds, " ns");
    CHECK(found.decibels < 0.4);
    CHECK(found.nanoseconds < 0.6);
}

TEST_CASE("channels: reciprocal and independent of the threads, to the bit") {
    scene body{tissue::muscle};
    body.add(make_sphere({1_mm, 0, 12_mm}, 3_mm, 3), tissue::blood);
    body.add(make_sphere({-3_mm, 0, 16_mm}, 2_mm, 3), tissue::bone);
    body.build(exec::par);
    const channel_settings settings{.depth = 20_mm};
    const channel_data data = echoes(body, row_of_24, settings);
    bool reciprocal = true;
    double power = 0;
    for (std::uint32_t n = 0; n < data.elements; ++n)
        for (std::uint32_t m = 0; m < n; ++m)
            for (std::uint32_t k = 0; k < data.samples; ++k) {
                reciprocal = reciprocal && data(n, m, k) == data(m, n, k);
                power += static_cast<double>(data(n, m, k) * data(n, m, k));
            }
    CHECK(reciprocal);
    CHECK(power > 0);
    const auto sent = full_synthetic_aperture(row_of_24);
    CHECK(data == trace_channels(exec::seq, body, row_of_24, pose{}, physical{}, sent, settings));
    CHECK(data == trace_channels(exec::par.threads(3), body, row_of_24, pose{}, physical{}, sent, settings));
}

TEST_CASE("channels: a transmit is the sum of its elements, each delayed") {
    scene body{tissue::liver};
    body.add(make_sphere({0, 0, 12_mm}, 3_mm, 3), tissue::bone);
    body.build(exec::par);
    const channel_data each = echoes(body, row_of_24, {.depth = 18_mm});
    const channel_data plane = trace_channels(exec::par_unseq, body, row_of_24, pose{}, physical{},
                                              plane_waves(row_of_24, 1, 0), {.depth = 18_mm});
    double difference = 0, power = 0;
    for (std::uint32_t m = 0; m < each.elements; ++m)
        for (std::uint32_t k = 0; k < each.samples; ++k) {
            double sum = 0;
            for (std::uint32_t n = 0; n < each.elements; ++n) sum += static_cast<double>(each(n, m, k));
            difference += std::pow(sum - static_cast<double>(plane(0, m, k)), 2);
            power += sum * sum;
        }
    CHECK(difference < 1e-10 * power);

    // Delays: of one element alone, the record is the same, later.
    transmit late{.delays = std::vector<float>(row_of_24.elements, 0),
                  .weights = std::vector<float>(row_of_24.elements, 0)};
    late.weights[5] = -0.5F;
    const float samples = 16;
    late.delays[5] = samples / each.sampling_frequency;
    const channel_data delayed =
        trace_channels(exec::par_unseq, body, row_of_24, pose{}, physical{}, std::vector{late}, {.depth = 18_mm});
    difference = power = 0;
    for (std::uint32_t k = 16; k < each.samples; ++k) {
        difference +=
            std::pow(static_cast<double>(delayed(0, 9, k)) + 0.5 * static_cast<double>(each(5, 9, k - 16)), 2);
        power += std::pow(static_cast<double>(each(5, 9, k)), 2);
    }
    CHECK(difference < 1e-6 * power);
}

TEST_CASE("channels: sound takes the fastest way through layers") {
    scene body{medium{.density = 1000, .sound_speed = 1450}};
    body.add(make_box({-60_mm, -60_mm, 10_mm}, {60_mm, 60_mm, 100_mm}), medium_1540);
    body.build(exec::par);
    std::vector<ray> places;
    for (std::uint32_t i = 0; i < 128; ++i) places.push_back(presets::l11_5v_elements.element(i));
    detail::element_fans fans;
    fans.assign(
        exec::par, body, places, pose{}, 7.6e6F, 60e-3F, [](const medium&, float) { return 0.0F; },
        [](const medium&, const medium&, float, float) { return 1.0F; }, [](float) { return 1e-3F; });
    double worst = 0, straight = 0;
    for (std::uint32_t i = 0; i < 128; ++i)
        for (const vec2 p : {vec2{0, 20e-3F}, vec2{5e-3F, 30e-3F}}) {
            const double apart = std::fabs(static_cast<double>(places[i].origin.x - p.x)),
                         deep = static_cast<double>(p.y);
            if (apart > deep / 2) continue; // within F/1
            const auto time = [&](double crossing) {
                return std::hypot(crossing, 0.01) / 1450 + std::hypot(apart - crossing, deep - 0.01) / 1540;
            };
            double low = 0, high = apart; // of the crossing; the time has one minimum
            for (int step = 0; step < 100; ++step) {
                const double a = low + (high - low) / 3, b = high - (high - low) / 3;
                (time(a) < time(b) ? high : low) = time(a) < time(b) ? b : a;
            }
            const auto at = fans.find<1>(i, p);
            const float line = sum(at.line), distance = sum(at.distance);
            REQUIRE(line >= 0);
            worst = std::max(worst, std::fabs(static_cast<double>(fans.at_point(i, line, distance).time) - time(low)));
            straight = std::max(straight, std::fabs(time(apart * 0.01 / deep) - time(low)));
        }
    MESSAGE("within ", worst * 1e9, " ns of Fermat's principle within F/1; straight lines: ", straight * 1e9);
    CHECK(worst < 0.1e-9);
    CHECK(straight > 1e-9);
}

TEST_CASE("channels: attenuation follows frequency") {
    element_array one = row_of_24;
    one.elements = 1;
    const std::vector<point_scatterer> points{{{0, 0, 30_mm}, 1e-3F}};
    for (const bool fronts : {false, true}) {
        const auto through = [&](float attenuation) {
            const scene body =
                scene{medium{.density = 1000, .sound_speed = 1540, .attenuation = attenuation}}.build(exec::par);
            return echoes(body, one,
                          {.depth = 40_mm, .sampling_frequency = 60.8_MHz, .wave_fronts = fronts, .points = points});
        };
        const channel_data without = through(0), with = through(50); // 0.5 dB/(cm MHz)
        for (const double megahertz : {4.6, 6.0, 7.6, 9.0, 10.6}) {
            const double lost =
                decibels_of(transfer(with, 0, 0, megahertz * 1e6) / transfer(without, 0, 0, megahertz * 1e6));
            CHECK(lost == doctest::Approx(-2 * 0.5 * 3 * megahertz).scale(1e-30).epsilon(0.01));
        }
    }
}

// A Gaussian around f0 times exp(-a f) is one around m = f0 - a s^2, times exp(-a f0 + a^2 s^2 / 2). Times f, as a small element
// sends to a point and receives from it, its middle is m + s^2 / m, and the peak of its pulse is times m.
TEST_CASE("channels: attenuation moves the middle of the spectrum and lowers the peak by closed forms") {
    const std::vector<point_scatterer> points{{{0, 0, 30_mm}, 1e-3F}};
    for (const float bandwidth : {0.3F, 0.4F, 0.5F}) {
        element_array one = row_of_24;
        one.elements = 1;
        one.height = 0.3_mm;
        one.elevation_focus = 1; // no lens, nearly
        one.bandwidth = bandwidth;
        const auto through = [&](float attenuation) {
            const scene body =
                scene{medium{.density = 1000, .sound_speed = 1540, .attenuation = attenuation}}.build(exec::par);
            return echoes(body, one, {.depth = 40_mm, .sampling_frequency = 60.8_MHz, .points = points});
        };
        const channel_data without = through(0), with = through(50); // 0.5 dB/(cm MHz)
        const double sigma = deviation_of(with);
        const auto middle = [&](const channel_data& data) {
            double moment = 0, sum = 0;
            for (double frequency = 0.05e6; frequency < 2 * carrier; frequency += 0.05e6) {
                const double size = std::abs(spectrum(data, 0, 0, frequency));
                moment += frequency * size;
                sum += size;
            }
            return moment / sum;
        };
        const auto peak = [](const channel_data& data) {
            float largest = 0;
            for (const vec2 value : demodulate(exec::par, data).values) largest = std::max(largest, length(value));
            return 20 * std::log10(static_cast<double>(largest));
        };
        const double slope = 0.5e-6 * 2 * 3 * std::log(10.0) / 20, square = sigma * sigma; // Np/Hz
        const double m = carrier - slope * square,
                     nepers = -slope * carrier + 0.5 * slope * slope * square + std::log(m / carrier);
        const double moved = middle(with) - middle(without), lowered = peak(with) - peak(without),
                     expected = m + square / m - carrier - square / carrier, decibels = 20 / std::log(10.0) * nepers;
        MESSAGE("bandwidth ", bandwidth, ": ", moved * 1e-6, " MHz instead of ", expected * 1e-6, ", ", lowered,
                " dB instead of ", decibels);
        CHECK(std::fabs(moved - expected) < 0.05e6);
        CHECK(std::fabs(lowered - decibels) < 0.2);
    }
}

TEST_CASE("channels: speckle around a cyst is that of a sum over all scatterers at every frequency") {
    element_array array = row_of_24;
    array.height = 0.3_mm;
    array.elevation_focus = 1;
    array.bandwidth = 0.4F;
    const vec2 cyst{0.5_mm, 13_mm};
    std::vector<point_scatterer> points;
    for (std::uint64_t i = 0; points.size() < 500; ++i) {
        const vec2 place{(hash_uniform(1, i) - 0.5F) * 6_mm, 10_mm + hash_uniform(2, i) * 6_mm};
        if (length(place - cyst) > 1.2_mm) points.push_back({{place.x, 0, place.y}, 1e-6F * hash_normal(3, i).x});
    }
    const scene body = scene{medium_1540}.build(exec::par);
    const channel_data received = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                                 plane_waves(array, 1, 0), {.depth = 18_mm, .points = points});
    channel_data exact = received;
    std::fill(exact.values.begin(), exact.values.end(), 0.0F);
    const double rate = static_cast<double>(exact.sampling_frequency), step = rate / exact.samples;
    for (double frequency = step; frequency < rate / 2; frequency += step) {
        const double pulse = pulse_spectrum(exact, frequency);
        if (pulse < 1e-3 * pulse_spectrum(exact, carrier)) continue;
        std::vector<complex> back(array.elements);
        for (const point_scatterer& one : points) {
            std::vector<complex> field(array.elements);
            complex sent = 0;
            for (std::uint32_t n = 0; n < array.elements; ++n) {
                field[n] = element_field_at(array, n, static_cast<double>(one.position.x), 0,
                                            static_cast<double>(one.position.z), frequency, 6, 2);
                sent += field[n];
            }
            for (std::uint32_t n = 0; n < array.elements; ++n)
                back[n] += static_cast<double>(one.scattering_length) * sent * field[n];
        }
        const double k = full_turn * frequency / 1540;
        const complex received_of_sent = full_turn / (imaginary_unit * k * static_cast<double>(array.element_width) *
                                                      static_cast<double>(array.height));
        for (std::uint32_t n = 0; n < array.elements; ++n)
            for (std::uint32_t i = 0; i < exact.samples; ++i)
                exact(0, n, i) +=
                    static_cast<float>(2 * step *
                                       std::real(back[n] * received_of_sent * pulse *
                                                 std::exp(imaginary_unit * full_turn * frequency * (i / rate))));
    }
    const linear_array probe{.lines = 61, .width = 6_mm, .frequency = array.frequency};
    const auto beamformed = [&](const channel_data& data) {
        return beamform(exec::par_unseq, data, probe, {.depth = 17_mm, .samples = 850}, {.fnumber = 2});
    };
    const iq_lines here = beamformed(received), there = beamformed(exact);
    double apart = 0, power = 0, inside[2]{}, outside[2]{};
    for (std::uint32_t line = 0; line < here.count; ++line)
        for (std::uint32_t k = 500; k < 800; ++k) {
            const vec2 a = here(line, k), b = there(line, k);
            const auto square = [](vec2 of) { return static_cast<double>(dot(of, of)); };
            apart += square(a - b);
            power += square(b);
            const ray beam = probe.beam(static_cast<float>(line));
            const float away = length(vec2{beam.origin.x, (static_cast<float>(k) + 0.5F) * 0.02_mm} - cyst);
            double* const of = away < 0.8_mm ? inside : outside;
            of[0] += square(a);
            of[1] += square(b);
        }
    const double error = 10 * std::log10(apart / power),
                 contrast = 10 * std::log10(inside[0] / outside[0]) - 10 * std::log10(inside[1] / outside[1]);
    MESSAGE("lines differ by ", error, " dB, the contrast of the cyst, ", 10 * std::log10(inside[1] / outside[1]),
            " dB of sums, by ", contrast);
    CHECK(error < -35);
    CHECK(std::fabs(contrast) < 0.01);
}

TEST_CASE("channels: many scatterers are the sum of few, however they are sorted into blocks") {
    const element_array few{.elements = 4};
    const scene body = scene{medium_1540}.build(exec::par);
    std::vector<point_scatterer> points;
    for (std::uint64_t i = 0; i < 2 * detail::reflectors_per_block + 100; ++i)
        points.push_back({{(hash_uniform(1, i) - 0.5F) * 8_mm, 0, 2_mm + hash_uniform(2, i) * 8_mm}, 1e-6F});
    for (const bool fronts : {false, true}) {
        const auto received = [&](std::span<const point_scatterer> some) {
            return echoes(body, few, {.depth = 10_mm, .wave_fronts = fronts, .points = some});
        };
        const channel_data all = received(points);
        std::vector<double> sum(all.values.size(), 0.0);
        constexpr std::size_t part = 60; // less than a group
        for (std::size_t i = 0; i < points.size(); i += part) {
            const std::span<const point_scatterer> some{points.data() + i, std::min(part, points.size() - i)};
            const channel_data of_some = received(some);
            for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += static_cast<double>(of_some.values[k]);
        }
        double difference = 0, power = 0;
        for (std::size_t k = 0; k < sum.size(); ++k) {
            difference += std::pow(sum[k] - static_cast<double>(all.values[k]), 2);
            power += sum[k] * sum[k];
        }
        CHECK(power > 0);
        CHECK(difference < 1e-9 * power);
    }
}

TEST_CASE("channels: wave fronts are faster sums without the waves from the ends of the aperture") {
    const element_array wide{.elements = 64};
    scene body{medium_1540};
    body.build(exec::par);
    const std::vector<point_scatterer> points{{{1_mm, 0, 15_mm}, 1e-3F}};
    const auto sent = plane_waves(wide, 3, 10_deg);
    const auto trace = [&](bool fronts) {
        return trace_channels(exec::par_unseq, body, wide, pose{}, physical{}, sent,
                              {.depth = 20_mm, .wave_fronts = fronts, .points = points});
    };
    const channel_data sums = trace(false), fronts = trace(true);
    for (std::uint32_t t = 0; t < 3; ++t) {
        // The first echo, at the time of the plane wave: its size and place.
        const auto peak = [&](const channel_data& of) {
            const iq_channel_data iq = demodulate(exec::seq, of);
            std::uint32_t highest = 0;
            for (std::uint32_t k = 0; k < iq.samples; ++k)
                if (length(iq(t, 32, k)) > length(iq(t, 32, highest))) highest = k;
            return std::pair{highest, length(iq(t, 32, highest))};
        };
        const auto [at, size] = peak(sums);
        const auto [front_at, front_size] = peak(fronts);
        CHECK(std::abs(static_cast<int>(at) - static_cast<int>(front_at)) <= 1);
        CHECK(front_size == doctest::Approx(static_cast<double>(size)).scale(1e-30).epsilon(0.1));
    }
}

TEST_CASE("channels: at the edge of a shadow, sound arrives when it does beside it") {
    constexpr medium bone_like{.density = 1000, .sound_speed = 3000, .attenuation = 1};
    scene body{medium_1540};
    body.add(make_box({0, -60_mm, 10_mm}, {60_mm, 60_mm, 15_mm}), bone_like);
    body.build(exec::par);
    const std::vector<ray> places{{.origin = {0, 0, 0}, .direction = {0, 0, 1}}};
    detail::element_fans fans;
    fans.assign(
        exec::par, body, places, pose{}, 7.6e6F, 60e-3F,
        [](const medium& m, float f) {
            return m.sound_speed > 2000 ? 4e5F * f / 7.6e6F : 0.0F;
        }, // 1000 dB in 5 mm, one way
        [](const medium&, const medium&, float, float) { return 1.0F; }, [](float) { return 1e-6F; });
    std::uint32_t shaded = 0, mixed = 0;
    for (std::uint32_t i = 0; i <= 200; ++i) {
        const vec2 p{(static_cast<float>(i) * 0.01F - 1) * 1_mm, 30_mm};
        const auto at = fans.find<1>(0, p);
        const float line = sum(at.line), distance = sum(at.distance);
        const detail::arrived_wave wave = fans.at_point(0, line, distance);
        const float arrives = wave.passed * std::exp(-wave.lost); // the share of the lines beside the shadow
        if (arrives < 1e-4F) {
            ++shaded;
            continue;
        }
        mixed += arrives < 0.99F ? 1 : 0;
        CHECK(wave.time == doctest::Approx(static_cast<double>(distance) / 1540).scale(1e-30).epsilon(1e-6));
        CHECK(wave.lost_slope == 0);
    }
    CHECK(shaded > 50);
    CHECK(mixed > 10); // points between a line in the shadow and one beside it
}

TEST_CASE("channels: noise is independent from element to element, and absent unless asked for") {
    scene body{medium_1540};
    body.build(exec::par);
    const channel_data quiet = echoes(body, row_of_24, {.depth = 10_mm});
    CHECK(std::all_of(quiet.values.begin(), quiet.values.end(), [](float v) { return v == 0; }));
    const channel_data noisy = echoes(body, row_of_24, {.depth = 10_mm, .noise_level_db = -40});
    double power = 0, together = 0;
    for (std::uint32_t k = 0; k < noisy.samples; ++k)
        for (std::uint32_t m = 0; m + 1 < noisy.elements; ++m) {
            power += static_cast<double>(noisy(0, m, k) * noisy(0, m, k));
            together += static_cast<double>(noisy(0, m, k) * noisy(0, m + 1, k));
        }
    const double count = noisy.samples * (noisy.elements - 1.0);
    CHECK(std::sqrt(power / count) == doctest::Approx(0.01).scale(1e-30).epsilon(0.05));
    CHECK(std::fabs(together) < 4 * power / std::sqrt(count));
}

TEST_CASE("channels: from frame to frame, the speckle of flowing media changes, and nothing else") {
    const auto difference_of_frames = [](const medium& inside) {
        scene body{tissue::gel};
        body.add(make_cylinder({0, -40_mm, 10_mm}, {0, 40_mm, 10_mm}, 4_mm, 32, 8), inside);
        body.build(exec::par);
        const auto frame = [&](std::uint32_t number, bool surfaces) {
            return trace_channels(exec::par_unseq, body, row_of_24, pose{}, physical{}, plane_waves(row_of_24, 1, 0),
                                  {.depth = 15_mm, .surfaces = surfaces, .frame = number});
        };
        CHECK(frame(3, true) == frame(3, true)); // a frame is the same each time
        const channel_data first = frame(0, false), second = frame(1, false), all = frame(0, true),
                           all_later = frame(1, true);
        double power = 0, apart = 0, surfaces_apart = 0;
        for (std::size_t k = 0; k < first.values.size(); ++k) {
            power += std::pow(static_cast<double>(first.values[k]), 2);
            apart += std::pow(static_cast<double>(first.values[k] - second.values[k]), 2);
            surfaces_apart += std::pow(static_cast<double>(all.values[k] - first.values[k]) -
                                           static_cast<double>(all_later.values[k] - second.values[k]),
                                       2);
        }
        REQUIRE(power > 0);
        CHECK(surfaces_apart < 1e-6 * power);
        return apart / power;
    };
    medium resting = tissue::blood;
    resting.flowing = false;
    CHECK(difference_of_frames(tissue::liver) == 0);
    CHECK(difference_of_frames(resting) == 0);
    CHECK(difference_of_frames(tissue::blood) == doctest::Approx(2).scale(1e-30).epsilon(0.25)); // independent
}

TEST_CASE("channels: what cannot be traced is named") {
    scene body{tissue::muscle};
    body.build(exec::par);
    const auto sent = plane_waves(row_of_24, 1, 0);
    const auto trace = [&](const scene& what, const element_array& with, const std::vector<transmit>& waves,
                           const channel_settings& settings) {
        return trace_channels(exec::seq, what, with, pose{}, physical{}, waves, settings);
    };
    CHECK_THROWS_AS(trace(scene{}.build(exec::seq), row_of_24, {}, {}), usage_error);
    CHECK_THROWS_AS(trace(body, row_of_24, sent, {.depth = 40}), usage_error);
    for (const float wrong : {10e6F, -30e6F, std::nanf("")})
        CHECK_THROWS_AS(trace(body, row_of_24, sent, {.sampling_frequency = wrong}), usage_error);
    CHECK_THROWS_AS(trace(body, row_of_24, sent, {.noise_level_db = std::nanf("")}), usage_error);
    CHECK_THROWS_AS(trace(body, row_of_24, sent, {.max_memory = 1000}), usage_error);
    const channel_settings long_search{.depth = 900_mm, .opening = 45_deg, .max_memory = 1000};
    try { // of layers and tissue nothing is known yet
        trace(body, row_of_24, sent, long_search);
        FAIL("it was not refused");
    } catch (const usage_error& refused) {
        CHECK(std::string{refused.what()}.find("take at least 0.") != std::string::npos);
    }
    CHECK_THROWS_AS(trace(body, {.elements = 0}, sent, {}), usage_error);
    CHECK_THROWS_AS(trace(body, {.pitch = 0.2_mm}, sent, {}), usage_error);
    CHECK_THROWS_WITH_AS(trace(body, {.height = 1e-6F}, sent, {}),
                         "element_array: height is 1e-06 m; it must be at least 10 um, and 5_mm is usual", usage_error);
    CHECK_THROWS_WITH_AS(
        trace(body, {.height = 30_mm, .elevation_focus = 14_mm}, sent, {}),
        "element_array: height is 30 mm, and elevation_focus 14 mm; it must be at least half the height", usage_error);
    const auto refuses = [&](const char* sentence, auto&& change) {
        std::vector<transmit> wrong = sent;
        wrong[0].weights.assign(row_of_24.elements, 1.0F);
        change(wrong[0]);
        CHECK_THROWS_WITH_AS(trace(body, row_of_24, wrong, {}), sentence, usage_error);
    };
    refuses("transmit 0: it has 23 delays for 24 elements; state one for each",
            [](transmit& one) { one.delays.pop_back(); });
    refuses("transmit 0: it has 0 delays for 24 elements; state one for each",
            [](transmit& one) { one.delays.clear(); });
    refuses("transmit 0: it has 25 weights for 24 elements; state one for each, or none",
            [](transmit& one) { one.weights.push_back(1); });
    refuses("transmit 0: a delay is -1e-06 s; delays must be 0 to 1e-3 s: subtract the smallest from all",
            [](transmit& one) { one.delays[3] = -1e-6F; });
    refuses("transmit 0: a delay is 0.01 s; delays must be 0 to 1e-3 s: subtract the smallest from all",
            [](transmit& one) { one.delays[3] = 0.01F; });
    refuses("transmit 0: a delay is nan s; delays must be 0 to 1e-3 s: subtract the smallest from all",
            [](transmit& one) { one.delays[3] = std::nanf(""); });
    refuses("transmit 0: a weight is 2; weights must be -1 to 1: divide all by the largest",
            [](transmit& one) { one.weights[23] = 2; });
    refuses("transmit 0: a weight is nan; weights must be -1 to 1: divide all by the largest",
            [](transmit& one) { one.weights[0] = std::nanf(""); });
    refuses("transmit 0: all weights are 0; at least one element must fire",
            [](transmit& one) { one.weights.assign(row_of_24.elements, 0.0F); });
    scene solid{tissue::muscle};
    solid.add(make_sphere({0, 0, 0}, 20_mm, 2), tissue::bone);
    solid.build(exec::seq);
    CHECK_THROWS_WITH_AS(trace(solid, row_of_24, sent, {}),
                         "trace_channels: element 0 lies inside of an object that blocks sound, such as bone, metal or "
                         "gas; move the array, or the object",
                         usage_error);
    CHECK_THROWS_WITH_AS(trace(scene{tissue::air}.build(exec::seq), row_of_24, sent, {}),
                         "trace_channels: element 0 lies in the background of the scene, which blocks sound as bone, "
                         "metal or gas do; move the array into an object, or give the scene another background, such "
                         "as tissue::gel",
                         usage_error);
    CHECK_THROWS_AS(trace(scene{}, row_of_24, sent, {}), usage_error);
    pose scaled;
    scaled.rotation[0] *= 2.0F;
    CHECK_THROWS_AS(trace_channels(exec::seq, body, row_of_24, scaled, physical{}, sent), geometry_error);
}

TEST_CASE("channels: a rigid map of a body gives what `place` gives, speckle and rough surfaces too") {
    const channel_settings settings{.depth = 20_mm};
    for (const vec3 way : {vec3{0, 0, 0.35_mm}, vec3{2_mm, 3_mm, 4_mm}}) {
        scene body{tissue::gel};
        const object_id block = body.add(make_box({-20_mm, -20_mm, 5_mm}, {20_mm, 20_mm, 40_mm}, 4), tissue::liver);
        body.build(exec::par);
        const auto seen = [&] {
            return trace_channels(exec::par_unseq, body, row_of_24, pose{.translation = way}, physical{},
                                  plane_waves(row_of_24, 1, 0), settings);
        };
        body.place(block, {.translation = way});
        const channel_data placed = seen();
        body.place(block, {});
        body.deform(exec::par, [&](vec3 rest) { return rest + way; });
        const channel_data deformed = seen();
        double difference = 0, power = 0;
        for (std::size_t i = 0; i < placed.values.size(); ++i) {
            const double apart = static_cast<double>(placed.values[i] - deformed.values[i]);
            difference += apart * apart;
            power += static_cast<double>(placed.values[i]) * static_cast<double>(placed.values[i]);
        }
        CHECK(difference < 1e-6 * power);
    }
}

} // namespace trace_channels_test
