#ifndef INSONIFY_EXAMPLES_LIVE_SESSION_HPP
#define INSONIFY_EXAMPLES_LIVE_SESSION_HPP

#include "cases.hpp"
#include "control.hpp"
#include "doppler.hpp"
#include "event.hpp"
#include "patient.hpp"
#include "screen.hpp"
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

/// A simulator without a window: a scanner, a patient, a probe on the skin and a needle. Events come in, pictures go out.
///
///     live::session one;                     // or session{scene}, of a body of your own: see `load_anatomy` (anatomy.hpp)
///     one.apply({"case", {1}});              // another body with its probe: `cases` (cases.hpp)
///     one.apply({"depth", {50}});            // events: `controls()` (controls.hpp) has them all, with ranges and values
///     one.frame(exec::par_unseq);            // the next picture: gray
///     one.screen();                          // the same in colour, with Doppler, labels, box and gate
///     one.strip(); one.strip_axes();         // beside it: M-mode, or the Doppler spectrum; empty in other modes
///     one.legend();                          // names and colours of the labels
///     one.measured;                          // by "measure" and "area"
///
/// A session is a text file of events (recording.hpp), and gives the same pictures whenever it is replayed.
namespace live {

/// What the edges of `session::strip` mean.
struct strip_scale {
    float upper = 0, lower = 0; ///< of the upper and lower edge
    std::string unit{};         ///< mm or cm/s
    float seconds = 0;          ///< from the left to the right edge
};

/// A distance or an area, measured in the picture.
struct measurement {
    std::vector<vec2> points{}; ///< pixel coordinates in the picture
    bool closed = false;        ///< an outline, whose area is measured
    float length = 0;           ///< metres: of the distance, or around the outline
    float area = 0;             ///< square metres, of the outline
};

/// What is written beside it.
inline std::string measured_text(const measurement& one) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f %s", static_cast<double>(one.closed ? 1e6F * one.area : 1e3F * one.length),
                  one.closed ? "mm2" : "mm");
    return text;
}

/// The simulator.
class session : public patient {
  public:
    static constexpr double tick = 1.0 / 120;                                       ///< of the session's clock, seconds
    static constexpr std::uint32_t usual_ticks = 4;                                 ///< of a frame: 30 frames a second
    static constexpr std::uint32_t max_ticks = 120;                                 ///< of a frame
    static constexpr float frame_interval = usual_ticks * static_cast<float>(tick); ///< of a usual frame, seconds
    static constexpr std::uint32_t ticks_of_m_column = 4;                           ///< of the M-mode
    static constexpr std::size_t max_measures = 64;                                 ///< the oldest are forgotten

    /// Begins with the first case.
    session() : session{examine(cases[0], 0, {})} { case_number = 0; }
    /// Begins with a body of its own. @param anatomy  see `patient`
    explicit session(scene anatomy) : session{examine(std::move(anatomy))} {}

    /// Opens a case: another body with its probe, its settings and its needle. What belongs to a body ends: measurements, a frozen
    /// picture, a tracker that holds the probe. Lines, planes and size of the picture stay, and so does the heart.
    /// @param number   see `cases`
    /// @param drawn    patient: see `examine`
    void open(std::uint32_t number, std::uint32_t drawn);

    /// Applies an event. Numbers out of range are clamped. The work is done with the next frame: of many events before it, only
    /// the last values cost time.
    /// @throws std::invalid_argument  for an unknown name, a wrong number of values, or values that are not finite; the
    ///                                session is unchanged
    void apply(const event& one);

    /// The next picture; `ticks` after the last one.
    template <exec::policy Policy>
    const image& frame(const Policy& policy);
    /// The time of a frame passes, but nothing is drawn.
    template <exec::policy Policy>
    void advance(const Policy& policy);

    const colour_image& screen() const { return screen_; } ///< the last picture with overlays
    const image& strip() const {
        return shown == mode::pulsed ? doppler.spectrum() : shown == mode::m ? m_picture_ : no_strip_;
    } ///< M-mode or spectrum, newest on the right; of no size in other modes
    strip_scale strip_axes() const;
    const std::vector<legend_entry>& legend() const { return legend_; } ///< of the labels on the screen

    /// The probe on the skin.
    pose probe_pose() const { return patient::probe_pose(hand, machine.probe); }

    /// Where a slide brings the probe: not beyond the edges of the body.
    vec2 slid(vec2 way) const {
        const aabb whole = box();
        const vec2 wanted = hand.on_skin + way;
        return {std::clamp(wanted.x, whole.lower.x, whole.upper.x), std::clamp(wanted.y, whole.lower.y, whole.upper.y)};
    }

