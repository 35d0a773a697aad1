#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/examinations.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <atomic>
#include <cmath>
#include <cstring>
#include <doctest/doctest.h>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;

namespace scanner_quality_test {
namespace {

bool same_bits(const image& a, const image& b) {
    return a.size == b.size && std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0;
}

const vec2 vessel{-9_mm, 17_mm}, bone{6_mm, 30_mm}; // {x, z}

scene phantom(const medium& around) {
    scene body{around};
    body.add(make_sphere({bone.x, 0, bone.y}, 8_mm, 5), tissue::bone);
    body.add(make_cylinder({vessel.x, -60_mm, vessel.y}, {vessel.x, 60_mm, vessel.y}, 4_mm, 64), tissue::blood);
    body.build(exec::par);
    return body;
}

// Straight lines, counted: each line of each plane of each look.
struct counted_lines {
    std::atomic<std::uint64_t>* lines = nullptr;
    std::atomic<std::uint64_t>* samples = nullptr;

    template <class Policy, acoustic_model Model>
    bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                    view<typename Model::sample_type> out) const {
        if (!straight_lines{line_search::rays}(policy, task, model, scratch, out)) return false;
        ++*lines;
        *samples += out.size();
        return true;
    }
};

struct levels_of_tissue {
    double power_db = 0, mean_db = 0; // the power's level, and the mean of levels as a picture shows them
};
// Of stored amplitudes, at several places.
template <class Probe>
levels_of_tissue measure_levels(const medium& tissue, const Probe& probe, float depth,
                                b_mode_settings::quality_level level, std::uint32_t looks = 1) {
    const scene body = scene{tissue}.build(exec::par);
    scanner machine{probe, b_mode_settings{.depth = depth,
                                           .noise = {.level_db = no_level_db},
                                           .compound = {.angles = looks, .spread = 6_deg},
                                           .quality = level}};
    double power = 0, decibels = 0, count = 0;
    for (int place = 0; place < 6; ++place) {
        machine.scan(exec::par_unseq, body, {.translation = {0, 20_mm * static_cast<float>(place), 0}});
        for (const float a : machine.cine()[0].amplitudes.values) {
            power += static_cast<double>(a) * static_cast<double>(a);
            decibels += 20 * std::log10(static_cast<double>(a) + 1e-9);
            ++count;
        }
    }
    return {10 * std::log10(power / count), decibels / count};
}

template <class Probe>
double brightness_at(const scanner<Probe>& machine, vec2 point) {
    const image& seen = machine.picture();
    const vec2 pixel = machine.map().pixel(point);
    const auto column = static_cast<std::size_t>(std::lround(pixel.x)),
               row = static_cast<std::size_t>(std::lround(pixel.y));
    REQUIRE(column < seen.size.x);
    REQUIRE(row < seen.size.y);
    return static_cast<double>(seen.pixels[row * seen.size.x + column]);
}

// Displayed depth of the brightest pixel of a column, metres.
template <class Probe>
float brightest(const scanner<Probe>& machine, float x, float from, float to) {
    float found = 0;
    double largest = -1;
    for (float z = from; z < to; z += 0.05_mm)
        if (const double now = brightness_at(machine, {x, z}); now > largest) {
            largest = now;
            found = z;
        }
    return found;
}

// How much brighter a ring of 4.25 to 6 mm is than the disc of 3.75 mm inside.
template <class Probe>
double contrast(const scanner<Probe>& machine, vec2 centre) {
    double inside = 0, outside = 0;
    int in = 0, out = 0;
    for (int i = -28; i <= 28; ++i)
        for (int k = -28; k <= 28; ++k) {
            const vec2 from_centre = 0.25_mm * vec2{i, k};
            const float radius = std::sqrt(dot(from_centre, from_centre));
            if (radius < 3.75_mm) {
                inside += brightness_at(machine, centre + from_centre);
                ++in;
            } else if (radius > 4.25_mm && radius < 6_mm) {
                outside += brightness_at(machine, centre + from_centre);
                ++out;
            }
        }
    return outside / out - inside / in;
}

} // namespace

