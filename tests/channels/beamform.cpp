#include <insonify/acoustics/tissue.hpp>
#include <insonify/channels.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <utility>
#include <vector>

using namespace insonify;

namespace beamform_test {
namespace {

const medium uniform_1540{.density = 1000, .sound_speed = 1540};

vec2 brightest_point(const scan_lines& lines, const auto& probe) {
    std::uint32_t line = 0, sample = 0;
    for (std::uint32_t i = 0; i < lines.count; ++i)
        for (std::uint32_t k = 0; k < lines.samples; ++k)
            if (lines(i, k) > lines(line, sample)) line = i, sample = k;
    const ray beam = probe.beam(static_cast<float>(line));
    const vec3 at = beam.origin + (static_cast<float>(sample) + 0.5F) * lines.depth /
                                      static_cast<float>(lines.samples) * beam.direction;
    return {at.x, at.z};
}

struct speckle_numbers {
    double level_db, snr, lateral, axial; // widths of the autocorrelation at half of its height, metres
};
speckle_numbers speckle_of(const iq_lines& lines, float from, float to, float spacing) {
    const auto first = static_cast<std::uint32_t>(from / lines.depth * static_cast<float>(lines.samples)),
               last = static_cast<std::uint32_t>(to / lines.depth * static_cast<float>(lines.samples));
    double power = 0, mean = 0, count = 0;
    for (std::uint32_t i = 0; i < lines.count; ++i)
        for (std::uint32_t k = first; k < last; ++k) {
            const auto size = static_cast<double>(length(lines(i, k)));
            power += size * size;
            mean += size;
            ++count;
        }
    power /= count;
    mean /= count;
    const auto width = [&](std::uint32_t across, std::uint32_t along) {
        double before = 1;
        for (std::uint32_t lag = 1; lag < 100; ++lag) {
            double real = 0, imaginary = 0, pairs = 0;
            for (std::uint32_t i = 0; i + lag * across < lines.count; ++i)
                for (std::uint32_t k = first; k + lag * along < last; ++k) {
                    const vec2 a = lines(i, k), b = lines(i + lag * across, k + lag * along);
                    real += static_cast<double>(a.x * b.x + a.y * b.y);
                    imaginary += static_cast<double>(a.y * b.x - a.x * b.y);
                    ++pairs;
                }
            const double now = std::hypot(real, imaginary) / pairs / power;
            if (now < 0.5) return 2 * (lag - 1 + (before - 0.5) / (before - now));
            before = now;
        }
        return 0.0;
    };
    return {10 * std::log10(power), mean / std::sqrt(power - mean * mean), width(1, 0) * static_cast<double>(spacing),
            width(0, 1) * static_cast<double>(lines.depth / static_cast<float>(lines.samples))};
}

/// The largest amplitudes of the lines between two samples.
std::vector<float> peaks_of(const scan_lines& lines, std::uint32_t first, std::uint32_t last) {
    std::vector<float> peaks(lines.count, 0);
    for (std::uint32_t i = 0; i < lines.count; ++i)
        for (std::uint32_t k = first; k < last; ++k) peaks[i] = std::max(peaks[i], lines(i, k));
    return peaks;
}

/// Width at half of the largest value, in elements, linear in between.
double width_of(const std::vector<float>& values) {
    const float half = 0.5F * *std::max_element(values.begin(), values.end());
    double width = 0;
    for (std::size_t i = 0; i + 1 < values.size(); ++i) {
        const float low = std::min(values[i], values[i + 1]), high = std::max(values[i], values[i + 1]);
        width += low >= half ? 1 : high > half ? static_cast<double>((high - half) / (high - low)) : 0;
    }
    return width;
}

} // namespace

TEST_CASE("beamform: points are where they are, for every array and kind of transmit") {
    const scene body = scene{uniform_1540}.build(exec::par);
    const std::vector<point_scatterer> points{{{2_mm, 0, 18_mm}, 1e-3F}};
    const channel_settings settings{.depth = 25_mm, .points = points};
    const linear_array lines{.lines = 97, .width = 9.7_mm, .frequency = 7.6_MHz};
    const element_array flat{.elements = 48};
    const auto at = [&](const auto& array, const std::vector<transmit>& sent, const auto& probe) {
        const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{}, sent, settings);
        return brightest_point(
            envelope(exec::par_unseq,
                     beamform(exec::par_unseq, data, probe, {.depth = 25_mm, .samples = 1250}, {.fnumber = 1.5F})),
            probe);
    };
    const std::vector<vec3> foci{{0, 0, 18_mm}, {2_mm, 0, 18_mm}}, sources{{0, 0, -10_mm}, {3_mm, 0, -10_mm}};
    std::vector<transmit> unknown = plane_waves(flat, 5, 10_deg);
    for (transmit& one : unknown) one.front = transmit::wave::any;
    for (const std::vector<transmit>& sent :
         {plane_waves(flat, 5, 10_deg), diverging_waves(flat, sources), focused(flat, foci), focused(flat, foci, 2),
          full_synthetic_aperture(flat), unknown}) {
        const vec2 found = at(flat, sent, lines);
        CHECK(found.x == doctest::Approx(2e-3).scale(1e-30).epsilon(0.06));
        CHECK(found.y == doctest::Approx(18e-3).scale(1e-30).epsilon(0.003));
    }
    const convex_element_array bent{.elements = 48, .pitch = 0.3_mm, .radius = 40_mm, .element_width = 0.27_mm};
    const convex_array sector{.lines = 97, .radius = 40_mm, .field_of_view = 14_deg, .frequency = bent.frequency};
    for (const std::vector<transmit>& sent : {plane_waves(bent, 5, 10_deg), full_synthetic_aperture(bent)}) {
        const vec2 found = at(bent, sent, sector);
        CHECK(found.x == doctest::Approx(2e-3).scale(1e-30).epsilon(0.15));
        CHECK(found.y == doctest::Approx(18e-3).scale(1e-30).epsilon(0.006));
    }
}

