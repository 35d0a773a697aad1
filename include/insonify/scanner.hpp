#ifndef INSONIFY_SCANNER_HPP
#define INSONIFY_SCANNER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/memo.hpp>
#include <insonify/core/stopwatch.hpp>
#include <insonify/doppler/pulsed_doppler.hpp>
#include <insonify/image/grey_map.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/compound.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/signal/persistence.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/signal/resample_lines.hpp>
#include <insonify/tracing/read/automatic_tgc.hpp>
#include <insonify/tracing/read/label.hpp>
#include <insonify/tracing/read/near_field.hpp>
#include <insonify/tracing/read/reverberation.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <array>
#include <concepts>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Settings of a B-mode image, as on a scanner.
struct b_mode_settings {
    /// How finely a picture is sampled. `fast` and `draft` have the levels and the places of `full` in a fraction of
    /// the time; `sampling_of` says what they trace.
    enum class quality_level {
        full,  ///< lines at most half a beam width apart, two samples per standard deviation of the pulse envelope
        fast,  ///< lines 1.5 beam widths apart, one sample per standard deviation, at most 3 planes, one look
        draft, ///< lines 2 beam widths apart, one sample per standard deviation, 1 plane, one look
    };
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
    near_field_settings near_field{};       ///< echoes of the probe itself
    reverberation_settings reverberation{}; ///< echoes that appear behind gas and bone, on straight lines
    compound_settings compound{};           ///< looks at several angles, averaged; none by default
    /// Movement of the probe from frame to frame, metres, at any corner of the field of view, above which `persistence`
    /// and compounding with `update_mode::one` start anew; 0: at every movement.
    float max_motion = 0.001F;
    /// Whether a probe with more lines than its beam needs traces fewer, at least a quarter, and interpolates the
    /// others: see `resample_lines`. Objects narrower than the distance of the lines that are traced may be missed.
    bool interpolates_lines = false;
    quality_level quality = quality_level::full; ///< lines, samples, planes and looks that are traced
    float ring_down_db = no_level_db;            ///< of the transducer behind each echo, see `pulse`; by default none

    /// @throws usage_error  for a setting out of range; the stages check the others
    void check() const {
        compound.check();
        check_depth(depth, "b_mode");
        detail::check_planes(planes, "b_mode");
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
    const bool full = settings.quality == b_mode_settings::quality_level::full,
               draft = settings.quality == b_mode_settings::quality_level::draft;
    const auto lines = static_cast<float>(probe.lines);
    const float rays = full ? rays_per_line(probe, settings.depth)
                            : rays_per_line(probe, settings.depth, 1 / lines, draft ? 1 / 2.0F : 1 / 1.5F);
    const float sigma = nominal_pulse(probe).sigma_z(probe.frequency);
    return {.lines = refined<Probe>{probe, rays}.lines,
            .samples = settings.samples != 0 ? settings.samples : samples_for(settings.depth, full ? sigma : 2 * sigma),
            .planes = full ? settings.planes : std::min(settings.planes, draft ? 1U : 3U),
            .looks = full ? settings.compound.angles : 1};
}

/// The last frames of a clip, in memory that is reused.
/// @tparam Frame  default-constructible
template <class Frame>
class cine_loop {
  public:
    /// Adds a frame.
    /// @param length  number of frames to keep, at least 1; the oldest are dropped
    /// @param fill    fill(frame) overwrites the frame, which holds an old one; if it throws, the frame is not added
    template <class Fill>
    void add(std::uint32_t length, const Fill& fill) {
        frames_.resize(std::max(length, 1U));
        count_ = std::min<std::size_t>(count_, frames_.size() - 1);
        fill(frames_.back());
        std::rotate(frames_.begin(), frames_.end() - 1, frames_.end());
        count_ = count_ + 1;
    }

    /// Number of frames.
    std::uint32_t size() const { return static_cast<std::uint32_t>(count_); }
    /// Whether there is none.
    bool empty() const { return count_ == 0; }
    /// A frame; not checked. @param back  0: the newest, `size()` - 1: the oldest
    const Frame& operator[](std::uint32_t back) const { return frames_[back]; }
    /// Forgets all frames, and keeps the memory.
    void clear() { count_ = 0; }

  private:
    std::vector<Frame> frames_{}; // from the newest to the oldest; those from `count_` on are spare
    detail::cleared_by_move<std::size_t> count_{};
};

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

/// Notices where a clip starts anew.
template <transducer Probe, class Model>
class clip_watch {
  public:
    /// What does not go on from the frame before.
    struct starts {
        bool persistence; ///< another probe, other settings, or a probe that moves fast
        bool compounding; ///< another model or time gain, or a probe that moves fast
    };

