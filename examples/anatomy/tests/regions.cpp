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
        const anatomy::body usual = region.make();
        CHECK(faults_of(usual) + self_intersections_of(usual) == 0);
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
    const pulsation systole{.amplitude = 0.3_mm, .time = 0.15F / 1.2F};
    CHECK(body.motion({.amplitude = 0}, 0).arteries.empty());
    CHECK(body.motion(systole, 5_mmHg).veins.empty()); // their blood has 6
    const anatomy::vessel_motion beat = body.motion(systole, 0), pressed = body.motion({.amplitude = 0}, 20_mmHg);
    CHECK(pressed.veins.size() + beat.arteries.size() == body.vessels.size());
    body.anatomy.build(exec::par);
    for (const anatomy::vessel& one : body.vessels) {
        CAPTURE(one.name);
        const line_place middle = centre_line{one.line}.place(one.line[one.line.size() / 2].centre);
        const vec3 wall = middle.centre + middle.radii.y * middle.second_axis;
        const vec3 above = middle.centre - vec3{0, 0, 1e-4F};
        const float height =
            (pressed(above) - pressed(middle.centre)).z / (above - middle.centre).z; // over that at rest
        if (one.type == anatomy::vessel::kind::artery) {
            // By itself it moves by the share of its radius that the beat has; beside others, with these.
            const anatomy::vessel_motion own = anatomy::motion_of({one}, systole, 0);
            CHECK(length(own(wall) - wall) == doctest::Approx(0.1F * middle.radii.y).scale(1e-30).epsilon(0.01));
            CHECK(height > 0.8F); // a vein beside it closes
        } else {
            CHECK(height < 0.3F); // by 14 mmHg: Shapiro's law
        }
        for (const anatomy::vessel_motion& map : {beat, pressed}) CHECK(length(map.rest_of(map(wall)) - wall) < 1_um);
    }
    body.anatomy.deform(exec::par, body.motion(systole, 20_mmHg));
    body.anatomy.deform(exec::par, anatomy::vessel_motion{});
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
}