TEST_CASE("beamform: the level and width of a point, by closed forms") {
    element_array array{
        .elements = 64, .element_width = 0.05_mm, .bandwidth = 0.3F}; // elements radiate alike everywhere
    const scene body = scene{uniform_1540}.build(exec::par);
    const std::vector<point_scatterer> points{{{0, 0, 18_mm}, 1e-3F}};
    const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                             full_synthetic_aperture(array), {.depth = 22_mm, .points = points});
    const linear_array lines{.lines = 151, .width = 3.02_mm, .frequency = 7.6_MHz};
    constexpr double wavelength = 1540 / 7.6e6;
    for (const float fnumber : {3.0F, 4.0F}) {
        const scan_lines seen =
            envelope(exec::par_unseq,
                     beamform(exec::par_unseq, data, lines, {.depth = 22_mm, .samples = 2200}, {.fnumber = fnumber}));
        const std::vector<float> across = peaks_of(seen, 1700, 1900);
        const float peak = *std::max_element(across.begin(), across.end());
        // L h D / (wavelength z^2), in the focus of the lens.
        const double expected = 1e-3 * 5e-3 * (18e-3 / static_cast<double>(fnumber)) / (wavelength * 18e-3 * 18e-3);
        CHECK(20 * std::log10(static_cast<double>(peak) / expected) == doctest::Approx(0).scale(1).epsilon(0.5));
        // sinc^2: 0.886 wavelengths F at -6 dB, of an aperture of a whole number of elements.
        CHECK(width_of(across) * 0.02e-3 ==
              doctest::Approx(0.886 * wavelength * static_cast<double>(fnumber)).scale(1e-30).epsilon(0.05));
    }
}

TEST_CASE("beamform: a point in the focus is as wide as in b_mode") {
    const element_array array{.elements = 64};
    const scene body = scene{uniform_1540}.build(exec::par);
    const std::vector<point_scatterer> points{{{0, 0, 18_mm}, 1e-3F}};
    const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                             full_synthetic_aperture(array), {.depth = 20_mm, .points = points});
    const linear_array probe{.frequency = 7.6_MHz, .fnumber = 2, .focus = 18_mm};
    linear_array lines = probe; // finer, and around the point alone
    lines.lines = 151;
    lines.width = 3.02_mm;
    const scan_lines seen = envelope(
        exec::par_unseq, beamform(exec::par_unseq, data, lines, {.depth = 20_mm, .samples = 2000}, {.fnumber = 2}));
    const double width = width_of(peaks_of(seen, 1700, 1900)) * 0.02e-3;
    const auto picture = static_cast<double>(beam_of(probe, 18_mm).lateral_width(18_mm));
    MESSAGE("a point is ", width * 1e3, " mm wide, in b_mode ", picture * 1e3);
    CHECK(width == doctest::Approx(picture).scale(1e-30).epsilon(0.05));
}

