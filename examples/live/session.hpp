#ifndef INSONIFY_EXAMPLES_LIVE_SESSION_HPP
#define INSONIFY_EXAMPLES_LIVE_SESSION_HPP

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
///     live::session one;                     // or session{scene}, or session_of_obj (obj.hpp)
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

    /// @param anatomy  see `patient`
    explicit session(scene anatomy = nerve_block_phantom());

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
    scanner<linear_array> machine{};
    m_mode sweep{{.columns = 256, .rows = 256}};
    hand_state hand{};
    needle_state needle{};
    doppler_unit doppler{};
    mode shown = mode::b;
    std::uint32_t preset = 0;
    bool shows_labels = false;
    float m_side = 0;                         ///< the line of the M-mode, metres across
    pulsation beat{.amplitude = 0.3_mm};      ///< of the artery; the flow follows its rate
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

    template <exec::policy Policy>
    void draw_screen(const Policy& policy, const image& gray);
    void add_m_columns();
    void follow_needle() {
        if (needle_change_ == change::shape) renew_tools(needle, machine.probe.width);
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
    move(policy, machine.probe, probe_pose(), needle, static_cast<float>(machine.time), beat);
    flow.beat.heart_rate = beat.rate;
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
    if (colours) {
        const auto [from, to] = doppler.box_in(machine.probe, depth);
        const vec2 corners[] = {map.pixel(from), map.pixel({to.x, from.y}), map.pixel(to), map.pixel({from.x, to.y})};
        for (std::size_t i = 0; i < 4; ++i) draw_line(screen_, corners[i], corners[(i + 1) % 4], mark);
    } else if (shown == mode::pulsed) {
        const vec2 gate = doppler.gate_in(machine.probe, depth), half{2_mm, 0.5F * doppler.gate_length};
        draw_line(screen_, map.pixel({gate.x, 0}), map.pixel({gate.x, gate.y - 2 * half.y}), 0.7F * mark);
        draw_line(screen_, map.pixel({gate.x, gate.y + 2 * half.y}), map.pixel({gate.x, depth}), 0.7F * mark);
        for (const float side : {-1.0F, 1.0F})
            draw_line(screen_, map.pixel(gate + vec2{-half.x, side * half.y}),
                      map.pixel(gate + vec2{half.x, side * half.y}), mark);
        const vec2 along{4_mm * std::sin(doppler.angle), 4_mm * std::cos(doppler.angle)};
        if (doppler.angle != 0) draw_line(screen_, map.pixel(gate - along), map.pixel(gate + along), mark);
    } else if (shown == mode::m)
        draw_line(screen_, map.pixel({m_side, 0}), map.pixel({m_side, depth}), mark);
}

// A column each `ticks_of_m_column`, however long frames take.
inline void session::add_m_columns() {
    const scan_lines& lines = machine.lines();
    const float share = std::clamp(m_side / machine.probe.width + 0.5F, 0.0F, 1.0F);
    const auto line = static_cast<std::uint32_t>(share * static_cast<float>(lines.count));
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
