#ifndef INSONIFY_ACOUSTICS_PHYSICAL_HPP
#define INSONIFY_ACOUSTICS_PHYSICAL_HPP

#include <insonify/acoustics/attenuation.hpp>
#include <insonify/acoustics/cell_field.hpp>
#include <insonify/acoustics/echo_line.hpp>
#include <insonify/acoustics/fresnel.hpp>
#include <insonify/acoustics/roughness.hpp>
#include <insonify/acoustics/specular.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Where an echo is displayed: at its travel time through the media, or as if sound had `display_speed` in all of them.
enum class timing { sound_speed, uniform };

/// Angle at which beams meet surfaces: as they do, or as if each were met head on.
enum class angle { oblique, normal };

/// How attenuation treats the pulse: as one frequency, or as a band of them, which loses less (see `attenuated`). The
/// echo's carrier stays where it is: `attenuated` tells by how much it would sink.
enum class pulse_band { narrow, broad };

/// What has become of the sound on its way along a line.
struct echo_path {
    float shown = 0;   ///< displayed depth, metres
    float lost_db = 0; ///< to attenuation, there and back
    float passed = 1;  ///< amplitude that interfaces have let through, there and back
};

/// The pulse-echo model: pressure amplitudes, complex and at baseband, ready for `convolve`.
///
///     interface   r(i) exp(-2 k^2 h^2 cos^2 i) L(phi) + diffuse,  at its travel time        specular echo, roughness
///     between     backscatter * 10^(-55/20) * complex Gaussian field                         texture of the tissue
///     both times  product of what interfaces let through there and back * 10^(-loss / 20)    what arrives
///
/// Of the echo of a tilted surface `convolve` and the planes of the slice take a part, for its phase differs from line to
/// line; L contains that already, so it is divided out beforehand.
///
/// Amplitude 1 is the echo of a perfect mirror met head on without attenuation. An echo a displayed at depth z is written
/// as a exp(-j 4 pi f0 z / c0), divided between the two samples beside it.
/// @tparam Boundary    an `interface_law`: what is reflected and what goes on
/// @tparam Scattering  a `scattering_field`: the texture
/// @tparam Specular    a `specular_law`: what the aperture collects of mirror echoes
/// @tparam Roughness   a `roughness_law`: what rough surfaces take from them and scatter
/// @tparam Attenuation an `attenuation_law`
template <interface_law Boundary = fresnel, scattering_field Scattering = gaussian_field<>,
          specular_law Specular = specular_return, roughness_law Roughness = kirchhoff,
          attenuation_law Attenuation = power_law>
struct physical {
    using sample_type = vec2; ///< in phase, in quadrature

    Boundary boundary{};                                      ///< what interfaces reflect and let through
    Scattering scattering{};                                  ///< texture
    Specular specular{};                                      ///< what the aperture collects of mirror echoes
    insonify::timing timing = insonify::timing::sound_speed;  ///< where echoes are displayed
    insonify::angle angle = insonify::angle::oblique;         ///< at which surfaces are met
    insonify::pulse_band band = insonify::pulse_band::narrow; ///< what attenuation does to a pulse
    float texture_db = -55;                                   ///< echo of liver's texture against a perfect mirror
    float shadow_floor_db = -FLT_MAX; ///< no shadow is deeper than this below what the background would let through
    std::uint32_t seed = 0x5EED;      ///< of the diffuse echoes of rough surfaces
    Roughness roughness{};            ///< what rough surfaces scatter
    Attenuation attenuation{};        ///< dB a metre

    /// The same model with another law at interfaces.
    template <interface_law Law>
    physical<Law, Scattering, Specular, Roughness, Attenuation> with_boundary(const Law& law) const {
        return with(law, scattering, specular, roughness, attenuation);
    }
    /// The same model with another texture.
    template <scattering_field Field>
    physical<Boundary, Field, Specular, Roughness, Attenuation> with_scattering(const Field& field) const {
        return with(boundary, field, specular, roughness, attenuation);
    }
    /// The same model with another specular return.
    template <specular_law Law>
    physical<Boundary, Scattering, Law, Roughness, Attenuation> with_specular(const Law& law) const {
        return with(boundary, scattering, law, roughness, attenuation);
    }
    /// The same model with other rough surfaces.
    template <roughness_law Law>
    physical<Boundary, Scattering, Specular, Law, Attenuation> with_roughness(const Law& law) const {
        return with(boundary, scattering, specular, law, attenuation);
    }
    /// The same model with another attenuation.
    template <attenuation_law Law>
    physical<Boundary, Scattering, Specular, Roughness, Law> with_attenuation(const Law& law) const {
        return with(boundary, scattering, specular, roughness, law);
    }

