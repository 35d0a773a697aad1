#ifndef INSONIFY_EXAMPLES_LIVE_SESSION_HPP
#define INSONIFY_EXAMPLES_LIVE_SESSION_HPP

#include <insonify/insonify.hpp>
#include "../nerve_block_phantom.hpp"
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

/// A simulator without a window: a scanner, a patient, a probe on the skin and a needle. Events come in, pictures go out.
/// A session is a text file of events, one a line, and gives the same pictures whenever it is replayed.
namespace live {

using namespace insonify;

/// What a user does: a word and its numbers, in the units of `session::help`.
struct event {
    std::string name{};
    std::vector<float> values{};
};

/// Reads an event from a line such as "slide 2 -1"; none from an empty line or a comment, which begins with #.
/// @throws std::invalid_argument  for a word where a number belongs
inline std::optional<event> parse_event(const std::string& line) {
    std::istringstream text{line.substr(0, line.find('#'))};
    event read;
    if (!(text >> read.name)) return std::nullopt;
    for (std::string word; text >> word;) {
        char* end = nullptr;
        read.values.push_back(std::strtof(word.c_str(), &end));
        if (end != word.c_str() + word.size() || !is_finite(read.values.back()))
            throw std::invalid_argument{read.name + ": '" + word + "' is not a number"};
    }
    return read;
}

/// The inverse of `parse_event`: a line without its end. Numbers are written exactly.
inline std::string event_line(const event& one) {
    std::ostringstream text;
    text.precision(9);
    text << one.name;
    for (const float value : one.values) text << ' ' << value;
    return text.str();
}

/// The needle: where it enters the skin, and how far it has advanced.
struct needle_state {
    std::uint32_t gauge = 22;
    float bevel = 15_deg;
    vec3 entry{-24_mm, 0, 0.4_mm}; ///< in the world
    float steepness = 30_deg;      ///< angle to the skin
    float aside = 0;               ///< angle to the x axis
    float inserted = 0;            ///< metres from the skin to the tip
    std::optional<pose> held{};    ///< pose by a tracker, which replaces the four members above

    pose at() const {
        if (held) return *held;
        const pose from_entry = nerve_block::needle_at(entry, steepness, aside);
        return {from_entry.rotation, entry + inserted * from_entry.direction({0, 0, 1})};
    }
};

/// The hand on the probe.
struct hand_state {
    vec2 on_skin{0, 0};         ///< x, y in the world
    float tilt = 0;             ///< about the array: the slice sweeps along y
    float rock = 0;             ///< in the slice plane
    float rotate = 0;           ///< about the axis of the probe
    float gel = 0.4_mm;         ///< between the face and the skin
    std::optional<pose> held{}; ///< pose by a tracker, which replaces the members above
};

/// The simulator.
class session {
  public:
    /// @param patient  built or not; an object named "needle" is replaced by the session's, one named "gel" is no skin
    explicit session(scene patient = nerve_block_phantom()) : body{std::move(patient)} {
        machine.probe = nerve_block::probe;
        machine.settings = nerve_block::settings;
        machine.cine_length = 32;
        renew_needle();
    }

    /// Applies an event.
    /// @throws std::invalid_argument  for an unknown name or a wrong number of values; the session is unchanged
    void apply(const event& one) {
        const auto known = actions().find(one.name);
        if (known == actions().end()) throw std::invalid_argument{"there is no event '" + one.name + "'"};
        if (one.values.size() != known->second.values)
            throw std::invalid_argument{one.name + " takes " + std::to_string(known->second.values) +
                                        " numbers: " + known->second.help};
        known->second.run(*this, one.values.data());
    }

    /// The next picture; 1 / 30 s after the last one.
    template <exec::policy Policy>
    const image& frame(const Policy& policy) {
        if (!machine.frozen()) {
            machine.time += 1.0 / 30;
            ++machine.settings.frame;
        }
        const image& seen = machine.scan(policy, body, probe_pose());
        if (!machine.frozen()) sweep.add(machine.lines(), machine.lines().count / 2);
        return seen;
    }

