#ifndef INSONIFY_EXAMPLES_LIVE_SESSION_HPP
#define INSONIFY_EXAMPLES_LIVE_SESSION_HPP

#include "control.hpp"
#include "doppler.hpp"
#include "event.hpp"
#include "patient.hpp"
#include "screen.hpp"
#include <cstdint>
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
///     one.measured; one.areas;               // by "measure" and "area"
///
/// A session is a text file of events (recording.hpp), and gives the same pictures whenever it is replayed.
namespace live {

/// What the edges of `session::strip` mean.
struct strip_scale {
    float upper = 0, lower = 0; ///< of the upper and lower edge
    std::string unit{};         ///< mm or cm/s
    float seconds = 0;          ///< from the left to the right edge
};

/// The simulator.
class session : public patient {
  public:
    static constexpr float frame_interval = 1.0F / 30; ///< of the session's clock, seconds
    static constexpr std::size_t max_measures = 64;    ///< the oldest are forgotten

    /// @param anatomy  see `patient`
    explicit session(scene anatomy = nerve_block_phantom()) : patient{std::move(anatomy)} {
        machine.probe = nerve_block::probe;
        machine.settings = nerve_block::settings;
        machine.settings.compound.update = compound_settings::update::one;
        machine.settings.interpolates_lines = true;
        machine.cine_length = 32;
        const aabb whole = box();
        if (!whole.empty() && !body.find("nerve")) { // an unknown body: above its middle
            hand.on_skin = {0.5F * (whole.lower.x + whole.upper.x), 0.5F * (whole.lower.y + whole.upper.y)};
            needle.entry = {hand.on_skin.x - 24_mm, hand.on_skin.y, 0};
        }
        needle.entry.z = skin_at({needle.entry.x, needle.entry.y});
        renew_needle();
    }

    /// Applies an event. Numbers out of range are clamped.
    /// @throws std::invalid_argument  for an unknown name, a wrong number of values, or values that are not finite; the
    ///                                session is unchanged
    void apply(const event& one);

    /// The next picture; 1 / 30 s after the last one.
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
    float m_side = 0;                     ///< the line of the M-mode, metres across
    pulsation beat{.amplitude = 0.3_mm};  ///< of the artery; the flow follows its rate
    std::vector<float> measured{};        ///< metres, by "measure", the latest last
    std::vector<outline_measure> areas{}; ///< by "area", the latest last
    recorder* record = nullptr;           ///< if set, events and frames are written there

    void renew_needle() { renew_tools(needle, machine.probe.width); }
    void place_needle() { body.place(needle_id, needle.at()); }
    void show_mode(mode next) {
        if (shown == next) return;
        shown = next;
        doppler.clear();
    }

  private:
    template <exec::policy Policy>
    void draw_screen(const Policy& policy, const image& gray);

    colour_image screen_{};
    image m_picture_{{0, 0}}, no_strip_{{0, 0}};
    std::vector<legend_entry> legend_{};
};

template <exec::policy Policy>
void session::advance(const Policy& policy) {
    if (machine.frozen()) return;
    machine.time += 1.0 / 30;
    ++machine.settings.frame;
    needle.drag *= 0.97F; // tissue creeps back
    move(policy, machine.probe, probe_pose(), needle, static_cast<float>(machine.time), beat);
    flow.beat.heart_rate = beat.rate;
}

template <exec::policy Policy>
const image& session::frame(const Policy& policy) {
    if (record != nullptr) record->add_frame();
    const bool acquires = !machine.frozen();
    advance(policy);
    machine.model.scattering.cell = 1.5F * display_speed / machine.probe.frequency; // 1.3 times the lines' distance
    const image& gray = machine.scan(policy, body, acquires ? probe_pose() : machine.at());
    if (acquires) {
        const auto time = static_cast<float>(machine.time);
        const float depth = machine.settings.depth;
        if (shown == mode::m) {
            const scan_lines& lines = machine.lines();
            const float share = std::clamp(m_side / machine.probe.width + 0.5F, 0.0F, 1.0F);
            sweep.add(lines,
                      std::min(static_cast<std::uint32_t>(share * static_cast<float>(lines.count)), lines.count - 1));
            m_picture_ = sweep.picture();
        } else if (shown == mode::pulsed)
            doppler.acquire_spectrum(policy, body, machine.probe, machine.at(), flow, depth, time);
        else if (shown != mode::b)
            doppler.acquire_colour(policy, body, machine.probe, machine.at(), flow, depth, time);
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

inline strip_scale session::strip_axes() const {
    if (shown == mode::m) return {0, 1e3F * sweep.depth(), "mm", 256 * frame_interval};
    if (shown != mode::pulsed) return {};
    const vec2 range = 100.0F * doppler.spectrum_range();
    return {range.y, range.x, "cm/s",
            static_cast<float>(doppler_unit::columns) / doppler_unit::columns_per_frame * frame_interval};
}

} // namespace live

#include "controls.hpp" // apply, help and the table

#ifdef INSONIFY_LIVE_LIBRARY // frame.cpp has it: a program compiles in a third of the time
namespace live {
extern template const image& session::frame(const exec::parallel_unsequenced_policy&);
}
#endif
#endif