TEST_CASE("beamform: a mirror in the focus, less what the ends of the aperture and the sides of the elements lose") {
    scene body{uniform_1540};
    body.add(make_box({-60_mm, -60_mm, 18_mm}, {60_mm, 60_mm, 30_mm}), medium{.density = 1e12F, .sound_speed = 1540});
    body.build(exec::par);
    const element_array array{.elements = 48};
    const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                             full_synthetic_aperture(array), {.depth = 20_mm, .opening = 45_deg});
    const linear_array lines{.lines = 1, .width = 0.1_mm, .frequency = 7.6_MHz};
    const scan_lines seen = envelope(
        exec::par_unseq, beamform(exec::par_unseq, data, lines, {.depth = 20_mm, .samples = 2000}, {.fnumber = 2}));
    float peak = 0;
    for (const float one : seen.values) peak = std::max(peak, one);
    // Of apertures whose mirror image passes the focus, the ends lose sqrt(2 wavelength z) / (pi D) exp(i pi / 4) each way:
    // D = 9 mm in the slice, and 5 mm out of it.
    const auto ends = [](double width) {
        const double lost = std::sqrt(2 * 1540 / 7.6e6 * 18e-3) / (3.14159 * width) * std::sqrt(0.5);
        return 20 * std::log10(std::hypot(1 - lost, lost));
    };
    const double level = 20 * std::log10(static_cast<double>(peak));
    MESSAGE("mirror at F/2: ", level, " dB; what the ends lose: ", ends(9e-3) + ends(5e-3));
    CHECK(level < ends(9e-3) + ends(5e-3));       // and the elements radiate less to the sides,
    CHECK(level > ends(9e-3) + ends(5e-3) - 1.8); // by up to 1.8 dB at 14 degrees
}

TEST_CASE("beamform: speckle has the level of b_mode, and the statistics of a Gaussian field") {
    const element_array array{.elements = 64};
    scene body{medium{.density = 1000, .sound_speed = 1540, .backscatter = 1}};
    body.build(exec::par);
    const linear_array lines{.lines = 128,
                             .width = 9.6_mm, // more than F/2 needs at 18 mm
                             .frequency = 7.6_MHz,
                             .focus = 18_mm,
                             .elevation_focus = 18_mm,
                             .bandwidth = 0.77F};
    const acquisition grid{.depth = 21_mm, .samples = 1344, .planes = 5};
    const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                             full_synthetic_aperture(array), {.depth = 22_mm, .opening = 10_deg});
    const speckle_numbers channels =
        speckle_of(beamform(exec::par_unseq, data, lines, grid, {.fnumber = 2}), 16.5_mm, 19.5_mm, 9.6_mm / 128);
    const speckle_numbers picture =
        speckle_of(convolve(exec::par_unseq, trace(exec::par_unseq, body, lines, pose{}, physical{}, grid),
                            nominal_pulse(lines), lines),
                   16.5_mm, 19.5_mm, 9.6_mm / 128);
    MESSAGE("level ", channels.level_db, " dB, b_mode ", picture.level_db, "; SNR ", channels.snr, "; widths ",
            channels.lateral * 1e3, " and ", channels.axial * 1e3, " mm, b_mode ", picture.lateral * 1e3, " and ",
            picture.axial * 1e3, " mm");
    CHECK(std::fabs(channels.level_db - picture.level_db) < 1);
    CHECK(channels.snr == doctest::Approx(1.913).scale(1e-30).epsilon(0.08)); // Rayleigh; some 200 cells
    // The autocorrelation of a Gaussian pulse is sqrt(2) as wide as the pulse: 0.441 c / (B f0) at -6 dB.
    CHECK(channels.axial == doctest::Approx(1.414 * 0.441 * 1540 / (0.77 * 7.6e6)).scale(1e-30).epsilon(0.06));
    // That of sinc^2 is 1.14 wavelengths F wide at half of its height.
    CHECK(channels.lateral == doctest::Approx(1.14 * 2 * 1540 / 7.6e6).scale(1e-30).epsilon(0.06));
    // The beam of b_mode is a Gaussian that is as wide as sinc^2 at -6 dB: its autocorrelation is 1.10 times as wide.
    CHECK(picture.lateral == doctest::Approx(1.1 * channels.lateral).scale(1e-30).epsilon(0.05));
    CHECK(picture.axial == doctest::Approx(channels.axial).scale(1e-30).epsilon(0.05));
}