    /// Compares the next frame with the one before. Models that cannot be compared count as the same.
    starts next(const Probe& probe, const Model& model, const pose& at, const b_mode_settings& settings) {
        bool other_looks = before_.tgc != settings.tgc || before_.time_gain != settings.time_gain;
        if constexpr (comparable<Model>) model_([&](char&) { other_looks = true; }, model);
        before_.frame = settings.frame;
        bool changed = std::exchange(starts_, false) || before_ != settings;
        probe_([&](char&) { changed = true; }, probe);
        float motion = 0; // the largest of a corner of the field of view, metres
        for (const float line : {-0.5F, static_cast<float>(probe.lines) - 0.5F}) {
            const ray beam = probe.beam(line);
            for (const vec3 corner : {beam.origin, beam.at(settings.depth)})
                motion = max(motion, length(at.point(corner) - at_.point(corner)));
        }
        const bool fast = motion > settings.max_motion;
        before_ = settings;
        at_ = at;
        return {.persistence = changed || fast, .compounding = other_looks || fast};
    }
    /// The next frame starts a clip.
    void reset() { starts_ = true; }

  private:
    b_mode_settings before_{};
    memo<char, Probe> probe_{};
    memo<char, Model> model_{};
    pose at_{};
    bool starts_ = true;
};

} // namespace detail

/// How long the stages of a frame took, seconds.
struct stage_times {
    double trace = 0;    ///< echoes, with all tables
    double convolve = 0; ///< near field, pulse and beam, electronic noise
    double detect = 0;   ///< envelope, time gain, compounding
    double display = 0;  ///< logarithm, persistence, grey map, scan conversion
    double total = 0;    ///< of `scan`, or of `show`, which only displays
};

/// A scanner, as an application holds it.
///
///     scanner machine{linear_array{}, b_mode_settings{.depth = 40_mm}};
///     for (;; ++machine.settings.frame) show(machine.scan(exec::par_unseq, body, at));
///
/// The public members may change between any two frames. Tables and memory are kept from frame to frame: only what a
/// change affects is computed again, and memory is allocated only while buffers grow. Without `persistence` and
/// compounding with `update_mode::one`, which depend on earlier frames, and with a `tgc` other than 0 or chosen at
/// every frame, a picture is that of `b_mode` to the bit, whatever came before; but for rounding where vertices have
/// moved, whose objects are found by slices until they have trees again.
///
/// The last `cine_length` frames are stored. After `freeze`, `scan` no longer acquires: it shows the stored frame with
/// the present gain, dynamic range, time gain, grey map, persistence and size.
/// @tparam Model   acoustics of interfaces and media; makes complex echoes
/// @tparam Tracer  how sound travels: `straight_lines`, `paths`, or your own (`tracer`)
template <transducer Probe, acoustic_model Model = physical<>, class Tracer = straight_lines>
class scanner {
    static_assert(
        std::same_as<typename Model::sample_type, vec2>,
        "b_mode needs a model that makes complex echoes, such as physical; trace and scan_convert draw others");

  public:
    Probe probe{};                 ///< the transducer
    b_mode_settings settings{};    ///< of the picture
    Model model{};                 ///< acoustics
    Tracer how{};                  ///< how sound travels
    double time = 0;               ///< time stamp of the next frame, by your clock, seconds
    std::uint32_t cine_length = 1; ///< number of frames that are stored; 0 counts as 1

    scanner() requires std::default_initializable<Probe>
    = default;
    /// With these values of `probe`, `settings`, `model` and `how`.
    explicit scanner(Probe transducer, b_mode_settings wanted = {}, Model acoustics = {}, Tracer travel = {})
        : probe{std::move(transducer)}, settings{std::move(wanted)}, model{std::move(acoustics)}, how{std::move(
                                                                                                      travel)} {}

    /// Acquires a frame and draws it; shows the stored one while frozen.
    /// @param at  probe to world
    /// @return the picture, valid until the next call
    /// @throws usage_error     for a scene that is not built, or a setting out of range
    /// @throws geometry_error  for a pose that is not rigid
    template <exec::policy Policy>
    const image& scan(const Policy& policy, const scene& body, const pose& at) {
        if (!frozen_) return scan_by(detail::any_policy{policy}, body, at);
        frame_of_picture();
        return show(policy, shown_);
    }

