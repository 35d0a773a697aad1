#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>

using namespace insonify;

/// A needle in the slice of a linear array, as it is inserted at 0 to 45 degrees to the face.
namespace needle_visibility_test {
namespace {

constexpr double frequency = 7.5e6, depth = 20e-3, fnumber = 2, speed = 1580;
const linear_array probe{
    .lines = 256, .width = 38_mm, .frequency = static_cast<float>(frequency), .focus = static_cast<float>(depth)};

double decibels(double power) { return 10 * std::log10(power); }
double number(float value) { return static_cast<double>(value); }

/// Muscle without scatterers and without loss.
medium silent() {
    medium plain = tissue::muscle;
    plain.backscatter = plain.attenuation = 0;
    plain.structure = structure{};
    return plain;
}

/// A needle whose shaft passes the point {0, 0, 20 mm} at `tilt` to the face; its tip is `ahead` of it along the shaft. The bevel
/// faces the probe, or away from it.
scene needle_in(const medium& around, std::uint32_t gauge, float tilt, float ahead, bool faces_probe = true) {
    const vec3 along{std::cos(tilt), 0, std::sin(tilt)}, up{std::sin(tilt), 0, -std::cos(tilt)};
    const float radius = needle_diameter(gauge) / 2;
    const vec3 tip = vec3{0, 0, 20_mm} - radius * up + ahead * along; // the upper side of the shaft passes the point
    scene body{around};
    body.add(make_needle(needle_diameter(gauge), 80_mm), tissue::steel,
             {.priority = 1, .at = look_at(tip, tip + along, faces_probe ? up : -up), .crease_angle = 12_deg});
    return std::move(body).build(exec::par);
}

/// Mean power at the shaft, on the lines that meet it within `extent` of x = 0.
double shaft_power(const scene& body, float steering, float tilt, float extent, std::uint32_t seed = 1) {
    const steered look{probe, steering};
    const iq_lines echoes =
        trace(exec::par_unseq, body, look, pose{}, physical<>{.seed = seed}, {.depth = 45_mm, .samples = 3072});
    const scan_lines seen = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, pulse{}, look));
    double sum = 0, count = 0;
    for (std::uint32_t i = 0; i < seen.count; ++i) {
        const ray line = look.beam(static_cast<float>(i));
        const float slope = std::tan(tilt);
        const float length = (20_mm + line.origin.x * slope) / (line.direction.z - line.direction.x * slope);
        if (std::fabs(line.at(length).x) > extent) continue;
        const auto sample = static_cast<std::uint32_t>(number(length) * 1540 / speed / 45e-3 * 3072);
        sum += std::pow(number(seen(i, sample)), 2);
        ++count;
    }
    return sum / count;
}

/// Echo of a plane mirror through the point in the focus, by the image of each transmitting element, received by each of the
/// others; turned by `angle` against the direction of the line. The envelope of the pulse is Gaussian.
double image_source_echo(double steering, double angle) {
    constexpr int elements = 64;
    const double line = depth / std::cos(steering), width = line / fnumber,
                 wave_number = 2 * 3.14159265358979 * frequency / speed;
    const double sigma = 0.1874 * 1540 / (0.644 * frequency);                             // of the envelope along depth
    const double normal = steering + angle, nx = std::sin(normal), nz = std::cos(normal); // of the mirror
    const double from_x = -depth * std::tan(steering);                                    // of the line, on the face
    const auto place = [&](int i) { return from_x + width * ((i + 0.5) / elements - 0.5); };
    double largest = 0;
    for (double shift = -1e-3; shift <= 1e-3; shift += 3e-5) {
        std::complex<double> sum = 0;
        for (int i = 0; i < elements; ++i) {
            const double x = place(i), away = -x * nx + depth * nz; // from the mirror
            const double image_x = x + 2 * away * nx, image_z = 2 * away * nz;
            for (int j = 0; j < elements; ++j) {
                const double y = place(j);
                const double late =
                    (std::hypot(image_x - y, image_z) - std::hypot(x, depth) - std::hypot(y, depth)) / 2;
                const double u = (late - shift) / sigma;
                sum += std::polar(std::exp(-0.5 * u * u), -2 * wave_number * late);
            }
        }
        largest = std::max(largest, std::abs(sum));
    }
    return largest;
}

