#include <insonify/acoustics/scatterers/cell_field.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace structure_test {
namespace {

constexpr float fnumber = 3;

// The factor on amplitude at steps of 0.1 mm along a line in the material.
std::vector<float> gains_along(const placed_structure& tissue, vec3 origin, vec3 along, std::uint32_t count = 400,
                               std::uint32_t key = 7) {
    std::vector<float> real(count + max_simd_width, 1.0F), imaginary = real;
    detail::structure_gains gains{tissue, {origin, along, along, fnumber, key, 0.1_mm * static_cast<float>(count)}};
    gains.multiply(0, 0.1_mm, count, real.data(), imaginary.data());
    real.resize(count);
    return real;
}

// Mean power of the factor in dB relative to `rms`, over 2500 lines of 40 mm, each in an object of its own, at
// an angle to the z axis, towards the fibres.
double level(const structure& s, float angle) {
    const placed_structure tissue{s, mat3{1}};
    const vec3 along{std::sin(angle), 0, std::cos(angle)};
    double power = 0, count = 0;
    for (std::uint32_t i = 0; i < 2500; ++i) {
        const vec3 origin{1.43_mm * static_cast<float>(i % 50), 1.37_mm * static_cast<float>(i / 50), 0};
        for (const float gain : gains_along(tissue, origin, along, 400, i)) {
            power += static_cast<double>(gain) * static_cast<double>(gain);
            ++count;
        }
    }
    const auto rms = static_cast<double>(tissue.rms(fnumber));
    return 10 * std::log10(power / count / (rms * rms));
}

} // namespace
} // namespace structure_test

TEST_CASE("structure: the mean echo power of every tissue is unchanged by its structure, within 0.5 dB") {
    for (const tissue::named_medium& each : tissue::all) {
        if (each.value.structure.empty()) continue;
        const double change = structure_test::level(each.value.structure, 0);
        MESSAGE(std::string{each.name} << ": mean power " << change << " dB, expected 0");
        CHECK(std::fabs(change) < 0.5);
    }
}

TEST_CASE("structure: tendon loses 6 to 20 dB within a few degrees of tilt, muscle little") {
    // Crass, van de Vegte & Harkavy, Radiology 1988: tendon loses its echoes at 2 to 7 degrees.
    double before = 0;
    for (const float degrees : {0.0F, 2.0F, 5.0F, 7.0F, 10.0F, 20.0F}) {
        const double tendon = structure_test::level(tissue::tendon.structure, degrees * pi / 180),
                     muscle = structure_test::level(tissue::muscle.structure, degrees * pi / 180);
        MESSAGE(degrees << " degrees: tendon " << tendon << " dB, muscle " << muscle << " dB");
        CHECK(tendon < before + 0.3);
        CHECK(muscle > -6);
        if (degrees == 7) CHECK((tendon < -6 && tendon > -20));
        before = tendon;
    }
    CHECK(before < -10);
}

TEST_CASE("structure: lines in opposite directions through the same points see the same sheets") {
    const placed_structure tissue{tissue::muscle.structure, mat3{1}};
    const std::vector<float> forth = structure_test::gains_along(tissue, {3_mm, 5_mm, 0}, {0, 0, 1}, 401);
    const std::vector<float> back = structure_test::gains_along(tissue, {3_mm, 5_mm, 40_mm}, {0, 0, -1}, 401);
    for (std::size_t i = 0; i < 401; ++i) { // slow variation is interpolated between other points
        CHECK(std::fabs(forth[i] - back[400 - i]) < 0.05F * forth[i]);
    }
}

