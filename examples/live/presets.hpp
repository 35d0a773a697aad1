#ifndef INSONIFY_EXAMPLES_LIVE_PRESETS_HPP
#define INSONIFY_EXAMPLES_LIVE_PRESETS_HPP

#include "session.hpp"
#include <iterator>

namespace live {

namespace detail {
inline std::uint32_t whole(float value) { return static_cast<std::uint32_t>(std::lround(value)); }
} // namespace detail

/// The settings of an examination.
struct examination_preset {
    const char* name;
    float depth, frequency, focus; ///< metres, hertz, metres
    float gain_db, dynamic_range_db;
    grey_map grey;
    std::uint32_t looks; ///< of spatial compounding
    float persistence;
    float scale; ///< of Doppler, m/s
};

inline constexpr grey_map hard_grey{
    .contrast = 0.2F, .reject = 0.4F, .shoulder = 0.55F, .softness = 0.06F}; ///< tissue fainter, vessels black
inline constexpr examination_preset presets_of_session[] = {
    {"Nerve", 40_mm, 7.5_MHz, 18_mm, 0, 85, presets::clinical_grey, 3, 0.2F, 0.2F},
    {"Vessel", 40_mm, 7.5_MHz, 18_mm, -3, 75, hard_grey, 3, 0.3F, 0.3F},
    {"Musculoskeletal", 45_mm, 9_MHz, 20_mm, 2, 90, presets::clinical_grey, 5, 0.3F, 0.15F},
    {"Abdomen", 90_mm, 4.5_MHz, 50_mm, 4, 85, presets::clinical_grey, 3, 0.4F, 0.4F},
    {"Skin", 20_mm, 11_MHz, 8_mm, 0, 85, presets::clinical_grey, 3, 0.1F, 0.1F}};

/// What follows them: the settings of the case, see `session::view`.
inline constexpr auto preset_of_view = static_cast<std::uint32_t>(std::size(presets_of_session));

/// Rolling compounding: each frame acquires one look.
inline void compound(session& s, std::uint32_t looks) {
    s.machine.settings.compound = {.angles = looks, .spread = 6_deg, .update = compound_settings::update_mode::one};
}

inline void use_preset(session& s, std::uint32_t number) {
    const examined& view = s.view;
    const float view_focus = view.probe.focus > 0 ? view.probe.focus : 0.5F * view.settings.depth;
    const examination_preset one = number < preset_of_view ? presets_of_session[number]
                                                           : examination_preset{"View",
                                                                                view.settings.depth,
                                                                                view.probe.frequency,
                                                                                view_focus,
                                                                                view.settings.gain_db,
                                                                                view.settings.dynamic_range_db,
                                                                                view.settings.grey,
                                                                                view.settings.compound.angles,
                                                                                0.2F,
                                                                                0.3F};
    s.preset = number;
    b_mode_settings& settings = s.machine.settings;
    settings.depth = one.depth;
    s.machine.probe.frequency = one.frequency;
    s.machine.probe.focus = one.focus;
    settings.gain_db = one.gain_db;
    settings.dynamic_range_db = one.dynamic_range_db;
    settings.grey = one.grey;
    settings.persistence = one.persistence;
    compound(s, one.looks);
    s.doppler.scale = one.scale;
}

} // namespace live

#endif