TEST_CASE("beamform: windows widen the main lobe and lower the side lobes by their transforms") {
    const element_array array{.elements = 96, .pitch = 0.15_mm, .element_width = 0.05_mm, .bandwidth = 0.1F};
    const scene body = scene{uniform_1540}.build(exec::par);
    const std::vector<point_scatterer> points{{{0, 0, 18_mm}, 1e-3F}};
    const iq_channel_data data =
        demodulate(exec::par_unseq, trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                                   plane_waves(array, 1, 0), {.depth = 22_mm, .points = points}));
    constexpr float fnumber = 4;
    const linear_array lines{.lines = 301, .width = 6.02_mm, .frequency = array.frequency}; // 0.02 mm apart
    const auto sinc = [](double u) { return u == 0 ? 1 : std::sin(3.14159265 * u) / (3.14159265 * u); };
    // Of an aperture from -1/2 to 1/2, at the spatial frequency u = x / (wavelength F).
    const auto transform = [&](aperture_window window, double u) {
        const double shifted = sinc(u - 1) + sinc(u + 1);
        switch (window) {
        case aperture_window::hann:
            return (0.5 * sinc(u) + 0.25 * shifted) / 0.5;
        case aperture_window::hamming:
            return (0.54 * sinc(u) + 0.23 * shifted) / 0.54;
        case aperture_window::tukey: // a rectangle convolved with half a period of a cosine
            return sinc(0.75 * u) *
                   (std::fabs(u - 2) < 1e-9 ? 3.14159265 / 4 : std::cos(3.14159265 * u / 4) / (1 - u * u / 4));
        case aperture_window::rectangular:
            break;
        }
        return sinc(u);
    };
    for (const aperture_window window :
         {aperture_window::rectangular, aperture_window::hann, aperture_window::hamming, aperture_window::tukey}) {
        const iq_lines made = beamform(exec::par_unseq, data, lines, {.depth = 22_mm, .samples = 880},
                                       {.fnumber = fnumber, .window = window});
        std::vector<float> across;
        for (std::uint32_t i = 0; i < lines.lines; ++i) across.push_back(length(made(i, 719)));
        double half = 0, null = 0, expected_lobe = 0, lobe = 0;
        while (transform(window, half) > 0.5) half += 1e-3;
        for (null = half; transform(window, null) > 0;) null += 1e-3;
        const double unit = 1540 / 7.6e6 * static_cast<double>(fnumber), largest = static_cast<double>(across[150]);
        for (double u = null; u * unit < 2.9e-3; u += 1e-2)
            expected_lobe = std::max(expected_lobe, std::fabs(transform(window, u)));
        for (std::uint32_t i = 0; i < lines.lines; ++i)
            if (std::fabs(0.02e-3 * (static_cast<double>(i) - 150)) > null * unit)
                lobe = std::max(lobe, static_cast<double>(across[i]) / largest);
        MESSAGE("window ", static_cast<int>(window), ": ", width_of(across) * 0.02, " mm wide, expected ",
                2e3 * half * unit, "; side lobes ", 20 * std::log10(lobe), " dB, expected ",
                20 * std::log10(expected_lobe));
        CHECK(width_of(across) * 0.02e-3 == doctest::Approx(2 * half * unit).scale(1e-30).epsilon(0.03));
        CHECK(20 * std::log10(lobe / expected_lobe) == doctest::Approx(0).scale(1).epsilon(1.5));
    }
}

