#ifndef INSONIFY_DOPPLER_COLOUR_DOPPLER_HPP
#define INSONIFY_DOPPLER_COLOUR_DOPPLER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/doppler/doppler_ensemble.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/transducer.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// The part of the field of view in which velocities are measured. By default all of it.
struct colour_box {
    float from = 0;               ///< depth, metres
    float to = 0;                 ///< depth, metres; 0: the end of the lines
    std::uint32_t first_line = 0; ///< of the probe
    std::uint32_t lines = 0;      ///< their number; 0: to the last one

    friend bool operator==(const colour_box&, const colour_box&) = default;
};

/// Settings of colour and power Doppler, as on a scanner.
struct doppler_settings {
    float depth = 0.08F;          ///< metres
    float prf = 4e3F;             ///< pulse repetition frequency, hertz: sets the largest velocity, c0 prf / (4 f0)
    std::uint32_t ensemble = 8;   ///< pulses along each line
    colour_box box{};             ///< where velocities are measured
    wall_filter wall{};           ///< removes tissue
    float average_length = 1e-3F; ///< of the autocorrelation along the lines, metres
    float average_lines = 2;      ///< and across them, in lines of the probe
    float burst = 4;              ///< length of the excitation, in cycles
    std::uint32_t planes = 1;     ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    float time = 0;               ///< of the first pulse, seconds: the same time gives the same picture
    float noise_db = -135;        ///< electronic noise: see `electronic_noise_settings`
    std::uint64_t seed = 1;       ///< of the noise

    /// @throws usage_error  for a setting out of range
    template <transducer Probe>
    void check(const Probe& probe) const {
        probe.check();
        check_depth(depth, "colour_doppler");
        wall.check(ensemble);
        if (ensemble < 2) throw usage_error{"colour_doppler: `ensemble` must be at least 2 pulses; 8 to 16 are usual"};
        if (!(average_length >= 0 && average_length <= depth) || !(average_lines >= 0 && average_lines <= 1000))
            throw usage_error{"colour_doppler: `average_length` must be 0 to `depth` metres, such as 1_mm, and "
                              "`average_lines` 0 or more lines, such as 2"};
        if (box.first_line >= probe.lines || box.lines > probe.lines - box.first_line)
            throw usage_error{"colour_doppler: the box must lie in the ", probe.lines,
                              " lines of the probe; lower `first_line` or `lines`"};
        if (!(box.from >= 0 && box.from < (box.to > 0 ? box.to : depth)) || !(box.to >= 0 && box.to <= depth))
            throw usage_error{"colour_doppler: the box must begin above its end, and end within the depth"};
    }
};