/// Reflected energy of muscle against steel as fluids; cosine of the angle of incidence.
double reflected(double cosine) {
    const double z1 = 1e-6 * number(tissue::muscle.impedance()), z2 = 1e-6 * number(tissue::steel.impedance());
    const double sine = number(tissue::steel.sound_speed) / speed * std::sqrt(1 - cosine * cosine);
    if (sine >= 1) return 1;
    const double other = std::sqrt(1 - sine * sine), r = (z2 * cosine - z1 * other) / (z2 * cosine + z1 * other);
    return r * r;
}

/// Power of the diffuse echo of a plane of steel, rms height 2 um: what the aperture receives of Lambert's lobe. A steep plane
/// crosses the beam over more depth than the pulse has.
double diffuse(double angle) {
    const double cosine = std::cos(angle),
                 phase = 4 * 3.14159265358979 * frequency / speed * number(tissue::steel.roughness) * cosine;
    const double beam = number(beam_of(probe, 45_mm).lateral_sigma(20_mm)),
                 pulse_sigma = 0.1874 * 1540 / (0.644 * frequency);
    const double spread = std::hypot(1.0, beam * std::tan(angle) / pulse_sigma);
    return reflected(cosine) * -std::expm1(-phase * phase) * cosine * cosine * 0.166 / (fnumber * 4) / spread;
}

/// Loss of power by the curvature of a cylinder out of the slice.
double curvature(std::uint32_t gauge) {
    const double sigma = number(beam_of(probe, 45_mm).elevation_sigma(20_mm));
    const double q = 4 * 3.14159265358979 * frequency / speed * sigma * sigma / (number(needle_diameter(gauge)) / 2);
    return 1 / std::sqrt(1 + q * q);
}

} // namespace
} // namespace needle_visibility_test

TEST_CASE("a needle's echo falls with its angle to the beam as an array of that aperture receives it, steered or not, "
          "and ends at "
          "its diffuse echo") {
    using namespace needle_visibility_test;
    for (const float steering : {0_deg, 15_deg}) {
        const double facing = image_source_echo(number(steering), 0);
        for (const float tilt : {0_deg, 5_deg, 10_deg, 15_deg, 20_deg, 30_deg, 45_deg}) {
            const double angle = number(tilt - steering);
            const double lobe = std::pow(image_source_echo(number(steering), -angle) / facing, 2),
                         scattered = diffuse(angle);
            for (const std::uint32_t gauge : {18U, 20U, 22U, 25U}) {
                const scene body = needle_in(silent(), gauge, tilt, 30_mm);
                const double mirror = reflected(std::cos(angle)) * lobe * curvature(gauge);
                const std::uint32_t seeds = mirror > 30 * scattered ? 1 : 6; // of the diffuse echo
                double found = 0;
                for (std::uint32_t seed = 1; seed <= seeds; ++seed)
                    found += shaft_power(body, -steering, tilt, 4_mm, seed) / seeds;
                MESSAGE(gauge, " gauge at ", tilt / 1_deg, " degrees, steered by ", steering / 1_deg, ": ",
                        decibels(found), " dB, expected ", decibels(mirror + scattered), " (mirror ", decibels(mirror),
                        ", diffuse ", decibels(scattered), ")");
                CHECK(std::fabs(decibels(found / (mirror + scattered))) < 1.5);
            }
        }
    }
}