    /// Draws a stored frame with the present gain, dynamic range, time gain, grey map, persistence and size. If `tgc`
    /// is 0, the attenuation that was chosen at acquisition is kept.
    ///
    /// Levels are exact, but for rounding where the time gain differs. With persistence, it is what a clip from the
    /// oldest stored frame on shows.
    /// @param back  0: the newest frame, `cine().size()` - 1: the oldest
    /// @throws usage_error  for a frame that is not stored, or a setting out of range
    template <exec::policy Policy>
    const image& show(const Policy& policy, std::uint32_t back = 0) {
        return show_by(detail::any_policy{policy}, back);
    }

    /// Stops acquiring. @{
    void freeze() { frozen_ = true; }
    bool frozen() const { return frozen_; }
    /// @}
    /// Acquires again; persistence and compounding start anew.
    void unfreeze() {
        frozen_ = false;
        forget();
    }

    /// Persistence and compounding start anew with the next frame.
    void forget() {
        looks_.reset();
        watch_.reset();
    }

    const cine_loop<stored_frame<Probe>>& cine() const { return cine_; } ///< the stored frames
    const image& picture() const& { return picture_; }                   ///< the last picture
    image picture() && { return std::move(picture_); }                   ///< the last picture
    const scan_lines& lines() const { return lines_; } ///< brightness along the lines of the last picture
    /// Complex echoes of the last frame acquired, after noise, before time gain, on the lines of `echo_probe`.
    ///
    /// Of several looks, those of the look that is steered least: the straight one where their number is odd, else the
    /// one next to it towards -x. With `update_mode::one`, those of the look that this frame acquired. None before the
    /// first picture, and after a `scan` that threw while it acquired or drew.
    const iq_lines& echoes() const {
        static const iq_lines none{};
        return !interrupted_ && echo_look_ < frame_looks_.size() ? frame_looks_[echo_look_].echoes : none;
    }
    /// The lines of `echoes`: usually more than those of the probe, see `rays_per_line`.
    /// @throws usage_error  before the first picture, and after a `scan` that threw while it acquired or drew
    const steered<refined<Probe>>& echo_probe() const {
        check_acquired();
        return *frame_looks_[echo_look_].of_echoes;
    }
    /// What lies along the lines of the look that was acquired last, of `layers_probe`; with a tracer other than
    /// `straight_lines`, no lines. Lines end as deep as the fastest medium of the scene may be displayed within the
    /// picture: clip layers at the depth that counts.
    /// @throws usage_error  before the first picture, and after a `scan` that threw while it acquired or drew
    const line_layers& layers() const {
        check_acquired();
        return frame_looks_[last_look_].lines.layers();
    }
    /// The lines that the layers are those of.
    /// @throws usage_error  before the first picture, and after a `scan` that threw while it acquired or drew
    const steered<refined<Probe>>& layers_probe() const {
        check_acquired();
        return *frame_looks_[last_look_].of_layers;
    }
    /// Pixels of the last picture, points {x, z} of the probe.
    /// @throws usage_error  before the first picture, and after a `scan` or `show` that threw for its size
    const scan_map& map() const {
        check_picture();
        if (map_.value().first.empty())
            throw usage_error{
                "scanner: the last `scan` or `show` threw, and the map of its picture was lost; call it again"};
        return map_.value();
    }
    const pose& at() const { return at_; }              ///< of the probe, for the last picture
    const stage_times& times() const { return times_; } ///< of the last picture

    /// The point in the world that a pixel of the last picture shows, in pixel coordinates: see `scan_map`.
    /// @throws usage_error  before the first picture
    vec3 point(vec2 pixel) const {
        const vec2 in_slice = map().point(pixel);
        return at_.point({in_slice.x, 0, in_slice.y});
    }
    /// The pixel coordinates of a point in the world, projected on the slice. @throws usage_error  as `point`
    vec2 pixel(vec3 point) const {
        const vec3 local = at_.local_point(point);
        return map().pixel({local.x, local.z});
    }