TEST_CASE("quality: fast traces at most a quarter of the lines and planes of full, draft a tenth, and fewer samples") {
    const scene body = phantom(tissue::muscle);
    const auto compare = [&](const std::string& name, const auto& probe, float depth) {
        std::uint64_t all_lines = 0, all_samples = 0;
        for (const auto& [level, fraction] : {std::pair{b_mode_settings::quality_level::full, 1.0},
                                              {b_mode_settings::quality_level::fast, 0.25},
                                              {b_mode_settings::quality_level::draft, 0.1}}) {
            std::atomic<std::uint64_t> lines = 0, samples = 0;
            const b_mode_settings settings{.depth = depth, .size = {128, 128}, .quality = level};
            scanner machine{probe, settings, physical{}, counted_lines{&lines, &samples}};
            machine.scan(exec::par_unseq, body, pose{});
            const b_mode_sampling chosen = sampling_of(probe, settings);
            CHECK(lines == std::uint64_t{chosen.looks} * chosen.planes * chosen.lines);
            CHECK(samples == lines * chosen.samples);
            CHECK(machine.lines().count == chosen.lines);
            CHECK(machine.echoes().samples == chosen.samples);
            if (level == b_mode_settings::quality_level::full) {
                all_lines = lines;
                all_samples = samples;
            }
            MESSAGE(name, ": ", lines.load(), " lines of ", chosen.samples, " samples");
            CHECK(static_cast<double>(lines) <= fraction * static_cast<double>(all_lines));
            if (level != b_mode_settings::quality_level::full)
                CHECK(static_cast<double>(samples) <= 0.55 * fraction * static_cast<double>(all_samples));
        }
    };
    compare("linear array", linear_array{}, 80_mm);
    compare("64 lines", linear_array{.lines = 64}, 50_mm);
    compare("convex array", convex_array{}, 120_mm);
    compare("phased array", phased_array{}, 120_mm);
}

TEST_CASE(
    "quality: the distance of lines is that of the beam, whatever lines the probe has; samples follow the pulse") {
    for (const std::uint32_t lines : {1U, 64U, 192U, 400U}) {
        const linear_array probe{.lines = lines, .width = 38_mm};
        const beam_model beam = beam_of(probe, 50_mm);
        const auto traced = [&](b_mode_settings::quality_level level) {
            return sampling_of(probe, b_mode_settings{.depth = 50_mm, .compound = {.angles = 3}, .quality = level});
        };
        const float widths = 38_mm / beam.lateral_width(beam.focus);
        const b_mode_sampling fast = traced(b_mode_settings::quality_level::fast),
                              draft = traced(b_mode_settings::quality_level::draft);
        const auto at_most = [&](float needed) {
            return std::min(std::ceil(needed), 4.0F * static_cast<float>(lines));
        };
        CHECK(fast.lines == at_most(widths / 1.5F));
        CHECK(draft.lines == at_most(widths / 2));
        const float sigma = 0.1874F * 1540 / (0.644F * 7.5e6F);
        for (const b_mode_sampling& each : {fast, draft}) {
            CHECK(static_cast<float>(each.samples) >= 50_mm / sigma);
            CHECK(static_cast<float>(each.samples) < 50_mm / sigma + 64);
            CHECK(each.looks == 1);
        }
        CHECK(traced(b_mode_settings::quality_level::full).looks == 3);
        CHECK(fast.planes == 3);
        CHECK(draft.planes == 1);
        CHECK(
            sampling_of(
                probe,
                b_mode_settings{.samples = 2000, .planes = 1, .quality = b_mode_settings::quality_level::fast}) ==
            b_mode_sampling{sampling_of(probe, b_mode_settings{.quality = b_mode_settings::quality_level::fast}).lines,
                            2000, 1, 1});
    }
}

TEST_CASE("quality: the power of speckle is that of full within 1 dB, its mean level of plain tissue within 1 dB") {
    const auto compare = [](const std::string& name, const medium& tissue, const auto& probe, float depth,
                            double of_mean) {
        const levels_of_tissue full = measure_levels(tissue, probe, depth, b_mode_settings::quality_level::full);
        for (const b_mode_settings::quality_level level :
             {b_mode_settings::quality_level::fast, b_mode_settings::quality_level::draft}) {
            const levels_of_tissue now = measure_levels(tissue, probe, depth, level);
            const double power = now.power_db - full.power_db, mean = now.mean_db - full.mean_db;
            MESSAGE(name, std::string{level == b_mode_settings::quality_level::fast ? ", fast" : ", draft"}, ": power ",
                    power, " dB, mean level ", mean, " dB, expected 0 within 1 and ", of_mean);
            CHECK(std::fabs(power) < 1);
            CHECK(std::fabs(mean) < of_mean);
        }
    };
    compare("liver, linear array", tissue::liver, linear_array{}, 40_mm, 1);
    compare("liver, convex array", tissue::liver, convex_array{}, 100_mm, 1);
    compare("liver, phased array", tissue::liver, phased_array{}, 100_mm, 1);
}

