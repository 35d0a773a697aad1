/// The session behind the web page, as C functions. Texts are UTF-8; those that are returned, and pictures, are valid until
/// the next call of the same function. Functions that can fail return the reason, which is empty on success.
#include "../appearance.hpp"
#include "../loop.hpp"
#include "json.hpp"
#include <emscripten/emscripten.h>
#include <memory>

namespace {

using namespace insonify;

std::unique_ptr<live::session> now = std::make_unique<live::session>();
live::loaded_anatomy recorded; // of the recording that was read last
std::uint32_t frames = 0;
live::session_clock passing;
std::vector<float> part_opacities;

// Runs a function that may throw.
template <class Function>
const char* attempt(const Function& function) {
    static std::string fault;
    fault.clear();
    try {
        function();
    } catch (const std::exception& refused) {
        fault = refused.what();
    }
    return fault.c_str();
}

void put_pixel(std::vector<std::uint8_t>& bytes, vec3 colour, bool is_seen = true) {
    for (int i = 0; i < 3; ++i) bytes.push_back(static_cast<std::uint8_t>(255 * clamp(colour[i], 0, 1) + 0.5F));
    bytes.push_back(is_seen ? 255 : 0);
}

// The event of a part of a control, such as "slider 3".
std::string part_event(const live::control& one, std::uint32_t part) {
    return std::string{one.event} + ' ' + std::to_string(part);
}

live::json_object shown(const live::control& one) {
    live::json_list choices;
    for (const live::literal& name : one.choices) choices.add(live::json_object{}.add("name", name));
    live::json_object shown;
    shown.add("unit", one.unit).add("low", one.low).add("high", one.high).add("step", one.step);
    shown.add("relative", one.is_relative).add("choices", choices);
    return shown;
}

// A mesh: its name, colour and opacity, the addresses of its coordinates and corners, and their numbers.
const char* shown(const object& one, float opacity, const pose& at) {
    static std::string text;
    static mesh shape;
    shape = one.surface;
    for (vec3& point : shape.positions) point = at.point(point);
    live::json_object part;
    part.add("name", one.name)
        .add("opacity", opacity)
        .add("cut", live::is_cut(one))
        .add("colour", std::array{live::colour_of(one)});
    part.add("positions", reinterpret_cast<std::uintptr_t>(shape.positions.data()))
        .add("points", shape.positions.size());
    part.add("faces", reinterpret_cast<std::uintptr_t>(shape.faces.data())).add("triangles", shape.faces.size());
    return (text = part.text()).c_str();
}

} // namespace