TEST_CASE("beamform: another sound speed moves a point to its travel time times that speed") {
    const element_array array{.elements = 48};
    const scene body = scene{uniform_1540}.build(exec::par);
    const std::vector<point_scatterer> points{{{1_mm, 0, 18_mm}, 1e-3F}};
    const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{}, plane_waves(array, 1, 0),
                                             {.depth = 24_mm, .points = points});
    const linear_array lines{.lines = 61, .width = 6.1_mm, .frequency = array.frequency};
    for (const float speed : {0.0F, 1450.0F, 1500.0F, 1620.0F}) {
        const vec2 found = brightest_point(
            envelope(exec::par_unseq, beamform(exec::par_unseq, data, lines, {.depth = 22_mm, .samples = 4400},
                                               {.fnumber = 6, .sound_speed = speed})),
            lines);
        const double expected = 18e-3 * static_cast<double>(speed == 0 ? 1540 : speed) / 1540;
        CHECK(static_cast<double>(found.y) == doctest::Approx(expected).scale(1e-30).epsilon(0.002));
        CHECK(static_cast<double>(found.x) == doctest::Approx(1e-3).scale(1e-30).epsilon(0.11));
    }
}

TEST_CASE("beamform: behind a layer that is slower, points are displayed as much deeper as its time is longer") {
    constexpr float speed = 1450;
    scene body{medium{.density = 1000, .sound_speed = speed}};
    body.add(make_box({-60_mm, -60_mm, 10_mm}, {60_mm, 60_mm, 60_mm}, 1), uniform_1540);
    body.build(exec::par);
    const element_array array{.elements = 64};
    const linear_array lines{.lines = 41, .width = 8.2_mm, .frequency = array.frequency};
    for (const vec3 place : {vec3{0, 0, 20_mm}, vec3{3_mm, 0, 25_mm}}) {
        const std::vector<point_scatterer> points{{place, 1e-3F}};
        const channel_data data =
            trace_channels(exec::par_unseq, body, array, pose{}, physical{}, plane_waves(array, 1, 0),
                           {.depth = 28_mm, .surfaces = false, .points = points});
        const vec2 found =
            brightest_point(envelope(exec::par_unseq, beamform(exec::par_unseq, data, lines,
                                                               {.depth = 28_mm, .samples = 5600}, {.fnumber = 2})),
                            lines);
        const double deeper = 10e-3 * (1540.0 / static_cast<double>(speed) - 1); // 0.62 mm
        CHECK(static_cast<double>(found.y - place.z) == doctest::Approx(deeper).scale(1e-30).epsilon(0.02 / 0.62));
        CHECK(std::fabs(found.x - place.x) < 0.11_mm);
    }
}

TEST_CASE("beamform: speckle of tissues has the level of b_mode") {
    const element_array array{.elements = 32, .height = 3_mm, .elevation_focus = 10_mm};
    const linear_array lines{.lines = 64,
                             .width = 4.8_mm,
                             .frequency = 7.6_MHz,
                             .focus = 10_mm,
                             .elevation_height = 3_mm,
                             .elevation_focus = 10_mm,
                             .bandwidth = 0.77F};
    const acquisition grid{.depth = 12_mm, .samples = 768, .planes = 5};
    medium lossless = tissue::soft_tissue;
    lossless.attenuation = 0;
    for (medium one : {lossless, tissue::liver, tissue::muscle, tissue::fat}) {
        one.structure = {};
        const scene body = scene{one}.build(exec::par);
        const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                                 full_synthetic_aperture(array), {.depth = 12.5_mm, .opening = 10_deg});
        // Focused by the speed of the tissue, at the depths that b_mode shows by 1540 m/s.
        const float longer = one.sound_speed / 1540;
        const double channels =
            speckle_of(beamform(exec::par_unseq, data, lines, grid, {.fnumber = 2, .sound_speed = one.sound_speed}),
                       8.5_mm * longer, 11.5_mm * longer, 4.8_mm / 64)
                .level_db;
        const double picture =
            speckle_of(convolve(exec::par_unseq, trace(exec::par_unseq, body, lines, pose{}, physical{}, grid),
                                nominal_pulse(lines), lines),
                       8.5_mm, 11.5_mm, 4.8_mm / 64)
                .level_db;
        MESSAGE("sound speed ", one.sound_speed, " m/s: ", channels, " dB, b_mode ", picture, " dB");
        CHECK(std::fabs(channels - picture) < 1);
    }
}

