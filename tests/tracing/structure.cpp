#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

/// What the structure of tissue does to echoes: along and across the fibres, when objects, probes and tissue move.
namespace structure_in_echoes_test {
namespace {

constexpr linear_array probe{.lines = 128, .width = 30_mm, .frequency = 7.5_MHz};
constexpr acquisition scan{.depth = 40_mm, .samples = 1344};

scene muscle_box(const pose& at = {}) {
    scene body{medium{.density = 1075, .sound_speed = 1580, .attenuation = 100}};
    body.add(make_box({-60_mm, -60_mm, -10_mm}, {60_mm, 60_mm, 60_mm}), tissue::muscle,
             {.at = at, .fibres = {1, 0, 0}});
    body.build(exec::par);
    return body;
}

iq_lines echoes_of(const scene& body, const pose& at) {
    return trace(exec::par_unseq, body, probe, at, physical{}, scan);
}

/// Mean decibels in blocks of 1 mm along the lines and three lines: what is larger than a resolution cell.
std::vector<double> levels(const iq_lines& lines) {
    constexpr std::uint32_t across = 3, along = 34;
    std::vector<double> found;
    for (std::uint32_t i = 0; i + across <= lines.count; i += across)
        for (std::uint32_t k = 0; k + along <= lines.samples; k += along) {
            double power = 0;
            for (std::uint32_t a = 0; a < across; ++a)
                for (std::uint32_t b = 0; b < along; ++b)
                    power += static_cast<double>(dot(lines(i + a, k + b), lines(i + a, k + b)));
            found.push_back(10 * std::log10(power));
        }
    return found;
}

/// Mean echo power in a slab of muscle at 20 mm, its fibres parallel to its surfaces, over the middle lines, dB.
/// @param from, to  depths in the slab, metres
/// @param places    of the material that are drawn
double power_in_slab(const structure& of, float thickness, float from, float to, std::uint32_t places) {
    medium muscle = tissue::muscle; // as deep as displayed
    muscle.sound_speed = 1540;
    muscle.attenuation = muscle.roughness = 0;
    muscle.structure = of;
    double sum = 0, count = 0;
    for (std::uint32_t i = 0; i < places; ++i) {
        scene body{medium{.density = muscle.density, .sound_speed = muscle.sound_speed}};
        const vec3 other_tissue = static_cast<float>(i) * vec3{31_mm, 7_mm, 5_mm};
        body.add(make_box(other_tissue + vec3{-60_mm, -60_mm, 0}, other_tissue + vec3{60_mm, 60_mm, thickness}), muscle,
                 {.at = {.translation = vec3{0, 0, 20_mm} - other_tissue}, .fibres = {1, 0, 0}});
        const iq_lines echoes = echoes_of(body.build(exec::par), pose{});
        const float per_sample = scan.depth / static_cast<float>(scan.samples);
        const auto first = static_cast<std::uint32_t>((20_mm + from) / per_sample),
                   last = static_cast<std::uint32_t>((20_mm + to) / per_sample);
        for (std::uint32_t line = 4; line < probe.lines; line += 4)
            for (std::uint32_t k = first; k < last; ++k, ++count)
                sum += static_cast<double>(dot(echoes(line, k), echoes(line, k)));
    }
    return 10 * std::log10(sum / count);
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    double x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    const auto n = static_cast<double>(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        x += a[i], y += b[i], xx += a[i] * a[i], yy += b[i] * b[i], xy += a[i] * b[i];
    }
    return (xy / n - x * y / n / n) / std::sqrt((xx / n - x * x / n / n) * (yy / n - y * y / n / n));
}

} // namespace

TEST_CASE("structure follows its object: the same echoes where object and probe are moved together") {
    const iq_lines still = echoes_of(muscle_box(), pose{});
    const pose moved = look_at({30_mm, -20_mm, 10_mm}, {31_mm, -18_mm, 40_mm}, {1, 0.3F, 0});
    const iq_lines also = echoes_of(muscle_box(moved), moved);
    const double same = correlation(levels(still), levels(also));
    MESSAGE("moved together: correlation of levels ", same, ", expected 1");
    CHECK(same > 0.995);
}

TEST_CASE("structure follows tissue that deforms") {
    scene body = muscle_box();
    const iq_lines rest = echoes_of(body, {.translation = {-3_mm, 0, 0}});
    body.deform(exec::par, [](vec3 p) { return p + vec3{3_mm, 0, 0}; });
    const iq_lines shifted = echoes_of(body, pose{});
    const double same = correlation(levels(rest), levels(shifted));
    MESSAGE("tissue shifted by 3 mm under the probe: correlation with the probe shifted back ", same, ", expected 1");
    CHECK(same > 0.99);
}

TEST_CASE("a probe that slides or turns a little sees the same fascicles") {
    const scene body = muscle_box();
    const iq_lines first = echoes_of(body, pose{});
    // By a block of three lines: the same places, seen by other lines.
    const float block = 3 * probe.width / static_cast<float>(probe.lines);
    std::vector<double> slid = levels(echoes_of(body, {.translation = {block, 0, 0}})), before = levels(first);
    const std::size_t column = slid.size() / (probe.lines / 3);
    before.erase(before.begin(), before.begin() + static_cast<std::ptrdiff_t>(column));
    slid.resize(before.size());
    const double slides = correlation(before, slid);
    const float turn = 2_deg;
    const double turns = correlation(
        levels(first), levels(echoes_of(body, look_at({0, 0, 0}, {0, 0, 1}, {std::cos(turn), std::sin(turn), 0}))));
    MESSAGE("correlation of levels: slid by a block ", slides, ", turned by 2 degrees ", turns);
    CHECK(slides > 0.9);
    CHECK(turns > 0.7);
}

TEST_CASE("structure: echoes are the same on any number of threads, and scalar and SIMD agree") {
    const scene body = muscle_box();
    const auto trace_by = [&](const auto& policy) { return trace(policy, body, probe, pose{}, physical{}, scan); };
    const iq_lines one = trace_by(exec::par.threads(1));
    CHECK(trace_by(exec::par.threads(3)) == one);
    const iq_lines lanes = trace_by(exec::par_unseq);
    float largest = 0, worst = 0;
    for (std::size_t i = 0; i < one.values.size(); ++i) {
        largest = std::max(largest, length(one.values[i]));
        worst = std::max(worst, length(one.values[i] - lanes.values[i]));
    }
    CHECK(worst < 1e-4F * largest);
}

TEST_CASE("the sheaths of a thin muscle meet in its middle: each is as bright as that of a thick one down to there") {
    structure sheath = tissue::muscle.structure; // alone
    sheath.sheets.fill = sheath.septa.fill = 0;
    for (const float thickness : {1_mm, 1.5_mm, 2_mm}) {
        const double thin = power_in_slab(sheath, thickness, 0, thickness, 300),
                     thick = power_in_slab(sheath, 20_mm, 0, 0.5F * thickness, 300);
        MESSAGE("muscle of ", thickness * 1e3F, " mm: ", thin - thick,
                " dB above the sheath of a thick one (expected 0)");
        CHECK(std::fabs(thin - thick) < 2);
    }
}

TEST_CASE("a thin muscle keeps its brightness where fibres end on its sheath") {
    // Fibres parallel to the surfaces, and a sheath that adds nothing: only the ends of the fibres differ.
    for (const float thickness : {1.5_mm, 2_mm, 2.5_mm, 3_mm, 5_mm}) {
        const auto power = [&](float insertion) { // of the middle half
            structure faint = tissue::muscle.structure;
            faint.sheath.level_db = -60;
            faint.sheath.insertion = insertion;
            return power_in_slab(faint, thickness, 0.25F * thickness, 0.75F * thickness, 40);
        };
        const double change = power(20_mm) - power(0);
        MESSAGE("muscle of ", thickness * 1e3F, " mm: ", change, " dB (expected 0)");
        CHECK(std::fabs(change) < 1);
    }
}

TEST_CASE("septa of fat that lie along the beam cannot be seen: lines differ by no more than without them") {
    const auto deviation = [](const medium& fat) { // of the levels of lines, dB, over many places
        double sum = 0, squares = 0, count = 0;
        for (const vec3 across_layers : {vec3{1, 0, 0}, vec3{0, 1, 0}}) {
            scene body{fat};
            body.set_background_fibres({0, 0, 1}, across_layers);
            body.build(exec::par);
            for (int i = 0; i < 8; ++i) {
                const iq_lines echoes =
                    echoes_of(body, {.translation = static_cast<float>(i) * vec3{31_mm, 17_mm, 9_mm}});
                for (std::uint32_t line = 0; line < probe.lines; ++line, ++count) {
                    double power = 0;
                    for (std::uint32_t k = 0; k < scan.samples; ++k)
                        power += static_cast<double>(dot(echoes(line, k), echoes(line, k)));
                    const double level = 10 * std::log10(power);
                    sum += level;
                    squares += level * level;
                }
            }
        }
        return std::sqrt(squares / count - sum / count * (sum / count));
    };
    medium none = tissue::fat;
    none.structure.septa = {};
    const double with = deviation(tissue::fat), without = deviation(none);
    MESSAGE("deviation from line to line ", with, " dB, without septa ", without);
    CHECK(with < without + 0.2);
}

} // namespace structure_in_echoes_test