namespace detail {

/// A probe of a type that states no focus, with one.
template <transducer Probe>
struct focused : Probe {
    float focus = 0; ///< metres
};

/// The probe with the focus that it has at the whole depth, and enough lines: at the focus they are no further apart
/// than half the beam width, and than two thirds of a cell of scatterers. Coarser lines sample what passes them so
/// rarely that its spectrum repeats, -7 dB at 1.3 cells and -25 dB at two thirds.
template <transducer Probe, class Model>
auto doppler_probe(const Probe& probe, float depth, const Model& model) {
    float rays = rays_per_line(probe, depth);
    if constexpr (requires { model.scattering.cell; })
        rays = max(rays, min(1.5F * line_spacing(probe, beam_of(probe, depth).focus) / model.scattering.cell, 8));
    if constexpr (requires { probe.focus; }) {
        refined fine{probe, rays};
        if (fine.focus == 0) fine.focus = depth / 2;
        return fine;
    } else {
        return refined{focused<Probe>{probe, depth / 2}, rays};
    }
}

/// The lines whose echoes reach those from `first` to `last` through the beam.
/// @param kernel  its memory is reused
template <transducer Probe>
refined<Probe> lines_around(const refined<Probe>& probe, float depth, float first, float last, lateral_kernel& kernel) {
    kernel = make_lateral_kernel(probe, {.depth = depth, .samples = 64}, std::move(kernel));
    const auto margin = static_cast<float>(kernel.half_width());
    const auto whole = [&](float line) {
        return static_cast<std::uint32_t>(clamp(line, 0, static_cast<float>(probe.lines)));
    };
    return probe.section(whole(first - margin), whole(std::ceil(last + margin) + 1));
}

/// The pulses of `doppler_settings` or `pulsed_doppler_settings`, but for their number.
/// @param samples, spacing  of the lines down to the depth that counts; metres from sample to sample
/// @param from              depth from which moving scatterers are needed, metres
template <class Settings>
ensemble_settings train_of(const Settings& settings, std::uint32_t samples, float spacing, float from) {
    return {.depth = static_cast<float>(samples) * spacing,
            .samples = samples,
            .prf = settings.prf,
            .from = max(from, 0),
            .burst = settings.burst,
            .planes = settings.planes,
            .time = settings.time,
            .noise_db = settings.noise_db,
            .seed = settings.seed};
}

/// Velocity and power of each pixel, 0 outside the field of view and where `settings` show no flow. Interpolates
/// phasors, so aliased velocities do not pass through 0 on their way from one end of the range to the other.
template <exec::policy Policy, class Settings, class Pixel>
void for_each_flow_pixel(const Policy& policy, const flow_lines& lines, const scan_map& map, const Settings& settings,
                         const Pixel& pixel) {
    check_lines_of_map(lines, map);
    const float turn = lines.max_velocity > 0 ? pi / lines.max_velocity : 0, scale = lines.max_velocity / pi;
    const float min_amplitude = amplitude_of_decibels(settings.min_power_db);
    const std::size_t next = map.samples > 1 ? 1 : 0;
    exec::for_each_block(policy, map.size.y, 1, 40 * static_cast<float>(map.size.x), [&](std::size_t y, std::size_t) {
        for (std::size_t i = y * map.size.x; i < (y + 1) * map.size.x; ++i) {
            if (map.first[i] == scan_map::outside) {
                pixel(i, flow_sample{});
                continue;
            }
            const std::size_t here = map.first[i], beside = map.beside(map.first[i]);
            const float across = map.across[i], along = map.along[i];
            vec2 phasor{0, 0};
            float power = 0;
            const auto add = [&](const flow_sample& sample, float weight) {
                const float angle = turn * sample.velocity;
                phasor += weight * sample.power * vec2{std::cos(angle), std::sin(angle)};
                power += weight * sample.power;
            };
            add(lines.values[here], (1 - across) * (1 - along));
            add(lines.values[here + next], (1 - across) * along);
            add(lines.values[beside], across * (1 - along));
            add(lines.values[beside + next], across * along);
            const flow_sample found{.velocity = power > 0 ? scale * std::atan2(phasor.y, phasor.x) : 0, .power = power};
            const bool shown =
                power > 0 && std::sqrt(power) >= min_amplitude && std::fabs(found.velocity) >= settings.min_velocity;
            pixel(i, shown ? found : flow_sample{});
        }
    });
}

} // namespace detail

/// `colour_doppler`, frame after frame: holds tables and memory, so that it allocates only while buffers grow.
template <acoustic_model Model = physical<>>
class colour_scanner {
  public:
    /// See `colour_doppler`. @return valid until the next call
    template <exec::policy Policy, transducer Probe, velocity_field Field>
    const flow_lines& acquire(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                              const Model& model, const Field& field, const doppler_settings& settings) {
        constexpr std::uint32_t decimation = 8;
        settings.check(probe);
        const pulse sent = nominal_pulse(probe, settings.burst);
        sent.check(probe.frequency);
        const auto fine = detail::doppler_probe(probe, settings.depth, model);
        const std::uint32_t box_end =
            settings.box.lines == 0 ? probe.lines : settings.box.first_line + settings.box.lines;
        const float reach = 0.5F * settings.average_lines;
        const auto fine_line = [&](float line) { return (line + 0.5F) * fine.rays - 0.5F; };
        const auto lines =
            detail::lines_around(fine, settings.depth, fine_line(static_cast<float>(settings.box.first_line) - reach),
                                 fine_line(static_cast<float>(box_end - 1) + reach), beam_);

        const std::uint32_t samples = samples_for(settings.depth, sent.sigma_z(probe.frequency));
        const float spacing = settings.depth / static_cast<float>(samples);
        const float box_to = settings.box.to > 0 ? settings.box.to : settings.depth;
        const float beyond = sent.envelope(probe.frequency).half_length() + settings.average_length,
                    last = box_to + beyond;
        const std::uint32_t traced =
            std::min(samples, decimation * static_cast<std::uint32_t>(std::ceil(last / spacing / decimation)));
        ensemble_settings train = detail::train_of(settings, traced, spacing, settings.box.from - beyond);
        train.pulses = settings.ensemble;
        const iq_ensemble& echoes = train_.acquire(policy, body, lines, at, model, field, train);
        const std::vector<float>& walls =
            walls_([&](std::vector<float>& matrix) { matrix = wall_filter_matrix(settings.wall, settings.ensemble); },
                   settings.wall, settings.ensemble);
        filtered_ = detail::filter_walls(policy, echoes, walls, std::move(filtered_));
        const auto length = static_cast<std::uint32_t>(max(settings.average_length / spacing, 1));
        correlated_ = autocorrelate(policy, filtered_, length, decimation, std::move(correlated_));

        flow_.reshape(probe.lines, samples / decimation, settings.depth);
        std::fill(flow_.values.begin(), flow_.values.end(), flow_sample{});
        flow_.max_velocity = max_doppler_velocity(settings.prf, probe.frequency);
        const float step = spacing * decimation;
        for_each_index(policy, box_end - settings.box.first_line, [&](std::size_t i) {
            const std::uint32_t line = settings.box.first_line + static_cast<std::uint32_t>(i);
            const float middle = fine_line(static_cast<float>(line)) - lines.first_line,
                        width = max(reach * fine.rays, 0.5F) + 0.5F;
            for (std::uint32_t k = 0; k < correlated_.samples; ++k) {
                const float depth = (static_cast<float>(k) + 0.5F) * step;
                if (depth < settings.box.from || depth > box_to) continue;
                autocorrelation sum;
                float weights = 0;
                for (std::uint32_t j = 0; j < lines.lines; ++j) {
                    const float weight = 1 - std::fabs(static_cast<float>(j) - middle) / width;
                    if (!(weight > 0)) continue;
                    sum.power += weight * correlated_(j, k).power;
                    sum.lag_one += weight * correlated_(j, k).lag_one;
                    weights += weight;
                }
                flow_(line, k) = flow_of({sum.power / weights, sum.lag_one / weights}, flow_.max_velocity);
            }
        });
        return flow_;
    }

