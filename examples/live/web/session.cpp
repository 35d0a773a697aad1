/// The session behind the web page, as C functions. Texts are UTF-8; those that are returned, and pictures, are valid until
/// the next call of the same function. Functions that can fail return the reason, which is empty on success.
#include "../anatomy.hpp"
#include "json.hpp"
#include <emscripten/emscripten.h>
#include <memory>

namespace {

using namespace insonify;

std::unique_ptr<live::session> now = std::make_unique<live::session>();
std::uint32_t needles = 0; // changes with the mesh of the needle
std::uint32_t frames = 0;

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

void put_pixel(std::vector<std::uint8_t>& bytes, vec3 colour) {
    for (int i = 0; i < 3; ++i) bytes.push_back(static_cast<std::uint8_t>(255 * clamp(colour[i], 0, 1) + 0.5F));
    bytes.push_back(255);
}

mesh needle_mesh() { return make_needle(needle_diameter(now->needle.gauge), 80_mm, {.bevel = now->needle.bevel}); }

} // namespace

extern "C" {

/// Starts again with the phantom.
EMSCRIPTEN_KEEPALIVE void live_restart() {
    now = std::make_unique<live::session>();
    ++needles;
}

/// Starts again with an OBJ file that has been written into the file system.
/// @param unit   length of 1 in the file, metres
/// @param side   the side of the skin, one of `live::sides`
EMSCRIPTEN_KEEPALIVE const char* live_load(const char* path, float unit, int side, const char* tissue,
                                           const char* background) {
    return attempt([&] {
        now = std::make_unique<live::session>(live::load_anatomy({.file = path,
                                                                  .unit = unit,
                                                                  .skin = live::sides[std::clamp(side, 0, 5)],
                                                                  .tissue = tissue,
                                                                  .background = background}));
        ++needles;
    });
}

/// Applies an event, such as "slide 2 -1".
EMSCRIPTEN_KEEPALIVE const char* live_apply(const char* line) {
    return attempt([&] {
        const std::optional<live::event> one = live::parse_event(line);
        if (!one) return;
        now->apply(*one);
        if (one->name == "gauge" || one->name == "bevel") ++needles;
    });
}

/// Draws the next picture: see `live_pixels`.
EMSCRIPTEN_KEEPALIVE const char* live_frame() {
    return attempt([] {
        now->frame(exec::par_unseq);
        ++frames;
    });
}

/// Red, green, blue and opacity of each pixel of the last picture, row by row from the top.
EMSCRIPTEN_KEEPALIVE const std::uint8_t* live_pixels() {
    static std::vector<std::uint8_t> bytes;
    bytes.clear();
    for (const vec3& pixel : now->screen().pixels) put_pixel(bytes, pixel);
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
    const scanner<linear_array>& machine = now->machine;
    const uvec2 size = machine.picture().size;
    const auto right = static_cast<float>(size.x), bottom = static_cast<float>(size.y);
    live::json_object state;
    state.add("frame", frames).add("width", size.x).add("height", size.y);
    state.add("pitch", machine.map().pitch.y).add("top", machine.map().point({0, 0}).y); // pixels are square
    state.add("depth", machine.settings.depth).add("focus", machine.probe.focus).add("span", machine.probe.width);
    state.add("frozen", machine.frozen()).add("cine", machine.cine().size()).add("seconds", machine.times().total);
    state.add("probe", machine.at()).add("needle", now->needle.at()).add("needles", needles);
    state.add("corners", std::array{machine.point({0, 0}), machine.point({right, 0}), machine.point({right, bottom}),
                                    machine.point({0, bottom})});
    const live::strip_scale axes = now->strip_axes();
    live::json_object strip, values;
    strip.add("width", now->strip().size.x).add("height", now->strip().size.y).add("upper", axes.upper);
    strip.add("lower", axes.lower).add("unit", axes.unit).add("seconds", axes.seconds);
    for (const live::control& one : live::controls())
        if (one.value != nullptr) values.add(one.event, one.value(*now));
    live::json_list legend;
    for (const live::legend_entry& one : now->legend())
        legend.add(live::json_object{}.add("name", one.name).add("colour", std::array{one.colour}));
    state.add("strip", strip).add("values", values).add("legend", legend);
    return (text = state.text()).c_str();
}

/// The controls of the page that have a value, as JSON.
EMSCRIPTEN_KEEPALIVE const char* live_controls() {
    static std::string text;
    live::json_list all;
    for (const live::control& one : live::controls()) {
        if (one.value == nullptr) continue;
        live::json_list choices;
        for (const std::string& name : one.choices) choices.add(live::json_object{}.add("name", name));
        live::json_object shown;
        shown.add("event", one.event).add("group", one.group).add("title", one.title).add("unit", one.unit);
        shown.add("tooltip", one.tooltip).add("low", one.low).add("high", one.high).add("step", one.step);
        shown.add("relative", one.is_relative).add("value", one.value(*now)).add("choices", choices);
        all.add(shown);
    }
    return (text = all.text()).c_str();
}

/// Number of objects; the needle and the gel are among them.
EMSCRIPTEN_KEEPALIVE std::uint32_t live_parts() { return static_cast<std::uint32_t>(now->body.objects().size()); }

/// A mesh as JSON: its name, the addresses of its coordinates and corners, and their numbers.
EMSCRIPTEN_KEEPALIVE const char* live_part(std::uint32_t index) {
    static std::string text;
    static mesh shape;
    const object& one = now->body.objects()[index];
    const bool is_needle = one.id == now->needle_id;
    shape = is_needle ? needle_mesh() : one.surface;
    if (!is_needle)
        for (vec3& point : shape.positions) point = one.at.point(point);
    const aabb box = now->body.box(one.id);
    live::json_object part;
    part.add("name", one.name).add("is_needle", is_needle).add("width", box.upper.x - box.lower.x);
    part.add("tissue", live::tissue_name(one.inside));
    part.add("positions", reinterpret_cast<std::uintptr_t>(shape.positions.data()))
        .add("points", shape.positions.size());
    part.add("faces", reinterpret_cast<std::uintptr_t>(shape.faces.data())).add("triangles", shape.faces.size());
    return (text = part.text()).c_str();
}

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