TEST_CASE("beamform: a lens that focuses far beyond what is recorded, or none, does not brighten speckle") {
    const scene body = scene{medium{.density = 1000, .sound_speed = 1540, .backscatter = 1}}.build(exec::par);
    const linear_array lines{.lines = 64, .width = 4.8_mm, .frequency = 7.6_MHz};
    const auto level_db = [&](float focus) {
        const element_array array{.elements = 32, .height = 3_mm, .elevation_focus = focus};
        const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                                 full_synthetic_aperture(array), {.depth = 12.5_mm, .opening = 10_deg});
        return speckle_of(beamform(exec::par_unseq, data, lines, {.depth = 12_mm, .samples = 768}, {.fnumber = 2}),
                          8.5_mm, 11.5_mm, 4.8_mm / 64)
            .level_db;
    };
    const double focused = level_db(10_mm), far = level_db(1), none = level_db(10);
    MESSAGE("10 mm: ", focused, " dB, 1 m: ", far, " dB, 10 m: ", none, " dB");
    CHECK(std::fabs(none - far) < 0.5);
    CHECK(std::fabs(far - focused) < 6);
}

TEST_CASE("beamform: channel data of other recorders may leave out what is unknown, and must be finite") {
    const element_array array{.elements = 4, .pitch = 0.3_mm};
    channel_data own{.transmits = 1,
                     .elements = 4,
                     .samples = 400,
                     .sampling_frequency = 20_MHz,
                     .frequency = 5_MHz,
                     .pitch = 0.3_mm,
                     .sent = plane_waves(array, 1, 0),
                     .values = std::vector<float>(1600, 0.1F)};
    for (std::uint32_t i = 0; i < 4; ++i) own.places.push_back(array.element(i));
    const linear_array lines{.lines = 2, .width = 1_mm};
    for (const vec2 value : beamform(exec::seq, own, lines, {.depth = 10_mm}).values)
        CHECK(is_finite(value.x + value.y));
    const auto refuses = [&](auto&& change) {
        channel_data changed = own;
        change(changed);
        CHECK_THROWS_AS(beamform(exec::seq, changed, lines, {.depth = 10_mm}), usage_error);
    };
    refuses([](channel_data& d) { d.sound_speed = 0; });
    channel_data unknown = own;
    unknown.sound_speed = 0;
    CHECK(beamform(exec::seq, unknown, lines, {.depth = 10_mm}, {.sound_speed = 1540}).values.size() > 0);
    refuses([](channel_data& d) { d.sound_speed = std::nanf(""); });
    refuses([](channel_data& d) { d.pitch = std::nanf(""); });
    refuses([](channel_data& d) { d.element_width = -1; });
    refuses([](channel_data& d) { d.sent[0].angle = std::nanf(""); });
    refuses([](channel_data& d) { d.sent[0].source.z = std::nanf(""); });
    refuses([](channel_data& d) { d.places[2].origin.x = std::nanf(""); });
    CHECK_THROWS_AS(beamform(exec::seq, own, lines, {.depth = 10_mm, .samples = 1U << 31U}), usage_error);
}

TEST_CASE("beamform: what does not fit is named") {
    const linear_array lines{};
    CHECK_THROWS_AS(beamform(exec::seq, channel_data{}, lines, {}), usage_error);
    const element_array array{.elements = 4};
    const scene body = scene{uniform_1540}.build(exec::seq);
    channel_data data =
        trace_channels(exec::seq, body, array, pose{}, physical{}, plane_waves(array, 1, 0), {.depth = 5_mm});
    CHECK_THROWS_AS(beamform(exec::seq, data, lines, {}, {.fnumber = 0}), usage_error);
    CHECK_THROWS_AS(beamform(exec::seq, data, lines, {}, {.sound_speed = 1.54F}), usage_error);
    CHECK_THROWS_AS(beamform(exec::seq, data, lines, {.depth = 40}), usage_error);
    data.values.pop_back();
    CHECK_THROWS_AS(beamform(exec::seq, data, lines, {}), usage_error);
    CHECK_THROWS_AS(demodulate(exec::seq, data), usage_error);
}

} // namespace beamform_test