    /// The probe on the skin.
    pose probe_pose() const {
        if (hand.held) return *hand.held;
        const auto is_skin = [&](object_id id) { return id != needle_id && body[id].name != "gel"; };
        const aabb box = body.box();
        const std::optional<surface_point> skin = first_surface(
            body, {.origin = {hand.on_skin.x, hand.on_skin.y, box.lower.z - 1_mm}, .direction = {0, 0, 1}}, is_skin);
        const float z = skin ? skin->point.z : 0;
        const vec3 down{std::sin(hand.rock), std::sin(hand.tilt), std::cos(hand.rock) * std::cos(hand.tilt)};
        const vec3 from{hand.on_skin.x, hand.on_skin.y, z - hand.gel};
        return look_at(from, from + down, {std::cos(hand.rotate), std::sin(hand.rotate), 0});
    }

    /// Names, numbers and units of all events, one a line.
    static std::string help() {
        std::string text;
        for (const auto& [name, one] : actions()) text += name + ": " + one.help + "\n";
        return text;
    }

    scene body;
    scanner<linear_array> machine{};
    m_mode sweep{{.columns = 256, .rows = 256}}; ///< the middle line
    hand_state hand{};
    needle_state needle{};
    object_id needle_id{};
    std::vector<float> measured{}; ///< metres, by "measure", in order

  private:
    struct action {
        std::size_t values;
        std::string help;
        std::function<void(session&, const float*)> run;
    };

    // A needle of another size is another mesh.
    void renew_needle() {
        if (const std::optional<object_id> old = body.find("needle")) body.remove(*old);
        needle_id = body.add(make_needle(needle_diameter(needle.gauge), 80_mm, {.bevel = needle.bevel}), tissue::steel,
                             {.priority = 2, .at = needle.at(), .name = "needle", .crease_angle = 0.8F * needle.bevel});
        body.build(exec::par);
    }
    void place_needle() { body.place(needle_id, needle.at()); }

    // Nine numbers of the rotation by columns, then the translation in mm.
    static pose pose_of(const float* v) {
        const pose at{{vec3{v[0], v[1], v[2]}, vec3{v[3], v[4], v[5]}, vec3{v[6], v[7], v[8]}},
                      1e-3F * vec3{v[9], v[10], v[11]}};
        if (!is_rigid(at))
            throw std::invalid_argument{"the twelve numbers do not form a rigid transform: the columns of a "
                                        "rotation, then x, y and z in mm"};
        return at;
    }

