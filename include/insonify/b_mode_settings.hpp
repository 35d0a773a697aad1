#ifndef INSONIFY_B_MODE_SETTINGS_HPP
#define INSONIFY_B_MODE_SETTINGS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/image/grey_map.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/beam.hpp>
#include <insonify/signal/compound.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/read/near_field.hpp>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Settings of a B-mode image, as on a scanner.
struct b_mode_settings {
    /// Time-gain compensation beside `tgc`; see `tgc_settings`.
    struct time_gain_settings {
        /// When a `tgc` of 0 is chosen: at the first frame, and where the probe or the depth changes; or
        /// at every frame, so that the gain follows the probe. A single `b_mode` chooses for its picture.
        enum class choice { first_frame, every_frame };
        choice chosen = choice::first_frame; ///< when it is chosen
        float max_db = 60;                   ///< limit of the automatic gain
        std::array<float, 8> sliders{};      ///< dB at eight depths from 0 to the end of the lines; linear between
        std::vector<tgc_point> curve{};      ///< replaces the automatic gain; points in order of depth, linear between

        friend bool operator==(const time_gain_settings&, const time_gain_settings&) = default;
    };
    /// How finely a picture is sampled. `fast` and `draft` have the levels and the places of `full` in a fraction of the
    /// time; `sampling_of` says what they trace.
    enum class quality {
        full,  ///< lines at most half a beam width apart, two samples per standard deviation of the pulse envelope
        fast,  ///< lines 1.5 beam widths apart, one sample per standard deviation, at most 3 planes, one look
        draft, ///< lines 2 beam widths apart, one sample per standard deviation, 1 plane, one look
    };
    /// Electronic noise; see `electronic_noise_settings`.
    struct noise_level {
        float level_db = -135;  ///< rms of its envelope, 0 dB is the echo of a perfect mirror; `no_level_db`: none
        std::uint64_t seed = 1; ///< selects a realization

        friend bool operator==(const noise_level&, const noise_level&) = default;
    };

    float depth = 0.08F;         ///< metres
    std::uint32_t samples = 0;   ///< depth samples of each line; 0: as `quality` says
    uvec2 size{0, 0};            ///< columns, rows; see `scan_convert_settings`
    float dynamic_range_db = 60; ///< range of levels from black to white
    float reference_db = -25;    ///< level of white; 0 dB is the echo of a perfect mirror
    float gain_db = 0;           ///< added to every level
    float tgc = 0; ///< attenuation to compensate for, dB/m at 1 MHz; 0: that of the tissue, see `automatic_tgc`
    std::uint32_t planes = 5;       ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float background = 0;           ///< brightness of the pixels outside the field of view
    time_gain_settings time_gain{}; ///< how gain depends on depth, beside `tgc`
    float reject_db = no_level_db;  ///< levels below this, after the gain, are black; by default none
    grey_map grey{};                ///< tone curve; by default brightness is linear in decibels
    float persistence = 0;          ///< weight of the previous frames, 0 to below 1; needs a `scanner`
    noise_level noise{};            ///< electronic noise
    std::uint32_t frame = 0;        ///< number of the frame: noise and the speckle of blood differ from frame to frame
    near_field_settings near_field{}; ///< echoes of the probe itself
    compound_settings compound{};     ///< looks at several angles, averaged; none by default
    /// Movement of the probe from frame to frame, metres, at any corner of the field of view, above which `persistence`
    /// and compounding with `update::one` start anew; 0: at every movement.
    float max_motion = 0.001F;
    /// Whether a probe with more lines than its beam needs traces fewer, at least a quarter, and interpolates the others:
    /// see `resample_lines`. Objects narrower than the distance of the lines that are traced may be missed.
    bool interpolates_lines = false;
    enum quality quality = quality::full; ///< lines, samples, planes and looks that are traced

    /// @throws usage_error  for a setting out of range; the stages check the others
    void check() const {
        compound.check();
        check_depth(depth, "b_mode");
        if (!is_finite(tgc) || !(tgc >= 0))
            throw usage_error{
                "b_mode: `tgc` must be finite and above 0, in dB/m at 1 MHz, or 0 to choose it from the tissue"};
        if (!(max_motion >= 0)) throw usage_error{"b_mode: `max_motion` must be metres, 0 or more"};
    }

    friend bool operator==(const b_mode_settings&, const b_mode_settings&) = default;
};

/// What is traced for a picture: the result of `sampling_of`.
struct b_mode_sampling {
    std::uint32_t lines = 0;   ///< of each look
    std::uint32_t samples = 0; ///< depth samples of each line; looks at an angle have slightly more
    std::uint32_t planes = 0;  ///< elevation planes of each line
    std::uint32_t looks = 0;   ///< that are averaged

    friend bool operator==(const b_mode_sampling&, const b_mode_sampling&) = default;
};

/// What is traced for a picture: lines, samples, planes and looks, by `quality`. With `interpolates_lines`, some of the
/// lines are interpolated.
/// @throws usage_error  for a setting out of range
template <transducer Probe>
b_mode_sampling sampling_of(const Probe& probe, const b_mode_settings& settings) {
    settings.check();
    using quality = enum b_mode_settings::quality;
    const bool full = settings.quality == quality::full, draft = settings.quality == quality::draft;
    const auto lines = static_cast<float>(probe.lines);
    const float rays = full ? rays_per_line(probe, settings.depth)
                            : rays_per_line(probe, settings.depth, 1 / lines, draft ? 1 / 2.0F : 1 / 1.5F);
    const float sigma = nominal_pulse(probe).sigma_z(probe.frequency);
    const bool valid = settings.planes % 2 == 1 && settings.planes <= 7; // `trace` refuses another number
    const std::uint32_t max_planes = full || !valid ? settings.planes : draft ? 1 : 3;
    return {.lines = refined<Probe>{probe, rays}.lines,
            .samples = settings.samples != 0 ? settings.samples : samples_for(settings.depth, full ? sigma : 2 * sigma),
            .planes = std::min(settings.planes, max_planes),
            .looks = full ? settings.compound.angles : 1};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
