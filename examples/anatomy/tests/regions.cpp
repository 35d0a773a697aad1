#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "../regions.hpp"
#include <insonify/insonify.hpp>
#include "../../../tests/geometry/crossings.hpp"
#include "../../region_values.hpp"
#include <algorithm>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <set>
#include <string>
#include <vector>

using namespace insonify;

namespace {

constexpr std::uint64_t seeds = 200;  ///< bodies of each region
constexpr std::uint64_t crossed = 5;  ///< of so many bodies, one is searched for faces that cross, which takes long
constexpr float coarse = 0.5F;        ///< resolution of the meshes in these tests
constexpr std::size_t sampled = 60;   ///< vertices of an object that are looked for in another one
constexpr float furthest_skin = 3_mm; ///< from the middle of a probe's face

/// A scene of one object of a body.
scene alone(const object& one) {
    scene only{tissue::water};
    only.add(one.surface, tissue::muscle, {.name = one.name});
    return only.build(exec::seq);
}

const object& named(const anatomy::body& body, const std::string& name) {
    for (const object& one : body.anatomy.objects())
        if (one.name == name) return one;
    FAIL("there is no object '", name, "'");
    return body.anatomy.objects()[0];
}

/// The number of objects with faces that cross each other, each with a message.
int self_intersections_of(const anatomy::body& body) {
    int faults = 0;
    for (const object& one : body.anatomy.objects()) {
        const mesh_test::crossings found = mesh_test::crossings_of(one.surface);
        if (found.faces == 0) continue;
        MESSAGE(one.name, ": ", found.faces, " of ", one.surface.faces.size(), " faces cross, by up to ",
                found.depth * 1e3, " mm, at ", found.place.x, ", ", found.place.y, ", ", found.place.z);
        ++faults;
    }
    return faults;
}

/// Where the wall of a blood vessel lies, as its line says: distance from the line over that of the wall, of each vertex that is
/// between the ends of one of its lines. Sorted.
std::vector<float> wall_places(const anatomy::body& body, const std::string& blood) {
    std::vector<centre_line> lines;
    std::vector<std::pair<vec3, vec3>> ends;
    for (const anatomy::vessel& one : body.vessels)
        if (one.name == blood) {
            lines.emplace_back(one.line);
            ends.emplace_back(one.line.front().centre, one.line.back().centre);
        }
    std::vector<float> places;
    for (const vec3 p : named(body, blood).surface.positions) {
        float nearest = FLT_MAX;
        for (std::size_t i = 0; i < lines.size(); ++i) {
            const line_place here = lines[i].place(p);
            const bool is_beyond = length(here.centre - ends[i].first) < here.radii.x + here.radii.y ||
                                   length(here.centre - ends[i].second) < here.radii.x + here.radii.y;
            if (!is_beyond) nearest = std::min(nearest, std::sqrt(here.squared(p)));
        }
        if (nearest < 3) places.push_back(nearest); // else it belongs to what has no line, or to an end
    }
    std::sort(places.begin(), places.end());
    return places;
}

/// The number of faults, each with a message.
int faults_of(const anatomy::body& body) {
    int faults = 0;
    const auto fault = [&](const std::string& what) {
        MESSAGE(what);
        ++faults;
    };
    std::set<std::string> names;
    for (const object& one : body.anatomy.objects()) {
        if (one.name.empty() || !names.insert(one.name).second) fault("the name '" + one.name + "' is used twice");
        const mesh_report report = validate(one.surface);
        if (!report.closed() || report.inside_out_components > 0) fault(one.name + ": " + explain(report));
        if (!(report.volume > 0)) fault(one.name + ": it has no volume");
    }
    std::map<std::string, scene> outer;
    for (const auto& [inner, around] : body.nested) {
        if (!outer.contains(around)) outer.emplace(around, alone(named(body, around)));
        const std::vector<vec3>& places = named(body, inner).surface.positions;
        const std::size_t step = std::max<std::size_t>(places.size() / sampled, 1);
        std::size_t outside = 0;
        for (std::size_t i = 0; i < places.size(); i += step) outside += object_at(outer.at(around), places[i]) ? 0 : 1;
        if (outside > 0)
            fault(inner + ": " + std::to_string(outside) + " of " + std::to_string(places.size() / step) +
                  " points are not in " + around);
    }
    const scene skin = alone(named(body, "skin"));
    for (const anatomy::view& one : body.views) {
        if (!is_rigid(one.at)) fault(one.name + ": its pose is not rigid");
        if (object_at(skin, one.at.translation)) fault(one.name + ": the face is below the skin");
        const auto below = first_surface(skin, {one.at.translation, one.at.direction({0, 0, 1})});
        if (!below || below->distance > furthest_skin) fault(one.name + ": the face does not touch the skin");
        if (!one.needle) continue;
        const auto at_entry = nearest_surface(skin, skin.objects()[0].id, one.needle->entry);
        if (!at_entry || at_entry->distance > 1_mm) fault(one.name + ": the needle does not enter at the skin");
        if (!object_at(skin, one.needle->target)) fault(one.name + ": the needle's target is outside");
    }
    for (const anatomy::vessel& one : body.vessels) {
        const scene blood = alone(named(body, one.name));
        for (const tube_section& place : one.line)
            if (!object_at(blood, place.centre)) {
                fault(one.name + ": its line leaves it");
                break;
            }
    }
    return faults;
}

std::string sentence(const anatomy::region& region, const anatomy::values& given) {
    try {
        region.make(given);
    } catch (const usage_error& error) {
        return error.what();
    }
    return "no error";
}

/// Regions with parameters: not the phantom, which is always the same.
std::vector<anatomy::region> that_vary() {
    std::vector<anatomy::region> all = anatomy::regions();
    std::erase_if(all, [](const anatomy::region& one) { return one.parameters.empty(); });
    return all;
}

} // namespace