// The figures of the scanner's page: there they are what is given up.
TEST_CASE("quality: how much lower the mean level is, of muscle and where looks are given up") {
    const auto compare = [](const std::string& name, const medium& tissue, const auto& probe, float depth,
                            std::uint32_t looks, double of_fast, double of_draft) {
        const double full = measure_levels(tissue, probe, depth, b_mode_settings::quality_level::full, looks).mean_db;
        for (const auto& [level, expected] : {std::pair{b_mode_settings::quality_level::fast, of_fast},
                                              {b_mode_settings::quality_level::draft, of_draft}}) {
            const double now = measure_levels(tissue, probe, depth, level, looks).mean_db - full;
            MESSAGE(name, ", looks of full ", looks,
                    std::string{level == b_mode_settings::quality_level::fast ? ", fast: " : ", draft: "}, now,
                    " dB, the page says ", expected);
            CHECK(std::fabs(now - expected) < 0.25);
        }
    };
    const auto nerve_block = presets::nerve_block.probe;
    compare("muscle, linear array", tissue::muscle, linear_array{}, 40_mm, 1, -0.9, -3.0);
    compare("muscle, convex array", tissue::muscle, convex_array{}, 100_mm, 1, -1.8, -4.4);
    compare("muscle, nerve block", tissue::muscle, nerve_block, 40_mm, 3, -1.6, -3.7);
    compare("liver, nerve block", tissue::liver, nerve_block, 40_mm, 3, -0.9, -0.9);
}

TEST_CASE("quality: a needle of 0.8 mm across the slice is seen at fast within 4 dB, but not always its tail") {
    const linear_array probe = presets::nerve_block.probe;
    for (const b_mode_settings::quality_level level :
         {b_mode_settings::quality_level::full, b_mode_settings::quality_level::fast,
          b_mode_settings::quality_level::draft}) {
        const int places = 24;
        int seen = 0, tails = 0;
        double smallest = 1000, largest = -1000;
        for (int place = 0; place < places; ++place) {
            const float x = 1_mm * static_cast<float>(place) / places;
            scene body{medium{.density = 1050, .sound_speed = 1540, .attenuation = 0.5_dB_per_cm}};
            body.add(make_cylinder({x, -40_mm, 18_mm}, {x, 40_mm, 18_mm}, 0.41_mm, 64), tissue::steel);
            body.build(exec::par);
            scanner machine{probe,
                            b_mode_settings{.depth = 40_mm, .noise = {.level_db = no_level_db}, .quality = level}};
            machine.scan(exec::par_unseq, body, pose{});
            const scan_lines& stored = machine.cine()[0].amplitudes;
            float head = 0, tail = 0;
            for (std::uint32_t i = 0; i < stored.count; ++i)
                for (std::uint32_t k = 0; k < stored.samples; ++k) {
                    const float z = (static_cast<float>(k) + 0.5F) * stored.depth / static_cast<float>(stored.samples);
                    if (z > 17_mm && z < 18.2_mm) head = std::max(head, stored(i, k));
                    if (z > 20_mm && z < 24_mm) tail = std::max(tail, stored(i, k));
                }
            seen += head > 1e-6F ? 1 : 0;
            tails += tail > 1e-6F ? 1 : 0; // -120 dB
            smallest = std::min(smallest, static_cast<double>(20 * std::log10(head + 1e-9F)));
            largest = std::max(largest, static_cast<double>(20 * std::log10(head + 1e-9F)));
        }
        MESSAGE("level ", static_cast<int>(level), ": needle ", seen, ", tail ", tails, " of ", places, " places; ",
                smallest, " to ", largest, " dB");
        CHECK(seen >= (level == b_mode_settings::quality_level::draft ? 1 : places));
        if (level == b_mode_settings::quality_level::full) CHECK(tails == places);
        if (level == b_mode_settings::quality_level::fast) CHECK(largest - smallest < 4);
        if (level == b_mode_settings::quality_level::fast) CHECK(std::abs(tails - 7) <= 2);
    }
}