    /// The object at each pixel of the last picture: where it is displayed. The newest frame has those of its straight
    /// look; where there is none, and for earlier frames, they are those of the scene as it is now.
    /// @throws usage_error  before the first picture
    template <exec::policy Policy>
    const label_image& labels(const Policy& policy, const scene& body) {
        const stored_frame<Probe>& frame = frame_of_picture();
        const label_settings grid{frame.amplitudes.depth, frame.amplitudes.samples,
                                  label_settings::depth_grid::displayed};
        const detail::any_policy<false> any{policy};
        const line_layers& found =
            shown_ == 0 && !interrupted_ && frame_looks_[echo_look_].labelled
                ? frame_looks_[echo_look_].lines.layers()
                : detail::layers_for_labels(any, body, *frame.probe, frame.at, grid, false, search_);
        label_lines_ = label(any, found, grid, std::move(label_lines_));
        labels_ = scan_convert(policy, label_lines_, map(), std::move(labels_));
        return labels_;
    }

    /// Colour and power Doppler of what the last picture shows: see `colour_doppler`. Its probe, pose and depth are
    /// those of the picture, its model is that of the scanner.
    /// @return valid until the next call
    /// @throws usage_error  before the first picture, and as `colour_doppler`
    template <exec::policy Policy, velocity_field Field>
    const flow_lines& colour(const Policy& policy, const scene& body, const Field& field, doppler_settings with = {}) {
        const stored_frame<Probe>& shown = frame_of_picture();
        with.depth = shown.amplitudes.depth;
        return colour_.acquire(detail::any_policy{policy}, body, Probe{*shown.probe}, shown.at, model, field, with);
    }
    /// Pulsed Doppler of what the last picture shows: see `pulsed_doppler`. Its probe, pose and depth are those of the
    /// picture, its model is that of the scanner.
    /// @throws usage_error  before the first picture, and as `pulsed_doppler`
    template <exec::policy Policy, velocity_field Field>
    doppler_spectrum spectrum(const Policy& policy, const scene& body, const Field& field,
                              pulsed_doppler_settings with = {}) {
        const stored_frame<Probe>& shown = frame_of_picture();
        with.depth = shown.amplitudes.depth;
        return gate_.acquire(detail::any_policy{policy}, body, Probe{*shown.probe}, shown.at, model, field, with);
    }

  private:
    using look_probe = steered<refined<Probe>>;
    // What is kept of a look, from frame to frame.
    struct frame_look {
        line_tracer<Model, Tracer> lines{};
        std::optional<look_probe> of_layers{}, of_echoes{}; // on whose lines they lie
        iq_lines echoes{};
        bool labelled = false; // its layers give the labels of the picture
    };

    void check_picture() const {
        if (picture_.pixels.empty())
            throw usage_error{"scanner: there is no picture yet; call `scan`, and `unfreeze` where it is frozen"};
    }
    // A `scan` that throws may have overwritten it.
    const stored_frame<Probe>& frame_of_picture() const {
        check_picture();
        if (shown_ >= cine_.size())
            throw usage_error{"scanner: the frame of the picture is no longer stored; call `scan`, or `show` another"};
        return cine_[shown_];
    }
    template <bool Unsequenced>
    const image& scan_by(const detail::any_policy<Unsequenced>& policy, const scene& body, const pose& at);
    template <bool Unsequenced>
    const image& show_by(const detail::any_policy<Unsequenced>& policy, std::uint32_t back);
    void check_acquired() const {
        check_picture();
        if (interrupted_)
            throw usage_error{
                "scanner: the last `scan` threw, so there are no echoes and no layers; call `scan` again"};
    }
    tgc_settings time_gain(float attenuation, float bandwidth) const {
        return {.attenuation = attenuation,
                .max_db = settings.time_gain.max_db,
                .sliders = settings.time_gain.sliders,
                .curve = settings.time_gain.curve,
                .bandwidth = bandwidth};
    }

    // The stages from echoes to stored amplitudes.
    template <class Policy>
    void acquire(const Policy& policy, const scene& body, const pose& at, stored_frame<Probe>& frame) {
        const b_mode_sampling sampling = sampling_of(probe, settings);
        const refined<Probe> fine{probe, static_cast<float>(sampling.lines) / static_cast<float>(probe.lines)};
        compound_settings compound = settings.compound;
        compound.angles = sampling.looks;
        if (frame_looks_.size() < sampling.looks) frame_looks_.resize(sampling.looks);
        const auto starts = watch_.next(probe, model, at, settings);
        if (starts.compounding) looks_.reset();
        std::optional<tgc_settings> gain; // chosen with the first look
        const detail::stopwatch clock;
        frame.amplitudes = looks_(
            policy, fine, {.depth = settings.depth, .samples = sampling.samples, .planes = sampling.planes}, compound,
            [&](std::uint32_t number, const look_probe& look, const acquisition& scan, scan_lines recycled) {
                if (compound.update == compound_settings::update_mode::one || number == (compound.angles - 1) / 2)
                    echo_look_ = number;
                return acquire_look(policy, body, at, number, look, scan, gain, std::move(recycled));
            },
            std::move(frame.amplitudes));
        times_.detect = clock.seconds() - times_.trace - times_.convolve;
        frame.probe.emplace(fine);
        frame.at = at;
        frame.time = time;
        frame.gain = *std::move(gain);
        frame.starts = starts.persistence;
    }

