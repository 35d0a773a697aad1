/// Cases: every view of every region opens with its own probe, is drawn, pressed, labelled and pierced, and has flow; recordings
/// with them are the same on any number of threads. live_tests cases
#include "../recording.hpp"
#include <chrono>
#include <cstdio>
#include <set>

namespace cases_test {
namespace {

using namespace insonify;

bool check(bool holds, const std::string& text) {
    std::printf("%s %s\n", holds ? "ok  " : "FAIL", text.c_str());
    return holds;
}

std::string text_of(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.3g", value);
    return digits;
}

double mean_of(const image& picture) {
    double sum = 0;
    for (const float pixel : picture.pixels) {
        if (!(pixel >= 0 && pixel <= 1)) throw std::runtime_error{"a pixel is " + std::to_string(pixel)};
        sum += static_cast<double>(pixel);
    }
    return sum / static_cast<double>(picture.pixels.size());
}

double draw(live::session& one) { return mean_of(one.frame(exec::par_unseq.threads(2))); }

void make_small(live::session& one) {
    for (const live::event& small : {live::event{"lines", {48}}, {"planes", {1}}, {"width", {96}}, {"compound", {1}}})
        one.apply(small);
}

// The table has all views of all regions, each once.
bool lists_all() {
    std::set<std::string> listed, known, titles;
    for (const live::case_entry& one : live::cases) {
        listed.insert(std::string{one.region} + '/' + one.view);
        titles.insert(one.title);
    }
    for (const ::anatomy::region& region : ::anatomy::regions())
        for (const ::anatomy::view& view : region.make().views)
            known.insert(std::string{region.name} + '/' + view.name);
    const bool holds = listed == known && titles.size() == std::size(live::cases) && listed.size() == titles.size() &&
                       std::string{live::cases[0].region} == "nerve_block";
    return check(holds, std::to_string(std::size(live::cases)) + " cases, " + std::to_string(known.size()) + " views");
}

// Samples of flow in the box, faster than the wall filter.
std::size_t flowing(const live::session& one) {
    std::size_t count = 0;
    for (const flow_sample& each : one.doppler.velocities().values)
        count += std::fabs(each.velocity) > one.doppler.slowest && each.power > std::pow(10.0F, -12.4F) ? 1 : 0;
    return count;
}

bool opens(live::session& one, std::uint32_t number) {
    const live::case_entry& entry = live::cases[number];
    one.apply({"case", {static_cast<float>(number)}});
    const ::anatomy::body made = ::anatomy::find_region(entry.region).make({});
    const ::anatomy::view& view = made.find_view(entry.view);
    const live::array_probe probe = std::visit([](const auto& array) { return live::array_probe{array}; }, view.probe);
    bool holds = one.machine.probe.kind == probe.kind && one.machine.probe.frequency == probe.frequency &&
                 one.machine.settings.depth == view.settings.depth && one.machine.settings.grey == view.settings.grey &&
                 one.machine.probe.lines == 48 && one.machine.settings.planes == 1;
    const double first = draw(one);
    holds = holds && first > 0.05 && first < 0.7;
    // Pressed as the view says, the probe touches the skin.
    const auto touching = static_cast<double>(one.touch().touching) / 48;
    holds = holds && touching > 0.6;
    std::string text = std::string{entry.title} + ": mean level " + text_of(first) + ", contact " + text_of(touching);

    one.apply({"labels", {1}});
    draw(one);
    const std::size_t names = one.legend().size();
    one.apply({"labels", {0}});
    // Lifted, it is in air: less is seen. Pressed, the skin gives way.
    one.apply({"press", {2}});
    draw(one);
    const float pressed = one.touch().mean_depth;
    for (int i = 0; i < 3; ++i) one.apply({"press", {-8}});
    const double lifted = draw(one);
    one.apply({"press", {10}});
    const aabb whole = one.box();
    for (const vec2 way : {vec2{100, 0}, {-100, 0}, {0, 100}, {0, -100}, {-100, 0}, {100, 100}}) {
        one.apply({"slide", {way.x, way.y}}); // to the edges of the body
        draw(one);
        holds = holds && one.hand.on_skin.x >= whole.lower.x && one.hand.on_skin.x <= whole.upper.x;
    }
    holds = holds && names >= 3 && pressed > 0.2_mm && lifted < 0.6 * first;
    text += ", " + std::to_string(names) + " labels, lifted " + text_of(lifted);
    return check(holds, text);
}

// Where the probe slides, it turns with the skin as the hand does, by the angle by which that falls off, and touches it.
bool follows_skin(live::session& one, std::uint32_t number) {
    one.apply({"case", {static_cast<float>(number)}});
    draw(one);
    const auto inward = [&] { // at the middle of the face
        const pose at = one.probe_pose();
        const auto skin = nearest_surface(one.body, *one.body.find("skin"), at.translation);
        return skin ? -skin->normal : vec3{0, 0, 1};
    };
    const vec3 first = inward();
    float turned = 0, apart = 0, touching = 1;
    for (const float step : {10.0F, 10.0F, -30.0F, -10.0F}) { // mm
        one.apply({"slide", {step, 0}});
        draw(one);
        const vec3 now = inward(), down = one.probe_pose().direction({0, 0, 1});
        turned = std::max(turned, std::acos(clamp(dot(first, now), -1, 1)));
        apart = std::max(apart, std::acos(clamp(dot(down, now), -1, 1)));
        touching =
            std::min(touching, static_cast<float>(one.touch().touching) / static_cast<float>(one.machine.probe.lines));
    }
    return check(turned > 15_deg && apart < 15_deg && touching > 0.9F,
                 std::string{live::cases[number].title} + ": the skin turns by " + text_of(turned / 1_deg) +
                     " degrees, the probe is within " + text_of(apart / 1_deg) + " of it, and " +
                     text_of(100 * touching) + " % of its lines touch");
}

// A body of its own begins with the probe straight above its middle, wherever that is, and slid to its edge within reach of the hand.
bool follows_own_mesh() {
    scene body{tissue::air};
    body.add(make_cylinder({35_mm, -60_mm, 40_mm}, {35_mm, 60_mm, 40_mm}, 40_mm, 64), tissue::muscle, {.name = "skin"});
    live::session one{std::move(body)};
    const auto down = [&] { return one.probe_pose().direction({0, 0, 1}); };
    const float begins = std::acos(clamp(down().z, -1, 1));
    float steepest = 0;
    for (const float rock : {-30.0F, 60.0F}) {
        one.apply({"rock", {rock}});
        for (const float step : {100.0F, -200.0F, 100.0F}) {
            one.apply({"slide", {step, 0}});
            steepest = std::max(steepest, std::acos(clamp(down().z, -1, 1)));
        }
    }
    return check(begins < 1_deg && steepest < 85_deg,
                 "a mesh off the origin: the probe begins " + text_of(begins / 1_deg) +
                     " degrees from straight down, and is never more than " + text_of(steepest / 1_deg) + " from it");
}

// The needle enters at the skin, and reaches the target of the view.
bool pierces(live::session& one, std::uint32_t number) {
    const live::case_entry& entry = live::cases[number];
    one.apply({"case", {static_cast<float>(number)}});
    const ::anatomy::body made = ::anatomy::find_region(entry.region).make({});
    const ::anatomy::view& view = made.find_view(entry.view);
    const std::optional<surface_point> skin = nearest_surface(one.body, *one.body.find("skin"), one.needle.entry);
    const float from_skin = skin ? skin->distance : 1;
    bool holds = from_skin < 0.5_mm;
    std::string text = std::string{entry.title} + ": the needle begins " +
                       text_of(1e3 * static_cast<double>(from_skin)) + " mm from the skin";
    if (view.needle && number > 0) {
        const vec3 target = view.at.local_point(view.needle->target);
        one.apply({"advance", {1e3F * length(target - one.needle.entry)}});
        const float missed = length(one.needle.at().point({0, 0, 0}) - target);
        text += ", and ends " + text_of(1e3 * static_cast<double>(missed)) + " mm from its target";
        holds = holds && missed < 0.1_mm; // which depends on the resolution
    }
    const double before = draw(one);
    const vec2 beside{one.needle.entry.x, one.needle.entry.y + 5_mm};
    one.apply({"entry", {1e3F * beside.x, 1e3F * beside.y}});
    draw(one);
    return check(holds && before > 0 && std::fabs(one.needle.entry.z - one.skin_at(beside)) < 0.01_mm, text);
}

// Flow is seen in the box where a vessel crosses the slice, tilted and rocked by up to 15 degrees.
bool flows(live::session& one, std::uint32_t number) {
    one.apply({"case", {static_cast<float>(number)}});
    one.apply({"mode", {2}});
    one.apply({"scale", {20}});
    constexpr int frames = 6; // of a beat, for each place of the probe
    one.apply({"interval", {std::round(120 / one.beat.rate / frames)}});
    const bool crosses = one.doppler.box_middle != vec2{0, 0.5F * one.machine.settings.depth};
    std::size_t largest = 0;
    for (const live::event& turn :
         {live::event{"tilt", {0}}, {"tilt", {15}}, {"tilt", {-30}}, {"tilt", {15}}, {"rock", {15}}, {"rock", {-30}}}) {
        one.apply(turn);
        for (int i = 0; i < frames; ++i) {
            draw(one);
            largest = std::max(largest, flowing(one));
        }
    }
    const std::string text = std::string{live::cases[number].title} + ": " + std::to_string(one.vessels().size()) +
                             " vessels, " + std::to_string(largest) + " samples of flow" +
                             (crosses ? "" : ", none in the slice");
    one.apply({"mode", {4}});
    for (int i = 0; i < 3; ++i) draw(one);
    const uvec2 spectrum = one.strip().size;
    one.apply({"mode", {1}});
    draw(one);
    return check((largest > 5 || !crosses) && (largest == 0 || !one.vessels().empty()) && spectrum.x > 0 &&
                     one.strip().size.x > 0,
                 text);
}

// Veins collapse below the probe, arteries do not, and pulse.
bool moves_vessels() {
    live::session one;
    one.apply({"case", {static_cast<float>(live::find_case("neck", ""))}});
    make_small(one);
    one.apply({"press", {6}});
    for (int i = 0; i < 6; ++i) draw(one);
    std::size_t arteries = 0, veins = 0;
    for (const live::vessel& each : one.vessels()) ++(each.type == live::vessel::kind::artery ? arteries : veins);
    const live::tissue_motion& now = one.motion;
    const std::string text = std::to_string(now.vessels.arteries.size()) + " of " + std::to_string(arteries) +
                             " arteries pulse, " + std::to_string(now.vessels.veins.size()) + " of " +
                             std::to_string(veins) + " veins collapse";
    float wide = 0;
    for (const live::vessel& each : one.vessels()) {
        if (each.type == live::vessel::kind::vein) continue;
        const centre_line line = each.line;
        const tube_section& middle = each.line[each.line.size() / 2];
        const line_place place = line.place(middle.centre);
        const vec3 wall = place.centre + place.radii.x * place.first_axis;
        for (const bent<pulsation>& beat : now.vessels.arteries) wide = std::max(wide, length(beat(wall) - wall));
    }
    return check(now.vessels.arteries.size() == arteries && now.vessels.veins.size() > 0 && arteries > 0 &&
                     wide > 0.02_mm,
                 text + ", a wall moves by " + text_of(1e3 * static_cast<double>(wide)) + " mm");
}

// Patients differ, 0 is the usual one, and parameters that are given stay.
bool draws_patients() {
    live::session one;
    make_small(one);
    one.apply({"case", {static_cast<float>(live::find_case("lumbar", ""))}});
    const auto size = [&] { return one.box().size(); };
    const vec3 usual = size();
    one.apply({"patient", {7}});
    const vec3 other = size();
    one.apply({"patient", {0}});
    const bool returns = size() == usual;
    one.given = live::checked("lumbar", {{"fat", 0.02F}});
    one.apply({"patient", {0}});
    const vec3 fat = size();
    bool holds = check(other != usual && returns && fat != usual, "patients differ, and 0 is the usual one");
    one.apply({"patient", {20000}});
    return check(one.patient_number == live::max_patient, "a number out of range is clamped") && holds;
}

// A session with cases, recorded and replayed on one thread and on two.
bool replays() {
    const char* const name = "cases.txt";
    {
        std::ofstream file{name};
        file << live::parameters_line(live::checked("neck", {{"fat", 0.004F}})) << '\n';
        live::recorder record{file};
        live::session one;
        one.record = &record;
        make_small(one);
        for (const live::event& each : {live::event{"case", {1}},
                                        {"press", {1}},
                                        {"patient", {3}},
                                        {"tilt", {5}},
                                        {"case", {9}},
                                        {"mode", {2}},
                                        {"case", {0}},
                                        {"slide", {3, 0}}}) {
            one.apply(each);
            for (int i = 0; i < 2; ++i) draw(one);
        }
    }
    const live::recording read = live::load_recording(name);
    const auto play = [&](std::uint32_t threads) {
        live::session again = live::begin_session(live::load_body({}, &read));
        std::vector<std::uint64_t> pictures;
        for (live::player steps{read.steps}; steps.advance(again);) {
            again.frame(exec::par_unseq.threads(threads));
            pictures.push_back(live::hash_of(again.screen()));
        }
        return pictures;
    };
    const std::vector<std::uint64_t> once = play(1);
    return check(once == play(2) && once.size() == 16 && read.given.values.at("fat") == 0.004F,
                 std::to_string(once.size()) + " pictures of several cases, the same on one thread and on two");
}

} // namespace

int run() {
    bool holds = lists_all();
    live::session one;
    make_small(one);
    for (std::uint32_t i = 0; i < std::size(live::cases); ++i) holds = opens(one, i) && holds;
    for (std::uint32_t i = 0; i < std::size(live::cases); ++i) holds = pierces(one, i) && holds;
    holds = follows_own_mesh() && holds;
    for (const auto& [region, view] : {std::pair{"neck", ""}, {"leg", "calf_transverse"}})
        holds = follows_skin(one, static_cast<std::uint32_t>(live::find_case(region, view))) && holds;
    for (std::uint32_t i = 0; i < std::size(live::cases); ++i) holds = flows(one, i) && holds;
    holds = moves_vessels() && holds;
    holds = draws_patients() && holds;
    return replays() && holds ? 0 : 1;
}

} // namespace cases_test