    /// @throws usage_error  naming the setting that makes no sense
    void check() const {
        if (!is_finite(texture_db)) throw usage_error{"physical: `texture_db` must be a finite number of dB"};
        if (!(shadow_floor_db <= 0))
            throw usage_error{
                "physical: `shadow_floor_db` must be 0 or below, such as -20; by default there is no floor"};
        if constexpr (requires { scattering.check(); }) scattering.check();
        if constexpr (requires { specular.check(); }) specular.check();
    }

    /// Samples of a line where the caller leaves it open: two for each deviation of the pulse, a multiple of 64.
    INSONIFY_FN std::uint32_t samples(float depth, float frequency) const {
        return samples_for(depth, nominal_sigma(frequency));
    }

    /// Sound fast on its way is displayed early: the line goes on until the time is spent, and a little further, so that
    /// no scatterer is cut at the last sample.
    INSONIFY_FN float reach(float depth, view<const medium> media) const {
        float fastest = display_speed;
        for (const medium& m : media) fastest = greater(fastest, m.sound_speed);
        return 1e-3F + (timing == insonify::timing::sound_speed ? depth * fastest / display_speed : depth);
    }

    /// Of texture on neighbouring lines, and of the diffuse echoes of rough surfaces; see `scattering_field`.
    INSONIFY_FN float covariance(float apart, float turned) const { return scattering.covariance(apart, turned); }
    /// The same of the diffuse echoes of rough surfaces.
    INSONIFY_FN float surface_covariance(float apart, float turned) const {
        return surface_field().covariance(apart, turned);
    }

    /// Adds the echoes of one line to samples that start at 0; sample k stands at displayed depth (k + 1/2) * spacing.
    template <class Policy>
    INSONIFY_FN void operator()(const Policy&, const traced_line& line, float spacing, view<vec2> out) const {
        const echo_line echoes{out, spacing, line.frequency};
        echo_path path{};
        for (std::size_t i = 0; i < line.layers.size() && path.shown < echoes.depth(); ++i) {
            add_layer(line, line.layers[i], path, echoes);
            if (i + 1 < line.layers.size() && line.layers[i + 1].medium != line.layers[i].medium)
                path.passed *= add_interface(line, line.layers[i], line.layers[i + 1], path, echoes).transmitted;
        }
    }

    /// Adds the texture of a layer, which `path` then has gone through.
    INSONIFY_FN void add_layer(const traced_line& line, const layer& here, echo_path& path,
                               const echo_line& echoes) const {
        const medium& m = line.media[here.medium];
        add_texture(line, here, m, path, echoes);
        path.shown += (here.end - here.begin) * stretch(m);
        path.lost_db += (here.end - here.begin) * attenuation(m, line.frequency);
    }

    /// Adds the echo of the surface between two layers, at which `path` stands; returns what the law says of it.
    INSONIFY_FN response add_interface(const traced_line& line, const layer& above, const layer& below,
                                       const echo_path& path, const echo_line& echoes) const {
        const medium &before = line.media[above.medium], &after = line.media[below.medium];
        const bool head_on = angle == insonify::angle::normal;
        const float cosine = head_on ? 1.0F : below.cosine;
        const vec2 tilt = head_on ? vec2{0, 0} : below.tilt;
        const incidence meeting{before, after, cosine, line.frequency};
        const response met = boundary(meeting);
        const beam_sample beam = line.beam.at(path.shown);
        const float arrived = arriving(line, path.passed, path.lost_db, path.shown);

        const float wavelengths = greater(path.shown, 1e-4F) * line.frequency / display_speed;
        const vec2 slope = stretch(before) * slope_of(tilt);
        const float collected = specular(tilt.x, beam.fnumber, wavelengths) *
                                specular(tilt.y, beam.elevation_fnumber, wavelengths) /
                                (across_the_lines(line, slope.x, beam) * across_the_planes(line, slope.y, path.shown));
        const float coherent = arrived * met.reflected * roughness.coherent(meeting) * collected;
        if (coherent != 0) echoes.add(path.shown, {coherent, 0});

        // A Lambert lobe over the array's solid angle, by an independent calibration: 0.166 / (F#x F#y).
        const float scattered = met.reflected * met.reflected * roughness.diffuse(meeting);
        const float diffuse =
            arrived * std::sqrt(scattered * 0.166F / (beam.fnumber * beam.elevation_fnumber)) * cosine;
        if (diffuse > 0) add_diffuse(line, below, stretch(before), slope, diffuse, path, echoes);
        return met;
    }