TEST_CASE("a needle in muscle is seen where it is flat, less where it is thin, and hardly where it is steep; a steered "
          "beam brings "
          "it back") {
    using namespace needle_visibility_test;
    // Published: visibility falls with the angle and with smaller diameters (Schafhalter-Zoppoth, McCulloch & Gray, Regional
    // Anesthesia & Pain Medicine 2004: 17 to 22 gauge, 0 to 65 degrees); it is good at 0 degrees and less for all of twelve needles
    // at 45 degrees (Maecken, Zenz & Grau, ibid. 2007).
    const scene muscle = scene{tissue::muscle}.build(exec::par);
    const iq_lines all = convolve(
        exec::par_unseq,
        trace(exec::par_unseq, muscle, probe, pose{}, physical<>{}, {.depth = 45_mm, .samples = 3072, .planes = 5}),
        pulse{}, probe);
    double level = 0, count = 0; // of muscle, 15 to 25 mm deep
    for (std::uint32_t i = 0; i < all.count; ++i)
        for (std::uint32_t k = 1024; k < 1706; ++k, ++count) level += number(dot(all(i, k), all(i, k)));
    level /= count;
    const auto contrast = [&](std::uint32_t gauge, float tilt, float steering) {
        return decibels(shaft_power(needle_in(tissue::muscle, gauge, tilt, 30_mm), -steering, tilt, 5_mm) / level);
    };
    const float tilts[] = {0_deg, 10_deg, 20_deg, 30_deg, 45_deg};
    for (const std::uint32_t gauge : {18U, 20U, 22U, 25U}) {
        double straight[5];
        for (int i = 0; i < 5; ++i) {
            straight[i] = contrast(gauge, tilts[i], 0);
            MESSAGE(gauge, " gauge at ", tilts[i] / 1_deg, " degrees: ", straight[i], " dB above muscle");
            if (i > 0) CHECK(straight[i] < straight[i - 1] + 2);
        }
        CHECK(straight[0] > 25);
        CHECK(straight[0] - straight[4] > 25);
        const double steered_back = contrast(gauge, 20_deg, 15_deg);
        MESSAGE(gauge, " gauge at 20 degrees, steered by 15: ", steered_back, " dB above muscle");
        CHECK(steered_back > straight[2] + 10);
    }
    CHECK(contrast(18, 0, 0) > contrast(20, 0, 0));
    CHECK(contrast(20, 0, 0) > contrast(22, 0, 0));
    CHECK(contrast(22, 0, 0) > contrast(25, 0, 0));
}

TEST_CASE("the bevel of a needle glints where it faces the beam, while the shaft is dark") {
    using namespace needle_visibility_test;
    // A bevel of 15 degrees that faces the probe is 15 degrees steeper than the shaft: a beam from ahead of the tip meets it.
    constexpr float tilt = 22_deg, bevel = 15_deg;
    const steered look{probe, -(tilt + bevel)};
    const auto brightest = [&](bool faces_probe, float from, float to) { // along the shaft, metres behind the tip
        const scene body = needle_in(silent(), 20, tilt, 0, faces_probe);
        const iq_lines echoes =
            trace(exec::par_unseq, body, look, pose{}, physical<>{}, {.depth = 45_mm, .samples = 3072});
        const scan_lines seen = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, pulse{}, look));
        float largest = 0;
        for (float behind = from; behind < to; behind += 0.05_mm)
            for (float below = -0.3_mm; below < 1.3_mm; below += 0.05_mm) {
                const vec2 at = look.locate({-behind * std::cos(tilt), 20_mm - behind * std::sin(tilt) + below});
                const auto line = static_cast<std::uint32_t>(std::lround(at.x)),
                           sample = static_cast<std::uint32_t>(number(at.y) * 1540 / speed / 45e-3 * 3072);
                largest = std::max(largest, seen(line, sample));
            }
        return 2 * decibels(number(largest));
    };
    const double glint = brightest(true, 0.3_mm, 3_mm), shaft = brightest(true, 6_mm, 14_mm),
                 turned = brightest(false, 0.3_mm, 3_mm);
    MESSAGE("bevel ", glint, " dB (a mirror: ", decibels(reflected(1)), "), shaft ", shaft, " dB, bevel turned away ",
            turned, " dB");
    CHECK(glint > shaft + 10);
    CHECK(glint > turned + 10);
    CHECK(glint < decibels(reflected(1)) + 0.5);
}