    static const std::map<std::string, action>& actions() {
        constexpr float mm = 1e-3F, degree = pi / 180;
        static const std::map<std::string, action> all{
            {"slide",
             {2, "the probe on the skin, mm along x and y",
              [](session& s, const float* v) {
                  s.hand.on_skin += mm * vec2{v[0], v[1]};
              }}},
            {"tilt",
             {1, "the probe out of the slice, degrees",
              [](session& s, const float* v) {
                  s.hand.tilt = clamp(s.hand.tilt + degree * v[0], -60 * degree, 60 * degree);
              }}},
            {"rock",
             {1, "the probe in the slice, degrees",
              [](session& s, const float* v) {
                  s.hand.rock = clamp(s.hand.rock + degree * v[0], -60 * degree, 60 * degree);
              }}},
            {"rotate",
             {1, "the probe about its axis, degrees",
              [](session& s, const float* v) { s.hand.rotate += degree * v[0]; }}},
            {"press",
             {1, "the probe into the gel, mm",
              [](session& s, const float* v) { s.hand.gel = clamp(s.hand.gel - mm * v[0], 0.05F * mm, 5 * mm); }}},
            {"gauge",
             {1, "of the needle, 18 to 25",
              [](session& s, const float* v) {
                  s.needle.gauge = static_cast<std::uint32_t>(clamp(std::round(v[0]), 18, 25));
                  s.renew_needle();
              }}},
            {"bevel",
             {1, "of the needle, degrees, 10 to 60",
              [](session& s, const float* v) {
                  s.needle.bevel = degree * clamp(v[0], 10, 60);
                  s.renew_needle();
              }}},
            {"entry",
             {2, "of the needle on the skin, mm",
              [](session& s, const float* v) {
                  s.needle.entry = {mm * v[0], mm * v[1], s.needle.entry.z};
                  s.place_needle();
              }}},
            {"steepness",
             {1, "of the needle, degrees to the skin",
              [](session& s, const float* v) {
                  s.needle.steepness = degree * clamp(v[0], 5, 85);
                  s.place_needle();
              }}},
            {"aside",
             {1, "direction of the needle, degrees to the x axis",
              [](session& s, const float* v) {
                  s.needle.aside = degree * v[0];
                  s.place_needle();
              }}},
            {"advance",
             {1, "the needle, mm; negative: withdraw",
              [](session& s, const float* v) {
                  s.needle.inserted = clamp(s.needle.inserted + mm * v[0], -20 * mm, 60 * mm);
                  s.place_needle();
              }}},
            {"hold_probe",
             {12, "pose by a tracker: columns of the rotation, then mm in the world",
              [](session& s, const float* v) { s.hand.held = pose_of(v); }}},
            {"hold_needle",
             {12, "pose by a tracker, as hold_probe: the tip, z along the needle",
              [](session& s, const float* v) {
                  s.needle.held = pose_of(v);
                  s.place_needle();
              }}},
            {"release",
             {0, "probe and needle return to the hand",
              [](session& s, const float*) {
                  s.hand.held.reset();
                  s.needle.held.reset();
                  s.place_needle();
              }}},
            {"gain", {1, "dB", [](session& s, const float* v) { s.machine.settings.gain_db = clamp(v[0], -60, 60); }}},
            {"dynamic_range",
             {1, "dB", [](session& s, const float* v) { s.machine.settings.dynamic_range_db = clamp(v[0], 20, 120); }}},
            {"depth",
             {1, "of the picture, mm",
              [](session& s, const float* v) { s.machine.settings.depth = mm * clamp(v[0], 10, 150); }}},
            {"focus", {1, "mm", [](session& s, const float* v) { s.machine.probe.focus = mm * clamp(v[0], 5, 150); }}},
            {"frequency",
             {1, "MHz", [](session& s, const float* v) { s.machine.probe.frequency = 1e6F * clamp(v[0], 2, 15); }}},
            {"lines",
             {1, "of the probe",
              [](session& s, const float* v) {
                  s.machine.probe.lines = static_cast<std::uint32_t>(clamp(v[0], 16, 512));
              }}},
            {"planes",
             {1, "of the slice: 1, 3, 5 or 7",
              [](session& s, const float* v) {
                  s.machine.settings.planes = 1 + 2 * static_cast<std::uint32_t>(clamp((v[0] - 1) / 2, 0, 3));
              }}},
            {"slider",
             {2, "time gain: number 0 to 7, dB",
              [](session& s, const float* v) {
                  s.machine.settings.time_gain.sliders[static_cast<std::size_t>(clamp(v[0], 0, 7))] =
                      clamp(v[1], -40, 40);
              }}},
            {"compound",
             {1, "number of looks, 1 to 9; each frame acquires one",
              [](session& s, const float* v) {
                  s.machine.settings.compound = {.angles = static_cast<std::uint32_t>(clamp(v[0], 1, 9)),
                                                 .spread = 16 * degree,
                                                 .update = compound_settings::update::one};
              }}},
            {"persistence",
             {1, "0 to 0.95",
              [](session& s, const float* v) { s.machine.settings.persistence = clamp(v[0], 0, 0.95F); }}},
            {"width",
             {1, "of the picture, pixels",
              [](session& s, const float* v) {
                  s.machine.settings.size = {static_cast<std::uint32_t>(clamp(v[0], 16, 4096)), 0};
              }}},
            {"freeze", {0, "the picture", [](session& s, const float*) { s.machine.freeze(); }}},
            {"unfreeze", {0, "goes on", [](session& s, const float*) { s.machine.unfreeze(); }}},
            {"cine",
             {1, "shows a frame while frozen: 0 is the last one",
              [](session& s, const float* v) {
                  if (s.machine.frozen() && !s.machine.cine().empty())
                      s.machine.show(exec::par_unseq, static_cast<std::uint32_t>(clamp(
                                                          v[0], 0, static_cast<float>(s.machine.cine().size() - 1))));
              }}},
            {"measure",
             {4, "distance between two pixels: x y x y",
              [](session& s, const float* v) {
                  s.measured.push_back(distance(s.machine.map(), {v[0], v[1]}, {v[2], v[3]}));
              }}},
        };
        return all;
    }
};

/// A hash of a picture, of every bit (FNV-1a).
inline std::uint64_t hash_of(const image& picture) {
    std::uint64_t hash = 14695981039346656037U;
    for (const float pixel : picture.pixels) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &pixel, sizeof bits);
        for (int byte = 0; byte < 4; ++byte) hash = (hash ^ (bits >> 8 * byte & 0xFFU)) * 1099511628211U;
    }
    return hash;
}

} // namespace live

#endif
