#ifndef INSONIFY_DISPLAY_HPP
#define INSONIFY_DISPLAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/b_mode_settings.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/cine_loop.hpp>
#include <insonify/signal/persistence.hpp>
#include <optional>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// A frame that a `scanner` has stored: amplitudes, before they are displayed.
template <transducer Probe>
struct stored_frame {
    std::optional<refined<Probe>> probe{}; ///< that received it, with the lines that were traced
    pose at{};                             ///< of the probe
    double time = 0;                       ///< `scanner::time`, seconds
    scan_lines amplitudes{};               ///< after time gain and compounding
    tgc_settings gain{};                   ///< the time gain of the amplitudes
    bool starts = true;                    ///< persistence starts anew with this frame
};

namespace detail {

/// The stages from stored amplitudes to a picture.
template <transducer Probe>
class frame_display {
  public:
    /// Draws the newest frame, after those that were drawn before.
    template <exec::policy Policy>
    void draw_next(const Policy& policy, const stored_frame<Probe>& frame, const b_mode_settings& settings) {
        compress(policy, frame, settings);
        if (settings.persistence != 0) fade(policy, frame, settings);
        convert(policy, frame, settings);
    }

    /// Draws a frame of a loop by itself: persistence is that of the frames of the loop.
    /// @param back  exists
    template <exec::policy Policy>
    void draw(const Policy& policy, const cine_loop<stored_frame<Probe>>& loop, std::uint32_t back,
              const b_mode_settings& settings) {
        std::uint32_t first = back;
        if (settings.persistence != 0)
            while (first + 1 < loop.size() && !loop[first].starts) ++first;
        smoothing_.reset();
        for (std::uint32_t i = first + 1; i-- > back;) {
            compress(policy, loop[i], settings);
            if (settings.persistence != 0) fade(policy, loop[i], settings);
        }
        convert(policy, loop[back], settings);
    }

    const scan_map& map() const { return map_.value(); }

    scan_lines lines{}; ///< brightness
    image picture{};

  private:
    template <class Policy>
    void compress(const Policy& policy, const stored_frame<Probe>& frame, const b_mode_settings& settings) {
        const tgc_settings wanted{.attenuation = settings.tgc > 0 ? settings.tgc : frame.gain.attenuation,
                                  .max_db = settings.time_gain.max_db,
                                  .sliders = settings.time_gain.sliders,
                                  .curve = settings.time_gain.curve,
                                  .bandwidth = frame.gain.bandwidth};
        lines = frame.amplitudes;
        lines = regain(policy, std::move(lines), frame.probe->frequency, frame.gain, wanted);
        lines = log_compress(policy, std::move(lines),
                             {.dynamic_range_db = settings.dynamic_range_db,
                              .reference_db = settings.reference_db,
                              .gain_db = settings.gain_db,
                              .reject_db = settings.reject_db});
    }

    template <class Policy>
    void fade(const Policy& policy, const stored_frame<Probe>& frame, const b_mode_settings& settings) {
        smoothing_.weight(settings.persistence);
        if (frame.starts) smoothing_.reset();
        lines = smoothing_.add(policy, lines);
    }

    template <class Policy>
    void convert(const Policy& policy, const stored_frame<Probe>& frame, const b_mode_settings& settings) {
        if (!(settings.grey == grey_map{})) lines = map_grey(policy, std::move(lines), settings.grey);
        const scan_map& map = map_(policy, *frame.probe, {.depth = lines.depth, .samples = lines.samples},
                                   {.size = settings.size, .background = settings.background});
        picture = scan_convert(policy, lines, map, std::move(picture));
    }

    kept_scan_map<refined<Probe>> map_{};
    persistence smoothing_{};
};

/// Notices where a clip starts anew: another probe, other settings, or a probe that moves fast.
template <transducer Probe>
class clip_watch {
  public:
    /// Whether the next frame starts a clip.
    bool starts(const Probe& probe, const pose& at, const b_mode_settings& settings) {
        bool changed = starts_;
        starts_ = false;
        before_.frame = settings.frame;
        if (!(before_ == settings)) {
            before_ = settings;
            changed = true;
        }
        probe_([&](char&) { changed = true; }, probe);
        fast_ = motion(probe, settings.depth, at_, at) > settings.max_motion;
        at_ = at;
        return changed || fast_;
    }
    /// Whether the probe has moved fast to the frame that was asked about last.
    bool fast() const { return fast_; }
    /// The next frame starts a clip.
    void reset() { starts_ = true; }

  private:
    // The largest movement of a corner of the field of view, metres.
    static float motion(const Probe& probe, float depth, const pose& before, const pose& after) {
        float largest = 0;
        if (before == after) return largest;
        for (const float line : {-0.5F, static_cast<float>(probe.lines) - 0.5F}) {
            const ray beam = probe.beam(line);
            for (const vec3 corner : {beam.origin, beam.at(depth)})
                largest = max(largest, length(after.point(corner) - before.point(corner)));
        }
        return largest;
    }

    b_mode_settings before_{};
    memo<char, Probe> probe_{};
    pose at_{};
    bool starts_ = true, fast_ = false;
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