    /// Names, numbers and units of all events, one a line.
    static std::string help();

    /// Distance of the needle's tip to the nearest surface of an object, metres; negative inside; none if there is no such
    /// object.
    std::optional<float> tip_distance(const std::string& object_name) const {
        const std::optional<object_id> id = body.find(object_name);
        const std::optional<surface_point> nearest = id ? nearest_surface(body, *id, needle.tip()) : std::nullopt;
        if (!nearest) return std::nullopt;
        return dot(needle.tip() - nearest->point, nearest->normal) < 0 ? -nearest->distance : nearest->distance;
    }

    // What events change; see control.hpp.
    std::optional<std::uint32_t> case_number{}; ///< see `cases`; none: a body of its own
    std::uint32_t patient_number = 0;           ///< see `examine`
    region_parameters given{};                  ///< of all bodies of that region
    std::uint32_t bodies = 0;                   ///< that it has examined so far
    examined view{};                            ///< settings and probe of the present one, without its body
    scanner<array_probe> machine{};
    m_mode sweep{{.columns = 256, .rows = 256}};
    hand_state hand{};
    needle_state needle{};
    doppler_unit doppler{};
    mode shown = mode::b;
    std::uint32_t preset = 0;
    bool shows_labels = false;
    float m_side = 0;                         ///< the line of the M-mode, metres across at half the depth
    pulsation beat{.amplitude = 0.3_mm};      ///< of an artery of 3 mm radius; the flow follows its rate
    std::uint32_t ticks = usual_ticks;        ///< that pass with each frame
    std::vector<measurement> measured{};      ///< by "measure" and "area", the latest last
    bool shows_measurement = false;           ///< the latest one belongs to the present picture
    std::optional<std::uint32_t> cine_back{}; ///< the stored frame to show next, while frozen
    recorder* record = nullptr;               ///< if set, events and frames are written there

    void renew_needle() { needle_change_ = change::shape; }                           ///< with the next frame
    void place_needle() { needle_change_ = std::max(needle_change_, change::place); } ///< with the next frame
    void add_measurement(measurement one) {
        if (measured.size() == max_measures) measured.erase(measured.begin());
        measured.push_back(std::move(one));
        shows_measurement = true;
    }
    void show_mode(mode next) {
        if (shown == next) return;
        shown = next;
        doppler.clear();
    }

  private:
    enum class change { none, place, shape };

    explicit session(examined begun);
    void begin(examined next);
    void place_doppler();

    template <exec::policy Policy>
    void draw_screen(const Policy& policy, const image& gray);
    void add_m_columns();
    void follow_needle() {
        if (needle_change_ == change::shape) renew_tools(needle, machine.probe);
        if (needle_change_ == change::place) body.place(needle_id, needle.at());
        needle_change_ = change::none;
    }

    change needle_change_ = change::none;
    std::uint32_t m_ticks_ = 0; // since the newest column of the M-mode
    uvec2 shown_size_{0, 0};    // of the last picture
    vec2 shown_pitch_{0, 0};
    colour_image screen_{};
    image m_picture_{{0, 0}}, no_strip_{{0, 0}};
    std::vector<legend_entry> legend_{};
};

template <exec::policy Policy>
void session::advance(const Policy& policy) {
    if (machine.frozen()) return;
    machine.time += ticks * tick;
    ++machine.settings.frame;
    needle.drag *= std::pow(0.97F, static_cast<float>(ticks) / usual_ticks); // tissue creeps back
    follow_needle();
    move(policy, machine.probe, probe_pose(), machine.settings.depth, needle, static_cast<float>(machine.time), beat);
}

template <exec::policy Policy>
const image& session::frame(const Policy& policy) {
    if (record != nullptr) record->add_frame();
    const bool acquires = !machine.frozen();
    advance(policy);
    machine.model.scattering.cell = 1.5F * display_speed / machine.probe.frequency; // 1.3 times the lines' distance
    if (!acquires && cine_back) machine.show(policy, std::min(*cine_back, machine.cine().size() - 1));
    cine_back.reset();
    const image& gray = machine.scan(policy, body, acquires ? probe_pose() : machine.at());
    if (gray.size != shown_size_ || machine.map().pitch != shown_pitch_) shows_measurement = false;
    shown_size_ = gray.size;
    shown_pitch_ = machine.map().pitch;
    if (acquires) {
        if (shown == mode::m)
            add_m_columns();
        else if (shown == mode::pulsed)
            doppler.acquire_spectrum(policy, body, machine, flow, ticks);
        else if (shown != mode::b)
            doppler.acquire_colour(policy, body, machine, flow);
    }
    draw_screen(policy, gray);
    return gray;
}