TEST_CASE("structure: bent sheets are arcs that are bright where they face the beam, and keep the power") {
    constexpr float bend = 0.5F, width = 10_mm, step = 0.2_mm;
    const auto layer = [&](float turn, float bent, float waviness) {
        return structure{.sheets = {.fill = 1,
                                    .cell = {0.5F, width, 10_mm},
                                    .level_db = 40,
                                    .spread_db = 0,
                                    .turn = turn,
                                    .bend = bent,
                                    .tilt = 0,
                                    .waviness = waviness,
                                    .diffuse_db = -40}};
    };
    constexpr struct {
        float turn, bend, waviness;
    } cases[] = {{0, 0.5F, 0.5F}, {0.8F, 0.5F, 0.3F}, {0.8F, 0.5F, 0}, {0.8F, 1, 0}};
    for (const auto& each : cases) {
        const double change = structure_test::level(layer(each.turn, each.bend, each.waviness), 0);
        MESSAGE("turn ", each.turn, ", bend ", each.bend, ", waviness ", each.waviness, ": mean power ", change, " dB");
        CHECK(std::fabs(change) < (each.bend < 1 ? 0.6 : 2.0)); // at 1 the edges of wide sheets leave their cells
    }
    // Depth of the brightest point of a line and its gain, or 0 where no sheet is.
    struct ridge {
        float depth = 0, gain = 0;
    };
    const auto ridge_at = [&](const placed_structure& tissue, float y) -> ridge {
        const std::vector<float> gains = structure_test::gains_along(tissue, {1_mm, y, 0}, {0, 0, 1}, 100);
        const auto k = static_cast<std::size_t>(std::max_element(gains.begin(), gains.end()) - gains.begin());
        if (k == 0 || k + 1 == gains.size() || gains[k] < 2) return {};
        const float before = std::log(gains[k - 1]), here = std::log(gains[k]), behind = std::log(gains[k + 1]);
        const float within = 0.5F * (before - behind) / (before - 2 * here + behind);
        return {0.1_mm * (static_cast<float>(k) + within), gains[k]};
    };
    // Calls visit(slope, curvature, gain) for neighbours within one sheet.
    const auto for_each_ridge = [&](const structure& of, const auto& visit) {
        const placed_structure tissue{of, mat3{1}};
        for (int i = 0; i < 2000; ++i) {
            const float y = step * static_cast<float>(i), apart = 3 * step;
            const ridge a = ridge_at(tissue, y - apart), b = ridge_at(tissue, y), c = ridge_at(tissue, y + apart);
            if (a.gain == 0 || b.gain == 0 || c.gain == 0) continue;
            if (std::fabs(a.depth - b.depth) > 0.5_mm || std::fabs(c.depth - b.depth) > 0.5_mm) continue;
            visit((c.depth - a.depth) / (2 * apart), (a.depth - 2 * b.depth + c.depth) / (apart * apart), b.gain);
        }
    };
    // Each sheet has one curvature, up to bend / half width.
    float smallest = 0, largest = 0;
    int points = 0;
    for_each_ridge(layer(0, bend, 0.5F), [&](float, float curvature, float) {
        smallest = std::fmin(smallest, curvature);
        largest = std::fmax(largest, curvature);
        ++points;
    });
    const float limit = bend / (0.6F * 0.4F * width); // of the narrowest sheet
    MESSAGE(points, " points, curvatures ", smallest, " to ", largest, " 1/m, limit ", limit);
    CHECK(points > 500);
    CHECK(smallest < -0.4F * limit);
    CHECK(largest > 0.4F * limit);
    CHECK(std::fmax(-smallest, largest) < 1.1F * limit);
    // The echo follows the slope of the arc, whichever way the sheet is turned.
    float flat = 0, steep = 0, flat_points = 0, steep_points = 0;
    for_each_ridge(layer(0.4F, bend, 0.1F), [&](float slope, float, float gain) {
        const float size = std::fabs(slope);
        if (size < 0.1F) flat += gain, ++flat_points;
        if (size > 0.3F && size < 0.5F) steep += gain, ++steep_points;
    });
    MESSAGE("gain of ", flat_points, " flat points ", flat / flat_points, ", of ", steep_points, " steep ones ",
            steep / steep_points);
    CHECK(steep_points > 20);
    CHECK(flat / flat_points > 4 * steep / steep_points);
    for (const float refused : {-0.1F, 1.1F, NAN}) CHECK_FALSE(is_valid(layer(0, refused, 0.5F)));
}

TEST_CASE("structure: along the fibres brightness persists for millimetres, across them it does not") {
    const placed_structure tissue{tissue::muscle.structure, mat3{1}};
    const auto correlation = [&](vec3 apart) {
        double product = 0, square = 0, sum = 0, count = 0;
        for (int i = 0; i < 600; ++i) {
            const vec3 origin{3.1_mm * static_cast<float>(i % 30), 2.7_mm * static_cast<float>(i / 30), 0};
            const auto a = structure_test::gains_along(tissue, origin, {0, 0, 1}),
                       b = structure_test::gains_along(tissue, origin + apart, {0, 0, 1});
            for (std::size_t k = 0; k < a.size(); ++k) {
                const auto x = static_cast<double>(std::log(a[k])), y = static_cast<double>(std::log(b[k]));
                product += x * y;
                square += 0.5 * (x * x + y * y);
                sum += 0.5 * (x + y);
                ++count;
            }
        }
        const double mean = sum / count;
        return (product / count - mean * mean) / (square / count - mean * mean);
    };
    const double lengthwise = correlation({3_mm, 0, 0}), crosswise = correlation({0, 3_mm, 0});
    MESSAGE("3 mm apart: along the fibres " << lengthwise << ", across " << crosswise);
    CHECK(lengthwise > 0.4);
    CHECK(crosswise < 0.3);
}