  private:
    ensemble_scanner<Model> train_{};
    detail::lateral_kernel beam_{};
    detail::memo<std::vector<float>, wall_filter, std::uint32_t> walls_{}; // the filter as a matrix
    iq_ensemble filtered_{};                                               // after the wall filter
    autocorrelation_lines correlated_{};                                   // on the traced lines
    flow_lines flow_{};                                                    // on the lines of the probe
};

/// Colour Doppler: velocity, power and variance of what moves, along the lines of the probe.
///
///     doppler_ensemble -> filter_walls -> autocorrelate -> average across the lines -> flow_of
///
/// The result has the lines of the probe and an eighth of the samples of a B-mode; 0 outside the box. Velocities are
/// those that a scanner displays: along the line, for the sound speed c0, and aliased above c0 prf / (4 f0).
///
///     const flow_lines seen = colour_doppler(exec::par, body, probe, at, stream, {.depth = 40_mm, .prf = 6_kHz});
///
/// @param field  velocities of blood and tissue, such as `poiseuille`
/// @param model  acoustics of interfaces and media
/// @throws usage_error     for a scene that is not built, or a setting out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe, acoustic_model Model, velocity_field Field>
flow_lines colour_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                          const Model& model, const Field& field, const doppler_settings& settings = {}) {
    return colour_scanner<Model>{}.acquire(policy, body, probe, at, model, field, settings);
}
/// The same with `physical`.
template <exec::policy Policy, transducer Probe, velocity_field Field>
flow_lines colour_doppler(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                          const Field& field, const doppler_settings& settings = {}) {
    return colour_doppler(policy, body, probe, at, physical<>{}, field, settings);
}

/// What counts as flow in a picture.
struct doppler_picture_settings {
    uvec2 size{0, 0};          ///< columns, rows: see `scan_convert_settings`
    float min_power_db = -126; ///< weaker echoes show no flow; electronic noise is at -135 dB. 0 dB is a perfect mirror
    float min_velocity = 0;    ///< slower flow is not shown, m/s

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(min_power_db) || !is_finite(min_velocity))
            throw usage_error{"doppler_picture: `min_power_db` and `min_velocity` must be finite"};
    }

    friend bool operator==(const doppler_picture_settings&, const doppler_picture_settings&) = default;
};

/// What a colour means: velocity towards the probe from red to yellow, away from it from blue to cyan; or power from
/// dark red to yellow.
enum class doppler_map { velocity, power };