template <exec::policy Policy>
void session::draw_screen(const Policy& policy, const image& gray) {
    const bool colours = (shown == mode::colour || shown == mode::power) && doppler.has_colour();
    if (colours)
        screen_ = doppler.overlay(policy, gray, shown);
    else
        copy_gray(gray, screen_);
    legend_.clear();
    if (shows_labels) draw_labels(screen_, machine.labels(policy, body), body, legend_);
    const scan_map& map = machine.map();
    const float depth = machine.settings.depth;
    constexpr vec3 mark{0.95F, 0.85F, 0.3F};
    const array_probe& probe = machine.probe;
    const auto draw_path = [&](std::initializer_list<vec2> points, vec3 colour) { // points {line, depth along it}
        constexpr int steps = 16;                                                 // a sector's edges are round
        for (std::size_t i = 0; i + 1 < points.size(); ++i)
            for (int k = 0; k < steps; ++k) {
                const auto pixel = [&](int step) {
                    const vec2 a = points.begin()[i], b = points.begin()[i + 1];
                    const vec2 at = a + static_cast<float>(step) / steps * (b - a);
                    const vec3 there = probe.beam(at.x).at(at.y);
                    return map.pixel({there.x, there.z});
                };
                draw_line(screen_, pixel(k), pixel(k + 1), colour);
            }
    };
    if (colours) {
        const doppler_unit::line_box box = doppler.box_in(probe, depth);
        draw_path({{box.left, box.from},
                   {box.right, box.from},
                   {box.right, box.to},
                   {box.left, box.to},
                   {box.left, box.from}},
                  mark);
    } else if (shown == mode::pulsed) {
        const vec2 gate = doppler.gate_in(probe, depth);
        const float half = 0.5F * doppler.gate_length, wide = 2_mm / line_spacing(probe, gate.y);
        draw_path({{gate.x, 0}, {gate.x, gate.y - 2 * half}}, 0.7F * mark);
        draw_path({{gate.x, gate.y + 2 * half}, {gate.x, depth}}, 0.7F * mark);
        for (const float end : {gate.y - half, gate.y + half})
            draw_path({{gate.x - wide, end}, {gate.x + wide, end}}, mark);
        const ray line = probe.beam(gate.x);
        const vec2 along{line.direction.x, line.direction.z},
            middle = vec2{line.origin.x, line.origin.z} + gate.y * along;
        const float c = std::cos(doppler.angle), s = std::sin(doppler.angle);
        const vec2 stroke = 4_mm * vec2{c * along.x + s * along.y, c * along.y - s * along.x};
        if (doppler.angle != 0) draw_line(screen_, map.pixel(middle - stroke), map.pixel(middle + stroke), mark);
    } else if (shown == mode::m) {
        const float line = static_cast<float>(doppler_unit::line_at(probe, {m_side, 0.5F * depth}));
        draw_path({{line, 0}, {line, depth}}, mark);
    }
}

// A column each `ticks_of_m_column`, however long frames take.
inline void session::add_m_columns() {
    const scan_lines& lines = machine.lines();
    // The picture has other lines than the probe.
    const auto along =
        static_cast<float>(doppler_unit::line_at(machine.probe, {m_side, 0.5F * machine.settings.depth}));
    const float fraction = (along + 0.5F) / static_cast<float>(machine.probe.lines);
    const auto line = static_cast<std::uint32_t>(fraction * static_cast<float>(lines.count));
    for (m_ticks_ += ticks; m_ticks_ >= ticks_of_m_column; m_ticks_ -= ticks_of_m_column)
        sweep.add(lines, std::min(line, lines.count - 1));
    m_picture_ = sweep.picture();
}

inline strip_scale session::strip_axes() const {
    constexpr auto seconds = static_cast<float>(tick);
    if (shown == mode::m) return {0, 1e3F * sweep.depth(), "mm", 256 * ticks_of_m_column * seconds};
    if (shown != mode::pulsed) return {};
    const vec2 range = 100.0F * doppler.spectrum_range();
    return {range.y, range.x, "cm/s", static_cast<float>(doppler_unit::columns) * seconds};
}

} // namespace live

#include "controls.hpp" // apply, help and the table

#ifdef INSONIFY_LIVE_LIBRARY // frame.cpp has it: a program compiles in a third of the time
namespace live {
extern template const image& session::frame(const exec::parallel_unsequenced_policy&);
}
#endif
#endif