TEST_CASE("structure: multiplies the scatterers of the field by its gains, and moves none") {
    const gaussian_field field{};
    const placed_structure muscle{tissue::muscle.structure, mat3{1}};
    material_line line{.origin = {0.3_mm, 0.2_mm, 0}, .fnumber = structure_test::fnumber};
    struct scatterer {
        float distance, amplitude;
    };
    const auto along = [&] {
        std::vector<scatterer> all;
        field.scatter(line, 0, 20_mm, 25_um, [&](const scatterer_run& run) {
            for (std::uint32_t i = 0; i < run.count; ++i)
                all.push_back({run.first + static_cast<float>(i) * run.step, run.real[i]});
        });
        return all;
    };
    const std::vector<scatterer> plain = along();
    line.structure = &muscle;
    const std::vector<scatterer> structured = along();
    REQUIRE(plain.size() == structured.size());
    const auto gain_at = [&](float distance) { // a point of its own, without interpolation
        float gain[1 + max_simd_width];
        const detail::structure_gains gains{
            muscle, {line.origin, {0, 0, 1}, {0, 0, 1}, structure_test::fnumber, mix_bits(field.seed + line.object)}};
        gains.compute({distance, 0.1_mm, 1, gain});
        return gain[0];
    };
    double difference = 0, power = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
        CHECK(plain[i].distance == structured[i].distance);
        const float expected = plain[i].amplitude * gain_at(plain[i].distance);
        difference += static_cast<double>((structured[i].amplitude - expected) * (structured[i].amplitude - expected));
        power += static_cast<double>(expected * expected);
    }
    MESSAGE("rms difference to the gain at each scatterer: " << std::sqrt(difference / power));
    CHECK(difference < 0.2 * 0.2 * power); // gains are interpolated over 0.1 mm; some sheets end more abruptly
    CHECK(structure{}.empty());
    CHECK(tissue::bone.structure.empty());
    CHECK(tissue::blood.structure.empty());
}

TEST_CASE("structure: values out of range make a medium invalid") {
    CHECK(is_valid(tissue::muscle));
    for (const auto& spoil : std::vector<void (*)(structure&)>{
             [](structure& s) { s.sheets.fill = 1.5F; }, [](structure& s) { s.sheets.lattices = 7; },
             [](structure& s) { s.sheets.cell.x = 0; }, [](structure& s) { s.mottling.deviation_db = NAN; },
             [](structure& s) { s.wave_length = 0; },
             [](structure& s) {
                 s.bundles = {1_mm, 2_mm, -6};
             }}) {
        medium m = tissue::muscle;
        spoil(m.structure);
        CHECK_FALSE(is_valid(m));
    }
}

TEST_CASE("structure: a sheath lies below the surface, 0.7 to 1.5 mm thick, and fades where it turns from the beam") {
    const structure::sheath_layer sheath{.thickness = 1_mm};
    // Mean gain in dB at steps of 0.1 mm below a surface at 2 mm.
    const auto profile = [&](float cosine) {
        std::vector<double> power(80);
        for (std::uint32_t key = 0; key < 400; ++key) {
            std::vector<float> real(80, 1.0F), imaginary(80, 1.0F);
            const detail::object_segment segment{{0.3_mm, 0.2_mm, 0},     {0, 0, 1}, {0, 0, 1},
                                                 structure_test::fnumber, key,       8_mm};
            detail::sheath_gains{sheath, segment, 2_mm, cosine, 1}.multiply(0, 0.1_mm, 80, real.data(),
                                                                            imaginary.data());
            for (std::size_t i = 0; i < power.size(); ++i)
                power[i] += static_cast<double>(real[i]) * static_cast<double>(real[i]) / 400;
        }
        for (double& each : power) each = 10 * std::log10(each);
        return power;
    };
    const std::vector<double> below = profile(1);
    CHECK(std::fabs(below[10]) < 1e-6);
    CHECK(below[21] > 15);            // the first line
    CHECK(below[25] < below[21] - 6); // the slit
    CHECK(below[28] > below[25] + 3); // the second line
    CHECK(std::fabs(below[45]) < 1);  // deeper than 2.5 mm
    const std::vector<double> tilted = profile(0.866F);
    MESSAGE("first line " << below[21] << " dB, slit " << below[25] << ", second " << below[28]
                          << ", tilted by 30 degrees " << tilted[21]);
    // The lobe at 30 degrees: widths of the aperture at F/3 and of the facets, and what remains at any angle.
    const double lobe = std::sin(std::hypot(0.53 * std::atan(1.0 / 6), 1.1774 * 0.3)), remains = std::pow(10, -0.5);
    const double echo = remains + (1 - remains) * std::exp2(-0.25 / (lobe * lobe));
    MESSAGE("loss by the tilt: " << below[21] - tilted[21] << " dB, expected about " << -20 * std::log10(echo));
    CHECK(std::fabs(below[21] - tilted[21] + 20 * std::log10(echo)) < 1);
}

TEST_CASE("structure: the scatterer whose slot a surface cuts is in the sheath, wherever it stands in a register") {
    const structure::sheath_layer sheath{.thickness = 1_mm};
    const float surface = 3.27_mm; // in the slot around 3.3 mm
    const auto gain_of_last = [&](std::uint32_t count) {
        std::vector<float> real(64, 1.0F), imaginary(64, 1.0F);
        const detail::object_segment segment{{0, 0, 0}, {0, 0, 1}, {0, 0, 1}, structure_test::fnumber, 5, surface};
        detail::sheath_gains{sheath, segment, surface, -1, 1}.multiply(3.3_mm - 0.1_mm * static_cast<float>(count - 1),
                                                                       0.1_mm, count, real.data(), imaginary.data());
        return real[count - 1];
    };
    const float alone = gain_of_last(1);
    CHECK(alone > 1.5F);
    for (std::uint32_t count = 2; count <= 33; ++count)
        CHECK(gain_of_last(count) == doctest::Approx(alone).scale(1e-30).epsilon(1e-3));
}