TEST_CASE("every body is closed, nested, named, does not intersect itself, and can be seen and measured") {
    for (const anatomy::region& region : that_vary())
        for (std::uint64_t seed = 0; seed < seeds; ++seed) {
            anatomy::values values = region.drawn(seed);
            values["resolution"] = coarse;
            const anatomy::body body = region.make(values);
            const int faults = faults_of(body) + (seed % crossed == 0 ? self_intersections_of(body) : 0);
            CAPTURE(std::string{region.name});
            CAPTURE(seed);
            CHECK(faults == 0);
        }
}

TEST_CASE("so is a body with any parameter at its smallest and at its largest value") {
    for (const anatomy::region& region : that_vary())
        for (const anatomy::parameter& one : region.parameters) {
            if (std::string{one.name} == "resolution") continue;
            for (const float value : {one.smallest, one.largest}) {
                const anatomy::body body = region.make({{one.name, value}, {"resolution", coarse}});
                const int faults = faults_of(body) + self_intersections_of(body);
                CAPTURE(std::string{region.name});
                CAPTURE(std::string{one.name});
                CAPTURE(value);
                CHECK(faults == 0);
            }
        }
}

TEST_CASE("so is a small and a large body with any other length at its smallest and at its largest value") {
    for (const anatomy::region& region : that_vary())
        for (const anatomy::parameter& one : region.parameters) {
            if (std::string{one.unit} != "m") continue;
            for (const float size : {0.9F, 1.1F})
                for (const float value : {one.smallest, one.largest}) {
                    const anatomy::body body = region.make({{one.name, value}, {"size", size}, {"resolution", coarse}});
                    const int faults = faults_of(body);
                    CAPTURE(std::string{region.name});
                    CAPTURE(std::string{one.name});
                    CAPTURE(size);
                    CAPTURE(value);
                    CHECK(faults == 0);
                }
        }
}