/// Settings of `colour_overlay`.
struct colour_overlay_settings {
    doppler_map map = doppler_map::velocity; ///< what is shown
    float max_velocity = 0;                  ///< of the brightest colour, m/s; 0: the largest that does not alias
    float power_range_db = 30;               ///< from the darkest to the brightest colour of `doppler_map::power`
    float min_power_db = -126;               ///< see `doppler_picture_settings`
    float min_velocity = 0;                  ///< likewise, m/s
    float max_grey = 0.6F; ///< priority: brighter tissue is shown in grey, 0 (never colour) to 1 (always colour)

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(min_power_db) || !is_finite(min_velocity) || !is_finite(max_velocity) || !(max_velocity >= 0) ||
            !is_finite(power_range_db) || !(power_range_db > 0) || !is_finite(max_grey))
            throw usage_error{"colour_overlay: `power_range_db` must be above 0, `max_velocity` at least 0, and both, "
                              "`min_power_db`, `min_velocity` and `max_grey` finite"};
    }

    friend bool operator==(const colour_overlay_settings&, const colour_overlay_settings&) = default;
};

/// The colour of a velocity. @param fraction  of the largest, -1 (away) to 1 (towards the probe)
INSONIFY_FN inline vec3 velocity_colour(float fraction) {
    const float fast = min(std::fabs(fraction), 1), strong = 0.35F + 0.65F * min(1.6F * fast, 1),
                bright = max(fast - 0.35F, 0) / 0.65F;
    return fraction > 0 ? vec3{strong, 0.9F * bright, 0} : vec3{0, 0.9F * bright, strong};
}
/// The colour of a power. @param fraction  0 (weakest) to 1 (strongest)
INSONIFY_FN inline vec3 power_colour(float fraction) {
    const float level = clamp(fraction, 0, 1);
    return {0.35F + 0.65F * min(1.5F * level, 1), 0.9F * max(level - 0.3F, 0) / 0.7F, 0.1F * level};
}

/// Velocity of each pixel, m/s, towards the probe positive; 0 where there is no flow.
/// @param probe  that the lines are of
/// @throws usage_error  for lines that are empty or not those of the probe, or a setting out of range
template <exec::policy Policy, transducer Probe>
image doppler_picture(const Policy& policy, const flow_lines& lines, const Probe& probe,
                      const doppler_picture_settings& settings = {}) {
    settings.check();
    const scan_map map = make_scan_map(policy, probe, detail::acquisition_of(lines), {.size = settings.size});
    image picture{map.size};
    detail::for_each_flow_pixel(policy, lines, map, settings,
                                [&](std::size_t i, const flow_sample& of) { picture.pixels[i] = of.velocity; });
    return picture;
}

/// Colour over a B-mode image: flow is coloured where the image is dark enough, the rest is grey.
///
///     const image grey = b_mode(exec::par_unseq, body, probe, at, {.depth = 40_mm});
///     const flow_lines seen = colour_doppler(exec::par_unseq, body, probe, at, stream, {.depth = 40_mm});
///     write_png("duplex.png", colour_overlay(exec::par, grey, seen, probe));
///
/// @param grey      an image of the same probe and depth
/// @param map       of the probe, the depth and the samples of the lines, and the size of the image
/// @param recycled  an image whose memory is reused
/// @throws usage_error  for lines that do not match the map, an image of another size, or a setting out of range
template <exec::policy Policy>
colour_image colour_overlay(const Policy& policy, const image& grey, const flow_lines& lines, const scan_map& map,
                            const colour_overlay_settings& settings = {}, colour_image recycled = {}) {
    settings.check();
    if (grey.size != map.size || grey.pixels.size() != map.first.size())
        throw usage_error{"colour_overlay: the image has no pixels, not as many as its size says, or not the size of "
                          "the map"};
    recycled.size = grey.size;
    recycled.pixels.resize(grey.pixels.size());
    const float fastest = settings.max_velocity > 0 ? settings.max_velocity : max(lines.max_velocity, 1e-9F);
    detail::for_each_flow_pixel(policy, lines, map, settings, [&](std::size_t i, const flow_sample& of) {
        const float level = clamp(grey.pixels[i], 0, 1);
        if (level > settings.max_grey || of.power == 0)
            recycled.pixels[i] = vec3{level};
        else if (settings.map == doppler_map::velocity)
            recycled.pixels[i] = velocity_colour(of.velocity / fastest);
        else
            recycled.pixels[i] =
                power_colour((10 * std::log10(of.power) - settings.min_power_db) / max(settings.power_range_db, 1e-3F));
    });
    return recycled;
}
/// The same with a temporary map. @param probe  that the lines are of
template <exec::policy Policy, transducer Probe>
colour_image colour_overlay(const Policy& policy, const image& grey, const flow_lines& lines, const Probe& probe,
                            const colour_overlay_settings& settings = {}) {
    return colour_overlay(policy, grey, lines,
                          make_scan_map(policy, probe, detail::acquisition_of(lines), {.size = grey.size}), settings);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