    template <class Policy>
    scan_lines acquire_look(const Policy& policy, const scene& body, const pose& at, std::uint32_t number,
                            const look_probe& look, acquisition scan, std::optional<tgc_settings>& gain,
                            scan_lines recycled) {
        detail::stopwatch clock;
        scan.frame = settings.frame;
        const float rays =
            settings.interpolates_lines ? min(rays_per_line(probe, settings.depth, 0.25F), look.rays) : look.rays;
        const refined<Probe> straight{probe, rays};
        const look_probe traced{straight, look.steering};
        frame_look& own = frame_looks_[number];
        own.of_echoes.emplace(look);
        own.of_layers.emplace(traced);
        last_look_ = number;
        iq_lines& echoes = own.echoes;
        echoes = own.lines.trace(policy, body, traced, at, model, scan, how, std::move(echoes));
        const line_layers& found = own.lines.layers();
        constexpr bool finds_layers = std::same_as<Tracer, straight_lines>;
        const float label_depth = detail::max_depth_of(
            label_settings{.depth = settings.depth, .grid = label_settings::depth_grid::displayed}, body.media());
        own.labelled = finds_layers && traced.lines == look.lines && look.steering == 0 &&
                       detail::max_depth_of(model, settings.depth, body.media()) >= label_depth;
        if (!gain) gain = choose_time_gain(policy, body, at, look.steering == 0 && found.lines > 0 ? &found : nullptr);
        times_.trace += clock.lap();
        if constexpr (finds_layers) {
            echoes = add_reverberation(policy, std::move(echoes), found, traced, model, settings.reverberation);
            echoes = add_near_field(policy, std::move(echoes), found, straight, settings.near_field);
        } else {
            constexpr float depth = 2 * detail::below_face;
            const line_layers& here =
                search_(detail::any_policy<false>{policy}, body, straight, at, {.depth = depth}, depth, true);
            echoes = add_near_field(policy, std::move(echoes), here, straight, settings.near_field);
        }
        pulse sent = nominal_pulse(probe);
        sent.ring_down_db = settings.ring_down_db;
        echoes = convolver_.convolve(policy, std::move(echoes), sent, traced);
        if (traced.lines != look.lines) {
            resampled_ = resample_lines(policy, echoes, traced, look, std::move(resampled_));
            std::swap(echoes, resampled_);
        }
        echoes = add_electronic_noise(
            policy, std::move(echoes),
            {.level_db = settings.noise.level_db, .seed = settings.noise.seed + number, .frame = settings.frame});
        times_.convolve += clock.lap();
        return tgc(policy, envelope(policy, echoes, std::move(recycled)), probe.frequency, *gain);
    }

    // The automatic attenuation is chosen at the first frame, and again where the probe or the depth has changed.
    // `found` are the layers of the first look; where that is steered or has none it is null, and those along the lines
    // of the probe are found.
    template <class Policy>
    tgc_settings choose_time_gain(const Policy& policy, const scene& body, const pose& at, const line_layers* found) {
        const auto choose = [&](float& chosen) {
            if (found == nullptr)
                found = &search_(detail::any_policy<false>{policy}, body, probe, at, {.depth = settings.depth},
                                 settings.depth, false);
            chosen = automatic_tgc(*found, settings.depth);
        };
        float attenuation = settings.tgc;
        if (attenuation == 0 && settings.time_gain.chosen == b_mode_settings::time_gain_settings::choice::every_frame)
            choose(attenuation);
        else if (attenuation == 0)
            attenuation = chosen_gain_(choose, probe, settings.depth);
        float bandwidth = 0; // of the pulse whose losses are restored; 0 where the model attenuates a single frequency
        if constexpr (requires { model.bandwidth == pulse_bandwidth::broad; })
            if (model.bandwidth == pulse_bandwidth::broad) bandwidth = fractional_bandwidth(probe);
        return time_gain(attenuation, bandwidth);
    }