    friend bool operator==(const physical&, const physical&) = default;

  private:
    template <class A, class B, class C, class D, class E>
    physical<A, B, C, D, E> with(const A& a, const B& b, const C& c, const D& d, const E& e) const {
        return {a, b, c, timing, angle, band, texture_db, shadow_floor_db, seed, d, e};
    }

    // Displayed metres a metre of the medium.
    INSONIFY_FN float stretch(const medium& m) const {
        return timing == insonify::timing::sound_speed ? displayed_stretch(m) : 1.0F;
    }

    INSONIFY_FN static float amplitude_of(float decibels) { return std::exp2(0.16609640F * decibels); } // log2(10) / 20

    // Of a pulse of 2.5 cycles, whose bandwidth is 1.61 / 2.5.
    INSONIFY_FN static float nominal_sigma(float frequency) { return axial_sigma(0.644F, frequency); }

    INSONIFY_FN static float sigma_of(const traced_line& line) {
        return line.pulse_sigma > 0 ? line.pulse_sigma : nominal_sigma(line.frequency);
    }

    // Amplitude that arrives and comes back, `lost_db` down a line at displayed depth `shown`.
    INSONIFY_FN float arriving(const traced_line& line, float passed, float lost_db, float shown) const {
        const float frequency = line.frequency;
        const float peak_loss = band == insonify::pulse_band::broad
                                    ? attenuated(lost_db, frequency, nominal_bandwidth(line)).loss_db
                                    : lost_db;
        const float direct = passed * amplitude_of(-peak_loss);
        if (shadow_floor_db == -FLT_MAX) return direct;
        return greater(direct, amplitude_of(shadow_floor_db - shown * attenuation(line.media[0], frequency)));
    }

    INSONIFY_FN static float nominal_bandwidth(const traced_line& line) {
        return axial_sigma(sigma_of(line), line.frequency); // the formula is its own inverse
    }

    INSONIFY_FN void add_texture(const traced_line& line, const layer& here, const medium& m, const echo_path& path,
                                 const echo_line& echoes) const {
        if (!(m.backscatter > 0)) return;
        const float shrink = stretch(m), loss = attenuation(m, line.frequency);
        const float sigma = sigma_of(line);
        const float slot = lesser(slot_of(line.frequency), 0.5F * sigma / shrink); // fine for slow media too
        const float along = std::sqrt(std::sqrt(pi) * sigma / (slot * shrink)); // root of the pulse's power over slots
        const float level = m.backscatter * amplitude_of(texture_db) / along;
        const pose place = line.places.empty() ? pose{} : line.places[here.place];
        const float end = lesser(here.end, here.begin + (echoes.depth() - path.shown) / shrink + slot);
        const material_line within = in_object(line.frame, place, here.object, m.scatterer_density);
        scattering.scatter(within, here.begin, end, slot, [&](const scatterer_run& run) {
            const auto at = [&](float distance) {
                const float into = distance - here.begin, shown = path.shown + into * shrink;
                const beam_sample beam = line.beam.at(shown);
                return lesser(level * beam.incoherent * upright(line.frequency, run.slope * shrink, beam) *
                                  arriving(line, path.passed, path.lost_db + into * loss, shown),
                              1e20F); // so that sums stay finite, whatever the medium
            };
            const float length = run.step * static_cast<float>(run.count);
            const float first = at(run.first), last = at(run.first + length);
            // At -300 dB nothing is heard, and ratios to less might overflow.
            const float ratio =
                first > 1e-15F && last > 0 ? std::exp2(std::log2(last / first) / static_cast<float>(run.count)) : 1.0F;
            echoes.add(path.shown + (run.first - here.begin) * shrink, run.step * shrink, run.count, run.real,
                       run.imaginary, first, ratio);
        });
    }

    // No echo is raised further than by one over this: of a surface that is curved or small less is taken.
    static constexpr float least_share = 0.15F;