TEST_CASE("at the default resolution a body has at most 400,000 triangles and is made in two seconds") {
    for (const anatomy::region& region : that_vary()) {
        CAPTURE(std::string{region.name});
        double best = 1e9;
        for (int i = 0; i < 3; ++i) {
            const auto start = std::chrono::steady_clock::now();
            const anatomy::body body = region.make();
            best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            std::size_t triangles = 0;
            for (const object& one : body.anatomy.objects()) triangles += one.surface.faces.size();
            CHECK(triangles <= 400'000);
            CHECK(triangles > 20'000);
        }
        MESSAGE(std::string{region.name}, ": ", best, " s");
#ifdef __OPTIMIZE__
        CHECK(best < 2);
#endif
        std::size_t highest = 0; // triangles of a drawn body
        for (std::uint64_t seed = 0; seed < 12; ++seed) {
            std::size_t triangles = 0;
            const anatomy::body drawn = region.make(region.drawn(seed));
            for (const object& one : drawn.anatomy.objects()) triangles += one.surface.faces.size();
            highest = std::max(highest, triangles);
        }
        MESSAGE(std::string{region.name}, ": up to ", highest, " triangles");
        CHECK(highest <= 400'000);
        const anatomy::body usual = region.make();
        CHECK(faults_of(usual) + self_intersections_of(usual) == 0);
    }
}

TEST_CASE("between multifidus and erector spinae lies a fascia, on both sides") {
    for (const float variant : {1.0F, 2.0F, 3.0F}) {
        anatomy::body body = anatomy::find_region("lumbar").make({{"variant", variant}, {"resolution", coarse}});
        body.anatomy.build(exec::par);
        const auto name_at = [&](vec3 place) {
            const std::optional<object_id> here = object_at(body.anatomy, place);
            return here ? body.anatomy[*here].name : std::string{};
        };
        for (const std::string side : {"right ", "left "}) {
            vec3 middle{0, 0, 0}; // of the muscle, in the middle of the region
            float count = 0;
            for (const vec3 p : named(body, side + "multifidus").surface.positions)
                if (std::fabs(p.y) < 4_mm) {
                    middle += p;
                    ++count;
                }
            middle *= 1 / count;
            CHECK(name_at(middle) == side + "multifidus");
            std::set<std::string> passed;
            const float outwards = middle.x > 0 ? 0.05_mm : -0.05_mm;
            for (vec3 p = middle; std::fabs(p.x) < 60_mm && name_at(p) != side + "erector spinae"; p.x += outwards)
                passed.insert(name_at(p));
            CHECK(passed == std::set<std::string>{side + "multifidus", side + "fascia of the multifidus"});
        }
    }
}

TEST_CASE("a vessel's line says where its wall is, on all sides") {
    for (const anatomy::region& region : anatomy::regions())
        for (const float side : {0.0F, 1.0F}) {
            anatomy::values values;
            for (const anatomy::parameter& one : region.parameters)
                if (std::string{one.name} == "side") values["side"] = side;
            const anatomy::body body = region.make(values);
            std::set<std::string> names;
            for (const anatomy::vessel& one : body.vessels) names.insert(one.name);
            CHECK(names.empty() == (std::string{region.name} == "lumbar"));
            for (const std::string& name : names) {
                const std::vector<float> walls = wall_places(body, name);
                CAPTURE(std::string{region.name});
                CAPTURE(name);
                REQUIRE(walls.size() > 50);
                const auto at = [&](double part) {
                    return walls[static_cast<std::size_t>(part * static_cast<double>(walls.size() - 1))];
                };
                MESSAGE(name, ": ", at(0.05), ", ", at(0.5), ", ", at(0.95));
                // A tree is joined smoothly, and its thinnest branches have no line.
                const bool is_tree = std::count_if(body.vessels.begin(), body.vessels.end(),
                                                   [&](const anatomy::vessel& one) { return one.name == name; }) > 1;
                CHECK(at(0.5) == doctest::Approx(1).scale(1e-30).epsilon(0.05));
                CHECK(at(is_tree ? 0.1 : 0.05) > 0.75F);
                CHECK(at(is_tree ? 0.85 : 0.95) < 1.3F);
            }
        }
}

TEST_CASE("blood flows towards the head in carotid arteries, away from it in jugular veins, and pulses") {
    const anatomy::body body = anatomy::find_region("neck").make({{"resolution", coarse}});
    const anatomy::blood_flow flow = body.flow(1_Hz), lasting = body.flow(0);
    REQUIRE(flow.tubes.size() == body.vessels.size());
    for (std::size_t i = 0; i < body.vessels.size(); ++i) {
        const anatomy::vessel& one = body.vessels[i];
        const object_id blood = *body.anatomy.find(one.name);
        const bool is_artery = one.type == anatomy::vessel::kind::artery;
        CAPTURE(one.name);
        const tube_section& first = one.line.front();
        const vec3 systole = flow(blood, first.centre, 0.15F), diastole = flow(blood, first.centre, 0.999F);
        CHECK((is_artery ? -systole.y : systole.y) > 0.7F * one.peak_velocity); // y points to the feet
        CHECK(length(systole) == doctest::Approx(one.peak_velocity).scale(1e-30).epsilon(1e-3));
        CHECK(length(lasting(blood, first.centre, 0.7F)) ==
              doctest::Approx(one.peak_velocity).scale(1e-30).epsilon(1e-3));
        // At the end of a beat 1 minus the resistive index of it is left.
        const float left = is_artery ? 1 - one.resistive_index : 1;
        CHECK(length(diastole) / length(systole) == doctest::Approx(left).scale(1e-30).epsilon(0.02));
        CHECK(flow(background_object, first.centre, 0) == vec3{0, 0, 0});
    }
}

TEST_CASE("arteries pulse and stay open, veins collapse, by what their pressure says") {
    anatomy::body body = anatomy::find_region("neck").make({{"resolution", coarse}});
    const pulsation still{.amplitude = 0}, systole{.amplitude = 0.3_mm, .time = 0.15F / 1.2F};
    const auto pressed_by = [&](float pressure) {
        return anatomy::contact_pressure{{body.views.front().at.translation}, pressure};
    };
    CHECK(body.motion(still).arteries.empty());
    CHECK(body.motion(systole, pressed_by(5_mmHg)).veins.empty()); // their blood has 6
    const anatomy::vessel_motion beat = body.motion(systole), pressed = body.motion(still, pressed_by(20_mmHg));
    CHECK(pressed.veins.size() + beat.arteries.size() == body.vessels.size());
    for (const anatomy::vessel& one : body.vessels) {
        CAPTURE(one.name);
        const line_place middle = centre_line{one.line}.place(one.line[one.line.size() / 2].centre);
        const vec3 wall = middle.centre + middle.radii.y * middle.second_axis;
        const vec3 above = middle.centre - vec3{0, 0, 1e-4F};
        const float height =
            (pressed(above) - pressed(middle.centre)).z / (above - middle.centre).z; // over that at rest
        if (one.type == anatomy::vessel::kind::artery) {
            // By itself it moves by the fraction of its radius that the beat has; beside others, with these.
            const anatomy::vessel_motion own = anatomy::motion_of({one}, systole, {});
            CHECK(length(own(wall) - wall) == doctest::Approx(0.1F * middle.radii.y).scale(1e-30).epsilon(0.01));
            CHECK(height > 0.8F); // a vein beside it closes
        } else {
            CHECK(height < 0.3F); // by 14 mmHg: Shapiro's law
        }
    }
    // What closes lets less through.
    const std::size_t vein =
        static_cast<std::size_t>(std::find_if(body.vessels.begin(), body.vessels.end(),
                                              [](const auto& one) { return one.type == anatomy::vessel::kind::vein; }) -
                                 body.vessels.begin());
    const float opening = body.vessels[vein].collapsed(pressed_by(20_mmHg)).opening();
    CHECK(opening == doctest::Approx(std::pow(1 + 14_mmHg / 40, -2.0F / 3)).scale(1e-30).epsilon(1e-3));
    const float left =
        body.flow(1_Hz, pressed_by(20_mmHg)).tubes[vein].peak_velocity / body.vessels[vein].peak_velocity;
    CHECK(left == doctest::Approx(2 * std::pow(opening, 3.0F) / (1 + opening * opening)).scale(1e-30).epsilon(1e-3));
    // What is out of range is refused.
    CHECK_THROWS_AS(body.motion({.amplitude = 5_mm}), usage_error);
    CHECK_THROWS_AS(body.motion(still, pressed_by(std::nanf(""))), usage_error);
    CHECK_THROWS_AS(body.flow(1_Hz, pressed_by(std::nanf(""))), usage_error);
    CHECK_THROWS_AS(body.flow(-1_Hz), usage_error);
}

TEST_CASE("vessels of all regions move without folding tissue over, and what lies deep stays open") {
    for (const anatomy::region& region : anatomy::regions()) {
        CAPTURE(std::string{region.name});
        const anatomy::body body =
            region.make(region.parameters.empty() ? anatomy::values{} : anatomy::values{{"resolution", coarse}});
        const anatomy::vessel_motion map =
            body.motion({.amplitude = 0.3_mm, .time = 0.15F / 1.2F}, {{body.views.front().at.translation}, 20_mmHg});
        float furthest = 0;
        std::size_t off = 0, points = 0; // off: where the nearest place of a line jumps, around the centre of a bend
        for (const object& one : body.anatomy.objects())
            for (std::size_t i = 0; i < one.surface.positions.size(); i += 7, ++points) {
                const vec3 rest = one.at.point(one.surface.positions[i]);
                const float away = length(map.rest_of(map(rest)) - rest);
                furthest = std::max(furthest, away);
                off += away > 1_um ? 1 : 0;
            }
        MESSAGE(std::string{region.name}, ": ", off, " of ", points, " points, by up to ", furthest / 1_um, " um");
        CHECK(off < points / 500);
        CHECK(furthest < 20_um);
        if (std::string{region.name} == "right_upper_quadrant") CHECK(map.veins.empty());
    }
}

TEST_CASE("the velocity of blood stays along its vessel") {
    for (const anatomy::region& region : anatomy::regions()) {
        const anatomy::body body = region.make();
        const anatomy::blood_flow flow = body.flow(0);
        for (std::size_t i = 0; i < body.vessels.size(); ++i) {
            CAPTURE(body.vessels[i].name);
            for (const tube_section& one : body.vessels[i].line) {
                const tube_flow& own = flow.tubes[i];
                const float speed = length(own(own.object, one.centre, 0));
                CHECK(speed == doctest::Approx(std::fabs(body.vessels[i].peak_velocity)).scale(1e-30).epsilon(0.02));
            }
        }
    }
}

TEST_CASE("a larger body is larger, but in the lengths that are given") {
    for (const anatomy::region& region : that_vary()) {
        CAPTURE(std::string{region.name});
        const auto skin_of = [](const anatomy::body& body) {
            aabb box;
            for (const vec3 p : named(body, "skin").surface.positions) box = merged(box, p);
            return box.size();
        };
        const anatomy::body usual = region.make({{"resolution", coarse}}),
                            large = region.make({{"resolution", coarse}, {"size", 1.1F}});
        CHECK(skin_of(large).y / skin_of(usual).y == doctest::Approx(1.1).scale(1e-30).epsilon(0.01));
        REQUIRE(large.vessels.size() == usual.vessels.size());
        CHECK(large.anatomy.objects().size() == usual.anatomy.objects().size());
    }
    const auto carotid = [](float size) {
        return anatomy::find_region("neck").make({{"resolution", coarse}, {"size", size}}).vessels.front();
    };
    const anatomy::vessel usual = carotid(1), large = carotid(1.1F);
    CHECK(large.radius() == doctest::Approx(usual.radius()).scale(1e-30).epsilon(0.02));
    CHECK(length(large.line.front().centre) ==
          doctest::Approx(1.1 * length(usual.line.front().centre)).scale(1e-30).epsilon(0.01));
}

TEST_CASE("the same values give the same body") {
    for (const anatomy::region& region : that_vary()) {
        anatomy::values values = region.drawn(7);
        values["resolution"] = coarse;
        const anatomy::body first = region.make(values), second = region.make(values);
        REQUIRE(first.anatomy.objects().size() == second.anatomy.objects().size());
        for (std::size_t i = 0; i < first.anatomy.objects().size(); ++i)
            CHECK(first.anatomy.objects()[i].surface.positions == second.anatomy.objects()[i].surface.positions);
    }
}

TEST_CASE("drawn values are in range, and sizes gather in the middle of it") {
    for (const anatomy::region& region : that_vary())
        for (const anatomy::parameter& one : region.parameters) {
            if (std::string{one.name} == "resolution") continue;
            CAPTURE(std::string{one.name});
            double sum = 0, squares = 0;
            constexpr int count = 400;
            for (int seed = 0; seed < count; ++seed) {
                const float value = region.completed(region.drawn(static_cast<std::uint64_t>(seed))).at(one.name);
                const double part = static_cast<double>((value - one.smallest) / (one.largest - one.smallest));
                sum += part;
                squares += (part - 0.5) * (part - 0.5);
            }
            CHECK(sum / count == doctest::Approx(0.5).scale(1e-30).epsilon(0.1));
            if (!one.is_choice)
                CHECK(squares / count == doctest::Approx(1.0 / 24).scale(1e-30).epsilon(0.2)); // of two uniform ones
        }
}

TEST_CASE("what lists and messages print of a parameter is taken, and is within its range") {
    for (const anatomy::region& region : that_vary())
        for (const anatomy::parameter& one : region.parameters)
            for (const float value : {one.smallest, one.usual, one.largest}) {
                CAPTURE(std::string{region.name});
                CAPTURE(std::string{one.name});
                CAPTURE(value);
                const anatomy::parameter_unit in = one.written_unit();
                const int digits = one.is_choice ? 6 : 4;
                const std::string written = insonify::detail::number_text(value / in.size, digits),
                                  own = insonify::detail::number_text(value, digits);
                for (const std::string& text : {written, written + in.name, own + one.unit}) {
                    const float read = anatomy::values_of(region, {one.name + ("=" + text)}).at(one.name);
                    CAPTURE(text);
                    CHECK(read == doctest::Approx(value).epsilon(5e-4).scale(1e-30));
                    CHECK((read >= one.smallest && read <= one.largest));
                }
                const float completed = region.completed({{one.name, std::stof(own)}}).at(one.name);
                CHECK((completed >= one.smallest && completed <= one.largest));
            }
}

TEST_CASE("words that are no values of parameters are refused with a sentence") {
    const anatomy::region& leg = anatomy::find_region("leg");
    const auto refusal = [&](const std::vector<std::string>& words) -> std::string {
        try {
            anatomy::values_of(leg, words);
        } catch (const usage_error& error) {
            return error.what();
        }
        return "no error";
    };
    CHECK(refusal({"fat"}) == "'fat' is not a name and its value, such as fat=6mm or side=1");
    CHECK(refusal({"fat=6deg"}) == "fat=6deg: '6deg' is not a length, such as 40mm, 4cm or 0.04m");
    CHECK(refusal({"calf_pennation=15mm"}) == "calf_pennation=15mm: '15mm' is not an angle, such as 15deg");
    CHECK(refusal({"side=1mm"}) == "side=1mm: '1mm' is not a number");
    CHECK(refusal({"fat=4", "fat=5"}) == "`fat` is given twice; a body has one value");
    CHECK(refusal({"fat=6cm"}).starts_with("leg: `fat` is 60 mm; it must be from 3 mm to 16 mm: thickness"));
    CHECK(refusal({"thigh_pennation=0.2"})
              .starts_with("leg: `thigh_pennation` is 0.2 deg; it must be from 10 deg to 20 deg: "));
    CHECK(anatomy::values_of(leg, {"thigh_pennation=15deg"}) == anatomy::values_of(leg, {"thigh_pennation=15"}));
}

TEST_CASE("bad parameters and names are refused with a sentence") {
    for (const anatomy::region& region : anatomy::regions()) {
        CHECK(sentence(region, {{"flavour", 1}})
                  .find(region.parameters.empty()
                            ? "there is no parameter 'flavour'; it has none"
                            : "there is no parameter 'flavour'; known are ") != std::string::npos);
        for (const anatomy::parameter& one : region.parameters) {
            CAPTURE(std::string{one.name});
            const std::string start = std::string{region.name} + ": `" + one.name + "` is ";
            for (const float value : {one.smallest - 1, one.largest + 1, std::nanf("")}) {
                const std::string text = sentence(region, {{one.name, value}});
                CHECK(text.starts_with(start));
                CHECK(text.find("it must be ") != std::string::npos);
            }
            if (one.is_choice)
                CHECK(sentence(region, {{one.name, one.smallest + 0.5F}}).find("a whole number") != std::string::npos);
        }
        CHECK_THROWS_AS(region.make({{"resolution", coarse}}).find_view("inside_out"), usage_error);
    }
    CHECK_THROWS_AS(anatomy::find_region("tail"), usage_error);
    // The structs likewise.
    CHECK_THROWS_WITH_AS(
        make(anatomy::leg{.fat = 0.06F}),
        "`fat` is 0.06 m; it must be from 0.003 m to 0.016 m: thickness of the subcutaneous fat of the "
        "thigh; the calf has 0.7 of it",
        usage_error);
    CHECK_THROWS_AS(make(anatomy::neck{.side = 0.5F}), usage_error);
    CHECK_THROWS_AS(make(anatomy::lumbar{.size = 2}), usage_error);
    CHECK_THROWS_AS(make(anatomy::neck{.size = 0}), usage_error);
    CHECK_THROWS_AS(make(anatomy::right_upper_quadrant{.fat = std::nanf("")}), usage_error);
}
