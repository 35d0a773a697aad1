#ifndef INSONIFY_B_MODE_HPP
#define INSONIFY_B_MODE_HPP

#include <insonify/acoustics/physical.hpp>
#include <insonify/image/grey_map.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/plausible.hpp>
#include <insonify/probe/refined.hpp>
#include <insonify/scene/path_attenuation.hpp>
#include <insonify/signal/compound.hpp>
#include <insonify/signal/convolve.hpp>
#include <insonify/signal/electronic_noise.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/signal/persistence.hpp>
#include <insonify/tracing/near_field.hpp>
#include <insonify/tracing/trace.hpp>
#include <array>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Settings of a B-mode image, as on a scanner.
struct b_mode_settings {
    /// Time-gain compensation beside `tgc`; see `tgc_settings`.
    struct time_gain_settings {
        /// When a `tgc` of 0 is chosen: at the first frame of a workspace, and where the probe or the depth changes; or
        /// at every frame, so that the gain follows the probe. Without a workspace each picture chooses.
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
    std::uint32_t samples = 0;   ///< depth samples of each line; 0: two per standard deviation of the pulse envelope
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
    float persistence = 0;          ///< weight of the previous frames, 0 to below 1; needs a workspace
    noise_level noise{};            ///< electronic noise
    std::uint32_t frame = 0;        ///< number of the frame: noise and the speckle of blood differ from frame to frame
    near_field_settings near_field{}; ///< echoes of the probe itself
    compound_settings compound{};     ///< looks at several angles, averaged; none by default

    friend bool operator==(const b_mode_settings&, const b_mode_settings&) = default;
};

/// Number of traced lines per line of the probe, so that their distance at the focus is at most half the beam width; at
/// most 4. Where the probe has fewer lines than that takes, any number of them traces the same number of lines.
template <transducer Probe>
float rays_per_line(const Probe& probe, float depth) {
    const beam_model beam = beam_of(probe, depth);
    const float rays = clamp(2 * line_spacing(probe, beam.focus) / beam.lateral_width(beam.focus), 1, 4);
    const auto lines = static_cast<float>(probe.lines);
    return std::ceil(rays * lines - 0.01F) / lines;
}

namespace detail {

/// The time-gain compensation of `b_mode`. The automatic one is chosen at the first frame, and again where the probe or
/// the depth has changed.
template <transducer Probe>
class kept_gain {
  public:
    template <exec::policy Policy>
    const tgc_settings& operator()(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                                   const b_mode_settings& settings) {
        using choice = b_mode_settings::time_gain_settings::choice;
        const auto choose = [&] { return automatic_tgc(policy, body, probe, at, settings.depth); };
        gain_.max_db = settings.time_gain.max_db;
        gain_.sliders = settings.time_gain.sliders;
        gain_.curve = settings.time_gain.curve;
        gain_.attenuation = settings.tgc > 0 ? settings.tgc
                            : settings.time_gain.chosen == choice::every_frame
                                ? choose()
                                : first_([&](float& chosen) { chosen = choose(); }, probe, settings.depth);
        return gain_;
    }

  private:
    tgc_settings gain_{};
    memo<float, Probe, float> first_{};
};

/// The persistence of `b_mode`: restarts where the probe or a setting other than `frame` has changed.
template <transducer Probe>
class kept_persistence {
  public:
    template <exec::policy Policy>
    void apply(const Policy& policy, scan_lines& lines, const Probe& probe, const pose& at,
               const b_mode_settings& settings) {
        if (settings.persistence == 0) return smoothing_.reset();
        settings_.frame = settings.frame;
        if (!(settings_ == settings)) {
            smoothing_ = persistence{settings.persistence};
            settings_ = settings;
        }
        probe_([&](char&) { smoothing_.reset(); }, probe);
        lines = smoothing_.add(policy, lines, at);
    }