TEST_CASE("quality: bone is where it is within 0.3 mm, a vessel where full shows it within 0.5 mm") {
    const scene body = phantom(tissue::muscle);
    const float stretch = display_speed / tissue::muscle.sound_speed;
    vec2 shown_by_full{0, 0};
    for (const b_mode_settings::quality_level level :
         {b_mode_settings::quality_level::full, b_mode_settings::quality_level::fast,
          b_mode_settings::quality_level::draft}) {
        scanner machine{linear_array{}, b_mode_settings{.depth = 40_mm, .size = {256, 256}, .quality = level}};
        machine.scan(exec::par_unseq, body, pose{});
        double worst = 0;
        for (float x = 3_mm; x <= 9_mm; x += 0.5_mm) {
            const float surface = bone.y - std::sqrt(8_mm * 8_mm - (x - bone.x) * (x - bone.x));
            const float shown = brightest(machine, x, 18_mm, 28_mm);
            worst = std::max(worst, static_cast<double>(std::fabs(shown - surface * stretch)));
        }
        MESSAGE("bone: ", 1e3 * worst, " mm from where it is, expected at most 0.3");
        CHECK(worst < 0.3e-3);
        double largest = -1;
        vec2 found{0, 0};
        for (int i = -6; i <= 6; ++i)
            for (int k = -6; k <= 6; ++k) {
                const vec2 place{vessel.x + 0.25_mm * static_cast<float>(i),
                                 vessel.y * stretch + 0.25_mm * static_cast<float>(k)};
                if (const double now = contrast(machine, place); now > largest) {
                    largest = now;
                    found = place;
                }
            }
        const vec2 apart = found - vec2{vessel.x, vessel.y * stretch};
        MESSAGE("vessel: ", 1e3 * apart.x, ", ", 1e3 * apart.y, " mm from where it is, ", 60 * largest, " dB darker");
        CHECK(std::sqrt(dot(apart, apart)) <= 1_mm);
        if (level == b_mode_settings::quality_level::full) shown_by_full = found;
        CHECK(std::sqrt(dot(found - shown_by_full, found - shown_by_full)) <= 0.5_mm);
        CHECK(60 * largest > 3);
    }
}

TEST_CASE("quality: pictures are those of b_mode to the bit, and a frozen one stays what it was") {
    const scene body = phantom(tissue::muscle);
    b_mode_settings settings{.depth = 30_mm, .size = {64, 64}, .compound = {.angles = 3}};
    const linear_array probe{.lines = 64};
    scanner machine{probe, settings};
    machine.settings.time_gain.chosen = settings.time_gain.chosen =
        b_mode_settings::time_gain_settings::choice::every_frame;
    for (const b_mode_settings::quality_level level :
         {b_mode_settings::quality_level::draft, b_mode_settings::quality_level::full,
          b_mode_settings::quality_level::fast, b_mode_settings::quality_level::draft,
          b_mode_settings::quality_level::full}) {
        machine.settings.quality = settings.quality = level;
        CHECK(same_bits(machine.scan(exec::par_unseq, body, pose{}),
                        b_mode(exec::par_unseq, body, probe, pose{}, settings)));
        CHECK(machine.labels(exec::par_unseq, body).size == uvec2{64, 64});
    }
    const image seen = machine.picture();
    machine.freeze();
    machine.settings.quality = b_mode_settings::quality_level::draft;
    CHECK(same_bits(machine.scan(exec::par_unseq, body, pose{}), seen));
}

TEST_CASE("quality: a number of planes that does not exist is refused at every level") {
    const scene body = phantom(tissue::muscle);
    for (const b_mode_settings::quality_level level :
         {b_mode_settings::quality_level::full, b_mode_settings::quality_level::fast,
          b_mode_settings::quality_level::draft})
        for (const std::uint32_t planes : {0U, 2U, 4U, 9U}) {
            const b_mode_settings settings{.planes = planes, .quality = level};
            CHECK_THROWS_AS(b_mode(exec::seq, body, linear_array{.lines = 8}, pose{}, settings), usage_error);
        }
}

} // namespace scanner_quality_test