    // The stages from stored amplitudes to brightness, after the frames that were drawn before.
    template <class Policy>
    void compress(const Policy& policy, const stored_frame<Probe>& frame) {
        const float attenuation = settings.tgc > 0 ? settings.tgc : frame.gain.attenuation;
        lines_ = frame.amplitudes;
        lines_ = regain(policy, std::move(lines_), frame.probe->frequency, frame.gain,
                        time_gain(attenuation, frame.gain.bandwidth));
        lines_ = log_compress(policy, std::move(lines_),
                              {.dynamic_range_db = settings.dynamic_range_db,
                               .reference_db = settings.reference_db,
                               .gain_db = settings.gain_db,
                               .reject_db = settings.reject_db});
        if (settings.persistence == 0) return;
        smoothing_.weight(settings.persistence);
        if (frame.starts) smoothing_.reset();
        lines_ = smoothing_.add(policy, lines_);
    }

    // The same, and those to a picture.
    template <class Policy>
    void draw(const Policy& policy, const stored_frame<Probe>& frame) {
        compress(policy, frame);
        if (!(settings.grey == grey_map{})) lines_ = map_grey(policy, std::move(lines_), settings.grey);
        map_(policy, *frame.probe, {.depth = lines_.depth, .samples = lines_.samples},
             {.size = settings.size, .background = settings.background});
        picture_ = scan_convert(policy, lines_, map_.value(), std::move(picture_));
    }

    std::deque<frame_look> frame_looks_{};
    std::uint32_t echo_look_ = 0, last_look_ = 0; // of `echoes`, and acquired last
    convolver convolver_{};
    colour_scanner<Model> colour_{};
    gate_scanner<Model> gate_{};
    compounding<refined<Probe>> looks_{};
    detail::memo<float, Probe, float> chosen_gain_{};
    detail::clip_watch<Probe, Model> watch_{};
    cine_loop<stored_frame<Probe>> cine_{};
    persistence smoothing_{};
    scan_lines lines_{}; // brightness
    kept_scan_map<refined<Probe>> map_{};
    image picture_{};
    iq_lines resampled_{};
    detail::layer_search search_{}; // of one plane, where no look has it
    label_lines label_lines_{};
    label_image labels_{};
    stage_times times_{};
    pose at_{};
    std::uint32_t shown_ = 0; // frames back
    bool frozen_ = false, interrupted_ = false;
};

template <transducer Probe, acoustic_model Model, class Tracer>
template <bool Unsequenced>
const image& scanner<Probe, Model, Tracer>::scan_by(const detail::any_policy<Unsequenced>& policy, const scene& body,
                                                    const pose& at) {
    const detail::probe_settings stated{probe}; // all checks before a stored frame is overwritten
    settings.check();
    detail::check_lines(body, stated.frequency, at, settings.depth, "scanner");
    if constexpr (requires { model.check(); }) model.check();
    if constexpr (requires { how.check(); }) how.check();
    const detail::stopwatch clock;
    times_ = {};
    if (interrupted_) forget(); // the last frame threw
    interrupted_ = true;
    cine_.add(cine_length, [&](stored_frame<Probe>& frame) { acquire(policy, body, at, frame); });
    ++shown_; // the frame of the picture, until the new one is drawn
    const detail::stopwatch display;
    draw(policy, cine_[0]);
    shown_ = 0;
    at_ = at;
    interrupted_ = false;
    times_.display = display.seconds();
    times_.total = clock.seconds();
    return picture_;
}

template <transducer Probe, acoustic_model Model, class Tracer>
template <bool Unsequenced>
const image& scanner<Probe, Model, Tracer>::show_by(const detail::any_policy<Unsequenced>& policy, std::uint32_t back) {
    if (cine_.empty()) check_picture();
    settings.check();
    if (back >= cine_.size())
        throw usage_error{"scanner: `back` is ", back, ", and ", cine_.size(),
                          " frames are stored; `cine_length` is the number to store"};
    const detail::stopwatch clock;
    std::uint32_t first = back; // from which persistence goes on
    if (settings.persistence != 0)
        while (first + 1 < cine_.size() && !cine_[first].starts) ++first;
    smoothing_.reset();
    watch_.reset();
    for (; first > back; --first) compress(policy, cine_[first]);
    draw(policy, cine_[back]);
    shown_ = back;
    at_ = cine_[back].at;
    times_ = {.display = clock.seconds(), .total = clock.seconds()};
    return picture_;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