    // What `convolve` will take from the echo of a tilted surface, because its phase and depth differ from line to line.
    // The specular return contains that already, so it is divided out. A slope of s metres of depth a metre across gives
    // the lines' Gaussian, narrowed to where the pulse still reaches, 1 / sigma'^2 = 1 / sigma_x^2 + s^2 / sigma_z^2, and
    // its spectrum at the phase's slope of 4 pi f0 s / c0 and at the nearest aliases of the lines.
    INSONIFY_FN static float across_the_lines(const traced_line& line, float slope, const beam_sample& beam) {
        if (!(beam.lateral_sigma > 0) || !(beam.line_spacing > 0)) return 1;
        const float sigma_z = sigma_of(line);
        const float narrowed = 1 / std::sqrt(1 + square(beam.lateral_sigma * slope / sigma_z));
        const float phase = phase_per_metre(line.frequency) * slope, alias = 2 * pi / beam.line_spacing;
        const float nearest = phase - alias * std::floor(phase / alias + 0.5F);
        float met = 0, all = 0;
        for (int i = -1; i <= 1; ++i) {
            const float shift = static_cast<float>(i) * alias;
            met += std::exp(-0.5F * square(narrowed * beam.lateral_sigma * (nearest + shift)));
            all += std::exp(-0.5F * square(beam.lateral_sigma * shift));
        }
        return greater(narrowed * met / all, least_share);
    }

    // The same for the planes of the slice.
    INSONIFY_FN static float across_the_planes(const traced_line& line, float slope, float shown) {
        const float left = line.beam.across_the_planes(shown, slope, sigma_of(line), phase_per_metre(line.frequency));
        return greater(left, least_share);
    }

    // Metres of displayed depth a metre across, for a surface so much tilted.
    INSONIFY_FN static vec2 slope_of(vec2 tilt) {
        return {std::tan(clamped(tilt.x, -1.4F, 1.4F)), std::tan(clamped(tilt.y, -1.4F, 1.4F))};
    }

    // Radians of an echo's phase a metre of displayed depth.
    INSONIFY_FN static float phase_per_metre(float frequency) { return 4 * pi * frequency / display_speed; }

    // The level of texture is that of scatterers whose echoes on neighbouring lines have one depth. On a slope their
    // phases part: of two lines d apart by 4 pi f0 s d / c0, and what they have in common counts by its cosine.
    INSONIFY_FN static float upright(float frequency, vec2 slope, const beam_sample& beam) {
        const vec2 spread =
            square(phase_per_metre(frequency)) * slope * slope * beam.alike; // mean square of the angles
        return std::exp(0.25F * lesser(spread.x + spread.y, 4));
    }

    INSONIFY_FN gaussian_field<> surface_field() const { return {.seed = seed}; }

    // Metres along the line that a scatterer of texture stands for.
    INSONIFY_FN static float slot_of(float frequency) { return display_speed / (8 * frequency); }

    // A rough surface is spread over the depths that the line's width and height cover on it: independent parts, of one
    // power in all, for otherwise a steep one would be a staircase.
    //
    // Its level is that of a surface met head on. On a slope two lines d apart meet it s d deeper: other slots, with
    // other phases. Both Gaussian, what they have in common falls by exp(-(s d)^2 (1 / l^2 + k^2) / 2), where l are 0.632
    // slots, over which the field is alike, and k the phase a metre; at the end they have nothing in common.
    INSONIFY_FN void add_diffuse(const traced_line& line, const layer& below, float shrink, vec2 slope, float amplitude,
                                 const echo_path& path, const echo_line& echoes) const {
        const pose place = line.places.empty() ? pose{} : line.places[below.place];
        const material_line inside = in_object(line.frame, place, below.object);
        const gaussian_field<> surface = surface_field();
        const beam_sample beam = line.beam.at(path.shown);
        const float slot = slot_of(line.frequency);
        const float per_metre = 1 / square(0.632F * slot) + square(phase_per_metre(line.frequency));
        const vec2 apart = vec2{1, 1} + slope * slope * beam.surface_alike * per_metre;
        const float spread = lesser(beam.line_spacing * std::fabs(slope.x) + line.height * std::fabs(slope.y), 3e-3F);
        const float part = greater(0.5F * sigma_of(line), 1e-6F);
        const auto parts = static_cast<int>(std::ceil(spread / part)) + 1;
        const float level = lesser(beam.surface_incoherent * std::sqrt(std::sqrt(apart.x * apart.y)), beam.independent);
        const float each = amplitude * level / std::sqrt(static_cast<float>(parts));
        for (int i = 0; i < parts; ++i) {
            const float deeper = (static_cast<float>(i) - 0.5F * static_cast<float>(parts - 1)) * part;
            echoes.add(path.shown + deeper, surface.value(inside, below.begin + deeper / shrink, slot) * each);
        }
    }

    INSONIFY_FN static float square(float x) { return x * x; }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
