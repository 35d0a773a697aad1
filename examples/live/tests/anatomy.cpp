/// Anatomies from files: the side of the skin, the unit, the background; and recordings that name theirs. live_tests anatomy LIMB.obj
#include "../recording.hpp"
#include <cstdio>

namespace anatomy_test {
namespace {

using namespace insonify;

bool check(bool holds, const std::string& text) {
    std::printf("%s %s\n", holds ? "ok  " : "FAIL", text.c_str());
    return holds;
}

// A box with a small one at its side towards the skin, where the probe must find it.
bool finds_skin(const std::string& side) {
    const std::size_t axis = side[1] == 'x' ? 0 : side[1] == 'y' ? 1 : 2;
    const float sign = side[0] == '+' ? 1.0F : -1.0F;
    std::ofstream file{"sided.obj"};
    std::size_t first = 1;
    const auto add_box = [&](const char* name, const char* tissue, vec3 middle, float half) {
        const mesh body = make_box(middle - half, middle + half);
        file << "o " << name << "\nusemtl " << tissue << '\n';
        for (const vec3& p : body.positions) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
        for (const uvec3& f : body.faces)
            file << "f " << first + f.x << ' ' << first + f.y << ' ' << first + f.z << '\n';
        first += body.positions.size();
    };
    vec3 at{100, 200, 300}; // centimetres, far from the origin
    add_box("body", "muscle", at, 5);
    at[static_cast<int>(axis)] += 4 * sign;
    add_box("mark", "bone", at, 0.5F);
    file.close();
    const live::loaded_anatomy loaded =
        live::load_anatomy({.file = "sided.obj", .unit = 1_cm, .side = side, .skin = 0, .background = "water"});
    const scene& body = loaded.body;
    const std::optional<object_id> mark = body.find("mark");
    const aabb whole = body.box(), small = mark ? body.box(*mark) : aabb{};
    return check(mark && std::fabs(whole.lower.z) < 0.05_mm && std::fabs(whole.upper.z - 100_mm) < 0.05_mm &&
                     std::fabs(small.lower.z - 5_mm) < 0.05_mm && std::fabs(whole.lower.x + 50_mm) < 0.05_mm &&
                     std::fabs(whole.lower.y + 50_mm) < 0.05_mm && body.background() == tissue::water,
                 "skin at " + side + ": the mark is " + std::to_string(small.lower.z / 1_mm) +
                     " mm deep, 5 expected; the body " + std::to_string(whole.lower.x / 1_mm) + ' ' +
                     std::to_string(whole.lower.y / 1_mm) + ' ' + std::to_string(whole.lower.z / 1_mm) + " to " +
                     std::to_string(whole.upper.z / 1_mm));
}

template <class Call>
bool refused(const char* part, const Call& call) {
    try {
        call();
    } catch (const std::exception& fault) {
        return check(std::string{fault.what()}.find(part) != std::string::npos, fault.what());
    }
    return check(false, std::string{"not refused: "} + part);
}

bool without_materials(const std::string& limb) {
    std::ifstream from{limb};
    std::ofstream to{"plain.obj"};
    for (std::string line; std::getline(from, line);)
        if (line.rfind("usemtl", 0) != 0 && line.rfind("o ", 0) != 0) to << line << '\n';
    to.close();
    const scene body = live::load_anatomy({.file = "plain.obj", .tissue = "liver"}).body;
    return check(body.objects().size() == 1 && body.objects()[0].inside == tissue::liver,
                 "faces without materials are of the tissue that is given");
}

// A session on a file, recorded in another folder and replayed from there.
bool recorded(const std::string& limb) {
    std::filesystem::create_directories("recorded/of");
    std::filesystem::copy_file(limb, "recorded/limb copy #1.obj", std::filesystem::copy_options::overwrite_existing);
    const live::anatomy_file of{.file = "recorded/limb copy #1.obj",
                                .side = "-z",
                                .skin = 2_mm,
                                .repair = true,
                                .pennation = -12.5F,
                                .background = "fat"},
        plain{.file = of.file, .skin = 0};
    {
        std::ofstream file{"recorded/of/session.txt"};
        file << live::anatomy_line({of, live::load_anatomy(of).content}, "recorded/of") << "\nframes 2\n";
    }
    const std::string here = live::anatomy_line({of, 1}, ""); // the folder of "session.txt"
    const live::recording read = live::load_recording("recorded/of/session.txt");
    const live::loaded_anatomy loaded = live::load_body({}, &read);
    const live::anatomy_file& found = loaded.file;
    bool holds = check(live::parse_anatomy(here, "").of == of &&
                           live::parse_anatomy(live::anatomy_line({plain, 1}, ""), "").of == plain,
                       here);
    holds = check(std::filesystem::equivalent(found.file, of.file) && found.side == of.side &&
                      found.background == of.background && found.unit == of.unit && found.tissue == of.tissue &&
                      loaded.content == read.body->content,
                  "a recording names its anatomy") &&
            holds;
    // Bits of what is turned differ between processors; the content does not.
    live::anatomy_file turned = of;
    turned.side = "+x";
    holds = check(live::load_anatomy(turned).content == read.body->content,
                  "the content is that of the file, whatever the side of the skin") &&
            holds;
    std::ofstream{of.file, std::ios::app} << "o more\nusemtl fat\nv 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\n"
                                             "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";
    holds = refused("has changed since the session was recorded", [&] { live::load_body({}, &read); }) && holds;
    holds = check(live::load_body({.file = {.file = of.file}}, &read).file.side.empty(),
                  "an anatomy that is given is taken") &&
            holds;
    holds = refused("'repairs' is unknown; repair,",
                    [] { live::parse_anatomy("anatomy 1 0 +x,repairs muscle fat a.obj", ""); }) &&
            holds;
    std::filesystem::remove(of.file);
    holds = refused("cannot be opened", [&] { live::load_body({}, &read); }) && holds;
    return refused("on which the session was recorded, cannot be opened; open it first",
                   [&] { live::load_body({}, &read, "open it first"); }) &&
           holds;
}

// What the body has otherwise than the file is told.
bool tells_names() {
    std::ofstream file{"twins.obj"};
    for (int i = 0; i < 2; ++i)
        file << "o rib\nusemtl bone\nv 0 0 " << 20 * i << "\nv 9 0 " << 20 * i << "\nv 0 9 " << 20 * i << "\nv 0 0 "
             << 20 * i + 9 << "\nf -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";
    file.close();
    const std::string said = live::describe(live::load_anatomy({.file = "twins.obj"}));
    return check(said.find("twins.obj: 2 objects, 9 x 9 x 29 mm") == 0 &&
                     said.find("\ntwins.obj:17: there are several objects of the name 'rib'; this one is called "
                               "'rib.2'") != std::string::npos,
                 said);
}

// What one object encloses gets skin, by default.
bool has_skin(const std::string& limb) {
    const scene covered = live::load_anatomy({.file = limb}).body,
                bare = live::load_anatomy({.file = limb, .skin = 0}).body;
    const aabb box = bare.box();
    const vec3 above = {box.centre().x, box.centre().y, box.lower.z - 1_mm};
    const auto thickness = [&](const scene& body) {
        float sum = 0;
        for (float depth = 0; depth < 10_mm; depth += 0.1_mm)
            if (medium_at(body, above + vec3{0, 0, depth}) == tissue::skin) sum += 0.1_mm;
        return sum;
    };
    const float skin = thickness(covered);
    // The content is that of the file, whatever is added to it.
    const bool same =
        live::load_anatomy({.file = limb}).content == live::load_anatomy({.file = limb, .skin = 0}).content;
    return check(same && thickness(bare) == 0 && std::fabs(skin - 1.5_mm) < 0.4_mm && covered.box().lower == box.lower,
                 "the skin of a limb is " + std::to_string(skin / 1_mm) + " mm thick");
}

// What is open is refused, with what to do, or closed.
bool repairs() {
    std::ofstream{"lid.obj"} << "o lid\nusemtl muscle\nv 0 0 0\nv 40 0 0\nv 40 40 0\nv 0 40 0\nv 20 20 30\n"
                                "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    const live::loaded_anatomy closed = live::load_anatomy({.file = "lid.obj", .repair = true});
    return refused("Or --repair may close it", [] { live::load_anatomy({.file = "lid.obj"}); }) &&
           check(closed.notes.size() == 1 && closed.notes[0].find("Closed 1 hole") != std::string::npos &&
                     validate(closed.body.objects()[0].surface).closed(),
                 closed.notes.empty() ? "nothing was said" : closed.notes[0]);
}

// The pressure around a vein is that of the contact: of the part of the face that is pressed.
bool presses_vein() {
    const auto pressure = [](float left) {
        scene body{tissue::water};
        body.add(make_box({left, -30_mm, 0}, {60_mm, 30_mm, 60_mm}), tissue::muscle, {.name = "skin"});
        body.add(make_cylinder({30_mm, -25_mm, 20_mm}, {30_mm, 25_mm, 20_mm}, 2_mm, 24, 12), tissue::blood,
                 {.name = "vein"});
        live::session one{std::move(body)};
        one.apply({"hold_probe", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 4}}); // 4 mm deep, 38 mm wide
        one.advance(exec::par);
        return one.motion.vessels.veins.at(0).vessel.outside / 3_mmHg;
    };
    const float whole = pressure(-60_mm), half = pressure(0);
    const std::string said = "4 mm deep, the whole face: " + std::to_string(whole) + " times 3 mmHg, half of it " +
                             std::to_string(half) + "; 4 expected";
    return check(std::fabs(whole - 4) < 0.05F && std::fabs(half - 4) < 0.3F, said);
}

} // namespace

int run(const std::string& limb) {
    bool holds = true;
    for (const char* const side : live::sides) holds = finds_skin(side) && holds;
    holds = without_materials(limb) && recorded(limb) && holds;
    holds = has_skin(limb) && tells_names() && repairs() && presses_vein() && holds;
    holds = refused("there is no tissue 'cheese'; known are water",
                    [&] { live::load_anatomy({.file = limb, .background = "cheese"}); }) &&
            holds;
    holds =
        refused("the skin is at 'up'; it must be at +x", [&] { live::load_anatomy({.file = limb, .side = "up"}); }) &&
        holds;
    holds = refused("--unit 1mm", [&] { live::load_anatomy({.file = limb, .unit = 1}); }) && holds;
    holds = refused("a whole number from 1 to 1000000", [] { live::parse_step("frames 2.5"); }) && holds;
    holds = refused("did you mean: frames 3?", [] { live::parse_step("frame 3"); }) && holds;
    return holds ? 0 : 1;
}

} // namespace anatomy_test