extern "C" {

/// Starts again with the first case, or with what the recording that was read last begins with.
EMSCRIPTEN_KEEPALIVE void live_restart(bool with_recorded) {
    now = std::make_unique<live::session>(live::begin_session(with_recorded ? recorded : live::loaded_anatomy{}));
}

/// Starts again with an OBJ file that has been written into the file system, and stays there for recordings.
/// @param unit   length of 1 in the file, metres
/// @param side   the side of the skin, one of `live::sides`
/// @param skin   its thickness, metres
/// @param repair, pennation  see `live::anatomy_file`
/// @return  JSON: `fault`, and `notes` of `load_obj_scene`, a line each
EMSCRIPTEN_KEEPALIVE const char* live_load(const char* path, float unit, int side, float skin, bool repair,
                                           float pennation, const char* tissue, const char* background) {
    static std::string text;
    std::string notes;
    const std::string fault = attempt([&] {
        live::loaded_anatomy loaded = live::load_anatomy({.file = path,
                                                          .unit = unit,
                                                          .side = live::sides[std::clamp(side, 0, 5)],
                                                          .skin = skin,
                                                          .repair = repair,
                                                          .pennation = pennation,
                                                          .tissue = tissue,
                                                          .background = background},
                                                         "1 in the file is 1 ", "'Close open surfaces'");
        for (const std::string& note : loaded.notes) notes += note + '\n';
        now = std::make_unique<live::session>(live::begin_session(std::move(loaded)));
    });
    return (text = live::json_object{}.add("fault", fault).add("notes", notes).text()).c_str();
}

/// Applies an event, such as "slide 2 -1".
EMSCRIPTEN_KEEPALIVE const char* live_apply(const char* line) {
    return attempt([&] {
        const std::optional<live::event> one = live::parse_event(line);
        if (!one) return;
        now->apply(*one);
    });
}

/// Draws the next picture: see `live_pixels`.
/// @param live  the session's time passes as time does; else as a recorded session says
EMSCRIPTEN_KEEPALIVE const char* live_frame(bool live) {
    return attempt([live] {
        if (live && !now->machine.frozen())
            passing.follow(*now);
        else
            passing.pause();
        now->frame(exec::par_unseq);
        ++frames;
    });
}

/// Red, green, blue and opacity of each pixel of the last picture, row by row from the top; beside a sector it is transparent.
EMSCRIPTEN_KEEPALIVE const std::uint8_t* live_pixels() {
    static std::vector<std::uint8_t> bytes;
    bytes.clear();
    const std::vector<vec3>& pixels = now->screen().pixels;
    for (std::size_t i = 0; i < pixels.size(); ++i) put_pixel(bytes, pixels[i], live::is_seen(now->machine, i));
    return bytes.data();
}

/// The same of the M-mode or the spectrum beside the picture; of no size in other modes.
EMSCRIPTEN_KEEPALIVE const std::uint8_t* live_strip() {
    static std::vector<std::uint8_t> bytes;
    bytes.clear();
    for (const float level : now->strip().pixels) put_pixel(bytes, vec3{level});
    return bytes.data();
}

/// What is known of the last picture, as JSON: lengths in metres, poses as matrices of four columns.
EMSCRIPTEN_KEEPALIVE const char* live_state() {
    static std::string text;
    const scanner<live::array_probe>& machine = now->machine;
    const uvec2 size = machine.picture().size;
    const auto right = static_cast<float>(size.x), bottom = static_cast<float>(size.y);
    live::json_object state;
    state.add("frame", frames).add("body", now->bodies).add("width", size.x).add("height", size.y);
    state.add("pitch", machine.map().pitch.y).add("top", machine.map().point({0, 0}).y); // pixels are square
    state.add("focus", machine.probe.focus);
    state.add("frozen", machine.frozen()).add("interval", 1e3 * now->ticks * live::session::tick);
    state.add("probe", machine.at())
        .add("needle", now->needle.at())
        .add("needle_id", static_cast<std::uint32_t>(now->needle_id))
        .add("entry", std::array{now->needle.entry});
    state.add("corners", std::array{machine.point({0, 0}), machine.point({right, 0}), machine.point({right, bottom}),
                                    machine.point({0, bottom})});
    state.add("outline", live::field_of_view(machine));
    const live::strip_scale axes = now->strip_axes();
    live::json_object strip, values;
    strip.add("width", now->strip().size.x).add("height", now->strip().size.y).add("upper", axes.upper);
    strip.add("lower", axes.lower).add("unit", axes.unit).add("seconds", axes.seconds);
    for (const live::control& one : live::controls())
        if (one.value != nullptr)
            values.add(one.event, one.value(*now));
        else
            for (std::uint32_t part = 0; part < one.parts; ++part)
                values.add(part_event(one, part), one.part_value(*now, part));
    live::json_list legend;
    for (const live::legend_entry& one : now->legend())
        legend.add(live::json_object{}.add("name", one.name).add("colour", std::array{one.colour}));
    if (now->shows_measurement) {
        const live::measurement& last = now->measured.back();
        live::json_list points;
        for (const vec2& p : last.points) points.add(live::json_object{}.add("x", p.x).add("y", p.y));
        state.add("measured", live::json_object{}
                                  .add("points", points)
                                  .add("closed", last.closed)
                                  .add("text", live::measured_text(last)));
    }
    state.add("strip", strip).add("values", values).add("legend", legend);
    return (text = state.text()).c_str();
}

/// The controls of the page, as JSON: those that have a value, of which the time gain has eight.
EMSCRIPTEN_KEEPALIVE const char* live_controls() {
    static std::string text;
    live::json_list all;
    const auto add = [&](const live::control& one, const std::string& event, const char* group,
                         const std::string& title, const std::string& tooltip, float value) {
        all.add(shown(one)
                    .add("event", event)
                    .add("group", group)
                    .add("title", title)
                    .add("tooltip", tooltip)
                    .add("value", value));
    };
    for (const live::control& one : live::controls())
        if (one.value != nullptr)
            add(one, one.event, one.group.c_str(), one.title, one.tooltip, one.value(*now));
        else // sliders of the time gain
            for (std::uint32_t i = 0; i < one.parts; ++i)
                add(one, part_event(one, i), one.title.c_str(),
                    i == 0               ? "Near"
                    : i + 1 == one.parts ? "Far"
                                         : "",
                    "Gain at " + std::to_string(i) + " / 7 of the depth", one.part_value(*now, i));
    return (text = all.text()).c_str();
}

/// A recorded session in the file system, as JSON: its steps, or the reason why it cannot be played. Its anatomy must be there.
EMSCRIPTEN_KEEPALIVE const char* live_recording(const char* path) {
    static std::string text;
    live::json_list steps;
    const char* const fault = attempt([&] {
        live::recording read = live::load_recording(path);
        if (read.body) read.body->of.file.erase(0, read.body->of.file.rfind('/') + 1);
        recorded = live::load_body({}, &read, "open the file of that time first");
        for (const live::step& one : read.steps)
            steps.add(live::json_object{}
                          .add("frames", one.frames)
                          .add("event", one.what ? live::event_line(*one.what) : ""));
    });
    return (text = live::json_object{}.add("fault", std::string{fault}).add("steps", steps).text()).c_str();
}

/// Whether the probe began at the origin of the world: on a case.
EMSCRIPTEN_KEEPALIVE bool live_begins() { return now->case_number.has_value(); }

/// Number of objects; the needle and the gel are among them.
EMSCRIPTEN_KEEPALIVE std::uint32_t live_parts() {
    part_opacities = live::opacities(now->body);
    return static_cast<std::uint32_t>(part_opacities.size());
}

/// An object of the anatomy as JSON, see `shown`; empty for the needle and the gel. Call `live_parts` before.
EMSCRIPTEN_KEEPALIVE const char* live_part(std::uint32_t index) {
    const object& one = now->body.objects()[index];
    return live::is_tool(one) ? "" : shown(one, part_opacities[index], one.at);
}

/// The same of the head of the probe, in its own coordinates.
EMSCRIPTEN_KEEPALIVE const char* live_probe() {
    return shown({.surface = live::make_probe_body(now->machine.probe)}, 1, pose{});
}

/// The same of the needle, in its own coordinates.
EMSCRIPTEN_KEEPALIVE const char* live_needle() { return shown(now->body[now->needle_id], 1, pose{}); }

/// Names of all tissues, separated by spaces.
EMSCRIPTEN_KEEPALIVE const char* live_tissues() {
    static std::string text;
    text.clear();
    for (const tissue::named_medium& one : tissue::all) text += std::string{text.empty() ? "" : " "} + one.name;
    return text.c_str();
}

/// The instruction set that the library was compiled for.
EMSCRIPTEN_KEEPALIVE const char* live_instructions() {
#define LIVE_TEXT(word) LIVE_WORD(word)
#define LIVE_WORD(word) #word
    return LIVE_TEXT(INSONIFY_ABI);
}
}