  private:
    b_mode_settings settings_{};
    memo<char, Probe> probe_{};
    persistence smoothing_{};
};

/// The model and the time gain, as set, that looks were acquired with. Models that cannot be compared count as the same.
template <class Model>
using looks_of = std::conditional_t<comparable<Model>, memo<char, Model, float, b_mode_settings::time_gain_settings>,
                                    memo<char, float, b_mode_settings::time_gain_settings>>;

} // namespace detail

/// Tables and memory of `b_mode`, kept from frame to frame.
template <transducer Probe, acoustic_model Model = physical<>, class Tracer = straight_lines>
struct b_mode_workspace {
    trace_workspace<steered<refined<Probe>>, Model, Tracer> tracing{};       ///< of `trace`
    std::vector<detail::frame_plan<steered<refined<Probe>>, Model>> plans{}; ///< of `trace`, for each look
    convolve_workspace convolution{};                                        ///< of `convolve`
    compounding<refined<Probe>> looks{};                                     ///< the last looks
    detail::looks_of<Model> acquired{};                                      ///< model and time gain of the looks
    kept_scan_map<refined<Probe>> map{};                                     ///< of `scan_convert`
    iq_lines echoes{};                                                       ///< received echoes
    scan_lines lines{};                                                      ///< brightness
    image picture{};                                                         ///< the last image
    detail::kept_gain<Probe> gain{};                                         ///< of `tgc`
    detail::kept_persistence<Probe> smoothing{};                             ///< the previous frames
};

/// Simulates a B-mode image: the whole chain in one call.
///
///     trace (physical) -> add_near_field -> convolve (the probe's pulse and beam) -> add_electronic_noise -> envelope
///         -> tgc -> compounding -> log_compress -> persistence -> map_grey -> scan_convert
///
/// The levels are fixed, so clips do not flicker. For a clip:
///
///     b_mode_workspace<linear_array> own;
///     for (;; ++settings.frame) show(b_mode(exec::par_unseq, body, probe, at, settings, physical{}, own));
///
/// @param model  acoustics of interfaces and media
/// @param own    tables and memory; pass it again with the next frame to avoid allocations
/// @param how    how sound travels: `straight_lines`, `paths`, or your own (`tracer`)
/// @return the image, valid until `own` is used again
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, tracer<Model> Tracer>
const image& b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                    const b_mode_settings& settings, const Model& model, b_mode_workspace<Probe, Model, Tracer>& own,
                    const Tracer& how = {}) {
    static_assert(
        std::same_as<typename Model::sample_type, vec2>,
        "b_mode needs a model that makes complex echoes, such as physical; trace and scan_convert draw others");
    probe.check();
    check_depth(settings.depth, "b_mode");
    if (!is_finite(settings.tgc) || !(settings.tgc >= 0))
        throw usage_error{"b_mode: `tgc` must be a finite number of dB/m at 1 MHz, or 0 for the tissue's"};
    const refined<Probe> fine{probe, rays_per_line(probe, settings.depth)};
    const pulse sent = nominal_pulse(probe);
    const std::uint32_t samples =
        settings.samples != 0 ? settings.samples : samples_for(settings.depth, sent.sigma_z(probe.frequency));
    const tgc_settings& gain = own.gain(policy, body, probe, at, settings);
    const auto acquire = [&](std::uint32_t number, const steered<refined<Probe>>& look, acquisition scan,
                             scan_lines recycled) {
        scan.frame = settings.frame;
        std::swap(own.tracing.plan, own.plans[number]);
        own.echoes = trace(policy, body, look, at, model, scan, own.tracing, std::move(own.echoes), how);
        std::swap(own.tracing.plan, own.plans[number]);
        own.echoes = add_near_field(policy, std::move(own.echoes), body, look, at, settings.near_field);
        own.echoes = convolve(policy, std::move(own.echoes), sent, look, {}, own.convolution);
        own.echoes = add_electronic_noise(
            policy, std::move(own.echoes),
            {.level_db = settings.noise.level_db, .seed = settings.noise.seed + number, .frame = settings.frame});
        return tgc(policy, envelope(policy, own.echoes, std::move(recycled)), probe.frequency, gain);
    };
    settings.compound.check();
    own.plans.resize(settings.compound.angles);
    const auto forget = [&](char&) { own.looks.reset(); };
    if constexpr (detail::comparable<Model>)
        own.acquired(forget, model, settings.tgc, settings.time_gain);
    else
        own.acquired(forget, settings.tgc, settings.time_gain);
    own.lines = own.looks(policy, fine, {.depth = settings.depth, .samples = samples, .planes = settings.planes},
                          settings.compound, acquire, std::move(own.lines));
    own.lines = log_compress(policy, std::move(own.lines),
                             {.dynamic_range_db = settings.dynamic_range_db,
                              .reference_db = settings.reference_db,
                              .gain_db = settings.gain_db,
                              .reject_db = settings.reject_db});
    own.smoothing.apply(policy, own.lines, probe, at, settings);
    if (!(settings.grey == grey_map{})) own.lines = map_grey(policy, std::move(own.lines), settings.grey);
    const scan_map& map = own.map(policy, fine, {.depth = settings.depth, .samples = samples},
                                  {.size = settings.size, .background = settings.background});
    own.picture = scan_convert(policy, own.lines, map, std::move(own.picture));
    return own.picture;
}
/// The same for a single image.
///
///     b_mode(exec::par_unseq, body, probe, at, {.depth = 40_mm}, physical{}, paths{});
///
/// @throws usage_error, geometry_error  as above
template <exec::policy Policy, transducer Probe, acoustic_model Model = physical<>,
          tracer<Model> Tracer = straight_lines>
image b_mode(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
             const b_mode_settings& settings = {}, const Model& model = {}, const Tracer& how = {}) {
    b_mode_workspace<Probe, Model, Tracer> own;
    b_mode(policy, body, probe, at, settings, model, own, how);
    return std::move(own.picture);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
