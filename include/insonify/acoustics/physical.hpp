#ifndef INSONIFY_ACOUSTICS_PHYSICAL_HPP
#define INSONIFY_ACOUSTICS_PHYSICAL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/scatterers/cell_field.hpp>
#include <insonify/acoustics/scatterers/scattering.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/execution/policy.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The pulse-echo model: complex pressure amplitudes at baseband, as input for `convolve`.
///
///     specular   T A r(i) exp(-2 k^2 h^2 cos^2 i) L(phi_x) L(phi_y)          `fresnel`, `kirchhoff`, `specular_return`
///     diffuse    T A sqrt(r^2 (1 - exp(-4 k^2 h^2 cos^2 i)) B(i) 0.166 / (Fx Fy)), rms   B: `scattered_back`
///     speckle    T A backscatter 10^(texture_db / 20), rms                   `gaussian_field`
///
/// T is the product of the interfaces' transmission there and back, A = 10^(-loss / 20) the attenuation of the peak of
/// the pulse there and back (`echo_loss`, `attenuated`). r is the pressure reflection at the angle of incidence i, k
/// the wave number in 1/m, h the rms height in m; phi and F are tilt and F-number in the slice plane (x) and out of it
/// (y).
///
/// Amplitude 1 is the echo of a perfect mirror at normal incidence without attenuation. `echo_line` defines how an echo
/// is written to the samples. Source: see each law.
/// @tparam Boundary    an `interface_law`: reflection and transmission
/// @tparam Scattering  a `scattering_field`: the speckle
/// @tparam Specular    a `specular_law`: the fraction of specular echoes that the aperture collects
/// @tparam Roughness   a `roughness_law`: coherent and diffuse echoes of rough surfaces
/// @tparam Attenuation an `attenuation_law`: dB per metre
template <interface_law Boundary = fresnel, scattering_field Scattering = gaussian_field,
          specular_law Specular = specular_return, roughness_law Roughness = kirchhoff,
          attenuation_law Attenuation = power_law>
struct physical {
    using sample_type = vec2; ///< in-phase and quadrature component

    /// The surface at which the present layer began.
    struct layer_entry {
        float reflected = 0;             ///< there, from outside; 0: the probe's face
        float shown = 0;                 ///< displayed depth, metres
        float loss_db = 0;               ///< attenuation up to there, there and back, of the peak of the pulse, dB
        const layer* present = nullptr;  ///< which begins there
        const medium* outside = nullptr; ///< before it
    };

    Boundary boundary{};                                     ///< reflection and transmission at interfaces
    Scattering scattering{};                                 ///< speckle
    Specular specular{};                                     ///< fraction of specular echoes that the aperture collects
    insonify::timing timing = insonify::timing::sound_speed; ///< depth at which echoes are displayed
    insonify::angle angle = insonify::angle::oblique;        ///< of incidence
    insonify::pulse_bandwidth bandwidth = insonify::pulse_bandwidth::broad; ///< of the pulse under attenuation
    float texture_db = -55;           ///< level of the speckle of liver relative to a perfect mirror
    float shadow_floor_db = -FLT_MAX; ///< lower bound on the level of speckle relative to soft tissue alone
    std::uint32_t seed = 0x5EED;      ///< of the diffuse echoes of rough surfaces
    Roughness roughness{};            ///< of surfaces
    Attenuation attenuation{};        ///< dB per metre, there and back
    /// Thin hard layers, such as a needle, ring on straight lines: their far surface repeats its echo where each
    /// repetition has at least this fraction of the one before; 1: none rings.
    float min_ringing = 0.5F;

    /// The same model with another interface law.
    auto with_boundary(const interface_law auto& law) const {
        return with(law, scattering, specular, roughness, attenuation);
    }
    /// The same model with another scatterer field.
    auto with_scattering(const scattering_field auto& field) const {
        return with(boundary, field, specular, roughness, attenuation);
    }
    /// The same model with another specular law.
    auto with_specular(const specular_law auto& law) const {
        return with(boundary, scattering, law, roughness, attenuation);
    }
    /// The same model with another roughness law.
    auto with_roughness(const roughness_law auto& law) const {
        return with(boundary, scattering, specular, law, attenuation);
    }
    /// The same model with another attenuation law.
    auto with_attenuation(const attenuation_law auto& law) const {
        return with(boundary, scattering, specular, roughness, law);
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(texture_db)) throw usage_error{"physical: `texture_db` must be a finite number of dB"};
        if (!(shadow_floor_db <= 0))
            throw usage_error{
                "physical: `shadow_floor_db` must be 0 or below, such as -20; by default there is no floor"};
        if (!(min_ringing > 0) || !(min_ringing <= 1))
            throw usage_error{
                "physical: `min_ringing` must be above 0 and at most 1, such as 0.5; at 1 no layer rings"};
        if constexpr (requires { scattering.check(); }) scattering.check();
        if constexpr (requires { specular.check(); }) specular.check();
    }

    /// Default number of samples of a line, for a pulse of 2.5 cycles: see `samples_for`.
    INSONIFY_FN std::uint32_t samples(float depth, float frequency) const {
        return samples_for(depth, nominal_sigma(frequency));
    }

    /// Length of the line to trace, metres: at least as far as sound in the fastest medium travels in the time of the
    /// last sample, with a margin for the scatterers of that sample.
    INSONIFY_FN float max_depth(float depth, view<const medium> media) const {
        float fastest = display_speed;
        for (const medium& m : media) fastest = max(fastest, m.sound_speed);
        return 1e-3F + (timing == insonify::timing::sound_speed ? depth * fastest / display_speed : depth);
    }

    /// Covariance of the speckle of two lines: see `scattering_field`.
    INSONIFY_FN float covariance(float distance, float radians) const {
        return scattering.covariance(distance, radians);
    }
    /// Whether the speckle of each elevation plane is independent of the others'.
    static constexpr bool independent_planes = requires { Scattering::independent_planes; };
    /// Covariance of the diffuse echoes of rough surfaces on two lines.
    INSONIFY_FN float surface_covariance(float distance, float radians) const {
        return surface_field().value_covariance(distance, radians);
    }

    /// Reflection and transmission of an interface by the model's interface law.
    INSONIFY_FN response at_interface(const incidence& at) const {
        if (angle != insonify::angle::normal) return boundary(at);
        incidence normal = at;
        normal.cosine = 1;
        return boundary(normal);
    }
    /// The direction of sound behind an interface, by the interface law's own `refracted` or by Snell's law; {0, 0, 0}
    /// where it is totally reflected. Unchanged where all media have one speed (`timing::uniform`) or all incidence is
    /// normal.
    INSONIFY_FN vec3 refracted(vec3 direction, vec3 normal, const medium& before, const medium& after) const {
        if (timing == insonify::timing::uniform || angle == insonify::angle::normal) return direction;
        if constexpr (requires { boundary.refracted(direction, normal, before, after); })
            return boundary.refracted(direction, normal, before, after);
        else
            return insonify::refracted(direction, normal, before, after);
    }
    /// Attenuation of an echo per metre of a medium, there and back, dB/m; the frequency is in hertz.
    INSONIFY_FN float loss(const medium& m, float frequency) const { return attenuation(m, frequency); }
    /// What the peak of the pulse of a line loses, dB; that of its carrier if the line states neither bandwidth nor
    /// pulse.
    /// @param loss_db  what its carrier would lose alone
    INSONIFY_FN float pulse_loss(const traced_line& line, float loss_db) const {
        if (bandwidth == pulse_bandwidth::narrow || !(max(line.bandwidth, line.pulse_sigma) > 0)) return loss_db;
        const float fractional =
            line.bandwidth > 0 ? line.bandwidth : axial_sigma(line.pulse_sigma, line.frequency); // its own inverse
        return attenuated(loss_db, line.frequency, fractional).loss_db;
    }

    /// What arrives along a line, at equal steps of depth: x, the amplitude there and back, 1 at the probe face, and y,
    /// the displayed depth; element k at (k + 1) * spacing. From these, tracers compute `aperture_gains`.
    INSONIFY_FN void arrivals(const traced_line& line, float spacing, view<vec2> out) const {
        std::size_t k = 0;
        const auto transmitted = [&](std::size_t i, const layer& here, const echo_path&) {
            const medium& before = line.media[line.layers[i - 1].medium];
            return at_interface({before, line.media[here.medium], here.cosine, line.frequency}).transmitted;
        };
        detail::follow_sound(*this, line, transmitted, [&](std::size_t i, const layer& here, const echo_path& path) {
            const medium& m = line.media[here.medium];
            const float per_metre = attenuation(m, line.frequency), displayed = detail::displayed_stretch(timing, m);
            const auto loss_at = [&](float within) { return pulse_loss(line, path.lost_at(within, per_metre)); };
            const bool last = i + 1 == line.layers.size();
            // Exact at every eighth step; between them, the logarithm of the amplitude is a polynomial of degree two.
            float amplitude = 0, step = 1, bend = 1;
            std::uint32_t left = 0; // steps to the next exact one
            for (; k < out.size() && (last || static_cast<float>(k + 1) * spacing < here.end); ++k) {
                const float within = static_cast<float>(k + 1) * spacing - here.begin;
                if (left > 0) {
                    amplitude *= step;
                    step *= bend;
                    --left;
                } else {
                    const float lost = loss_at(within);
                    amplitude = path.passed * amplitude_of_decibels(-lost);
                    if (path.refraction.length(within) > 0) {
                        const float next = loss_at(within + spacing), after = loss_at(within + 2 * spacing);
                        step = amplitude_of_decibels(lost - next);
                        bend = amplitude_of_decibels((next - lost) - (after - next));
                        left = 7;
                    }
                }
                out[k] = {amplitude, path.shown + within * displayed};
            }
            return k < out.size();
        });
    }

    /// Adds the echoes of one line to samples that start at 0; sample k lies at displayed depth (k + 1/2) * spacing.
    template <class Policy>
    INSONIFY_FN void operator()(const Policy&, const traced_line& line, float spacing, view<vec2> out) const {
        emit(line, echo_line{out, spacing, line.frequency});
    }

    /// Emits the echoes of one line to `echoes`: an `echo_line`, or another type with its members.
    template <class Echoes>
    INSONIFY_FN void emit(const traced_line& line, const Echoes& echoes) const {
        layer_entry entry{};
        const auto add_surface = [&](std::size_t i, const layer& here, const echo_path& path) {
            const layer& above = line.layers[i - 1];
            const response met = add_interface(line, above, here, path, echoes, entry);
            entry = {met.reflected, path.shown, pulse_loss(line, path.loss_db), &line.layers[i],
                     &line.media[above.medium]};
            return met.transmitted;
        };
        detail::follow_sound(*this, line, add_surface, [&](std::size_t, const layer& here, const echo_path& path) {
            if (path.shown + path.gains.min_deeper() >= echoes.depth()) return false;
            emit_speckle(line, here, path, echoes);
            return true;
        });
    }

    /// Emits the speckle of one layer, from `path` at its beginning on.
    template <class Echoes>
    INSONIFY_FN void emit_speckle(const traced_line& line, const layer& here, const echo_path& path,
                                  const Echoes& echoes) const {
        const medium& m = line.media[here.medium];
        const float begin = path.shown + path.gains.min_deeper();
        if (!(m.backscatter > 0) || begin >= echoes.depth()) return;
        const float displayed = detail::displayed_stretch(timing, m);
        const float per_metre = attenuation(m, line.frequency);
        const float sigma = line.pulse_sigma > 0 ? line.pulse_sigma : nominal_sigma(line.frequency);
        float slot = scatterer_spacing(sigma / displayed); // shorter in slow media
        if (m.flowing) slot = min(slot, scatterer_spacing_in_flow(line.frequency));
        // The pulse sums the power of the slots that it covers: sqrt(pi) sigma over the displayed length of a slot.
        const float pulse_gain = std::sqrt(std::sqrt(pi) * sigma / (slot * displayed));
        float level = m.backscatter * amplitude_of_decibels(texture_db) / pulse_gain;
        const pose place = line.places.empty() ? pose{} : line.places[here.place];
        const float end = min(here.end, here.begin + (echoes.depth() - begin) / displayed + slot);
        material_line within = in_object(line.frame, place, here.object, m.scatterer_density);
        within.height = line.aperture.height;
        within.plane = line.plane;
        within.aperture = &line.aperture;
        within.displayed = {path.shown - here.begin * displayed, displayed};
        within.tilt = line.frame.tilt;
        within.surfaces = {here.begin, here.end};
        within.flowing = m.flowing;
        within.frame_number = m.flowing ? line.frame_number : 0;
        within.displacement = line.displacement(here.place);
        within.steering = place.local_direction(line.frame.steering);
        if (!m.structure.empty() && here.place < line.structures.size() &&
            line.structures[here.place].of == m.structure) {
            within.fnumber = line.aperture.fnumber(path.shown + 0.5F * (here.end - here.begin) * displayed);
            within.structure = &line.structures[here.place];
            within.own_begin = {here.own_begin.cosine, place.local_direction(here.own_begin.normal)};
            within.own_end = {here.own_end.cosine, place.local_direction(here.own_end.normal)};
            level /= within.structure->rms(within.fnumber);
        }
        scattering.scatter(within, here.begin, end, slot, [&](const scatterer_run& run) {
            const auto length = static_cast<float>(run.count) * run.step;
            const aperture_gain first = path.gains.at(run.first), last = path.gains.at(run.first + length);
            const auto shown_at = [&](float distance, const aperture_gain& gain) {
                return path.shown + (distance - here.begin) * displayed + gain.deeper;
            };
            const auto level_at = [&](float distance, const aperture_gain& gain) {
                const float loss_db = pulse_loss(line, path.lost_at(distance - here.begin, per_metre));
                float arrived = line.gains.amplitude(path.passed * amplitude_of_decibels(-loss_db), gain.speckle);
                if (shadow_floor_db != -FLT_MAX) {
                    const float tissue_db = pulse_loss(line, path.tissue_lost_at(distance - here.begin));
                    arrived = max(arrived, amplitude_of_decibels(shadow_floor_db - tissue_db));
                }
                return min(level * arrived, 1e20F); // keeps sums finite
            };
            const float longer = (last.deeper - first.deeper) / static_cast<float>(run.count > 0 ? run.count : 1);
            echoes.scatterers({.depth = shown_at(run.first, first),
                               .step = max(run.step * displayed + longer, 0),
                               .count = run.count,
                               .real = run.real,
                               .imaginary = run.imaginary,
                               .first_level = level_at(run.first, first),
                               .last_level = level_at(run.first + length, last),
                               .slope = run.slope * displayed});
        });
    }

    /// Emits the echoes of the surface between two layers, at the position of `path`; returns the response of the
    /// interface.
    /// @param entry  the surface at which the layer above began; by default the echo does not repeat
    template <class Echoes>
    INSONIFY_FN response add_interface(const traced_line& line, const layer& above, const layer& below,
                                       const echo_path& path, const Echoes& echoes,
                                       const layer_entry& entry = {}) const {
        const medium &before = line.media[above.medium], &after = line.media[below.medium];
        const bool normal_incidence = angle == insonify::angle::normal;
        const float cosine = normal_incidence ? 1.0F : below.cosine;
        const vec2 tangent = normal_incidence ? vec2{0, 0} : below.slope;
        const incidence at{before, after, cosine, line.frequency, below.roughness};
        const response wave = at_interface(at);
        const float loss_db = pulse_loss(line, path.loss_db);
        const float arrived =
            line.gains.amplitude(path.passed * amplitude_of_decibels(-loss_db), path.gains.last().surfaces);
        const float shown = path.shown + path.gains.last().deeper;

        constexpr float steepest = 5.8F; // 80 degrees
        const float stretch = detail::displayed_stretch(timing, before);
        const vec2 slope = stretch * vec2{clamp(tangent.x, -steepest, steepest), clamp(tangent.y, -steepest, steepest)};
        curved_echo coherent{.depth = shown,
                             .amplitude = arrived * wave.reflected * roughness.coherent(at),
                             .collected = collected(line, shown, tangent),
                             .slope = slope,
                             .curvature = normal_incidence ? vec3{0, 0, 0} : stretch * below.curvature};
        if (min_ringing < 1) add_repetitions(coherent, line, entry, above, below, path.shown, loss_db, wave.reflected);
        if (normal_incidence && coherent.repeat_ratio == 0) // no surface turns from line to line
            echoes.surface(shown, coherent.amplitude * coherent.collected.x * coherent.collected.y, slope);
        else if (coherent.amplitude != 0)
            echoes.curved_surface(coherent);

        // Over the solid angle of the array Lambert's law has 0.166 / (Fx Fy), calibrated by an independent simulation.
        const float rough = roughness.diffuse(at);
        float diffuse = 0;
        if (rough > 0) {
            const bool hard = detail::is_hard(before) || detail::is_hard(after);
            const float reflected = hard ? wave.reflected : at_interface({before, after, 1, line.frequency}).reflected;
            const float fnumbers = line.aperture.fnumber(shown) * line.aperture.elevation_fnumber;
            diffuse =
                std::fabs(arrived * reflected) * std::sqrt(rough * scattered_back(hard, cosine) * 0.166F / fnumbers);
        }
        if (diffuse > 0) {
            const layer& owner = below.own_begin.cosine > 0 ? below : above; // of the surface, which moves with it
            const pose at_place = line.places.empty() ? pose{} : line.places[owner.place];
            material_line inside = in_object(line.frame, at_place, owner.object);
            inside.displacement = line.displacement(owner.place);
            const gaussian_field field = surface_field();
            const float at_rest = below.begin - below.moved.x; // at the first pulse of a train
            gaussian_field::surface_values values{field, inside, at_rest, detail::surface_grain(line.frequency)};
            echoes.rough_surface(shown, diffuse, slope, coherent.curvature,
                                 [&](float x) { return values(at_rest + x / stretch); });
        }
        return wave;
    }

    friend bool operator==(const physical&, const physical&) = default;

  private:
    template <class A, class B, class C, class D, class E>
    physical<A, B, C, D, E> with(const A& a, const B& b, const C& c, const D& d, const E& e) const {
        return {a, b, c, timing, angle, bandwidth, texture_db, shadow_floor_db, seed, d, e, min_ringing};
    }

    // Of a pulse of 2.5 cycles, whose fractional bandwidth is 1.61 / 2.5.
    INSONIFY_FN static float nominal_sigma(float frequency) { return axial_sigma(0.644F, frequency); }

    // Fractions that the aperture collects of the specular echo of a surface of this slope, as in `curved_echo`.
    INSONIFY_FN vec2 collected(const traced_line& line, float shown, vec2 slope) const {
        const float wavelengths = max(shown, 1e-4F) * line.frequency / display_speed;
        return {specular(std::atan(slope.x), line.aperture.fnumber(shown), wavelengths),
                specular(std::atan(slope.y), line.aperture.elevation_fnumber, wavelengths)};
    }

    // Sound reverberates in a thin hard layer, such as a needle, and each time part of it leaves towards the probe: the
    // echo of the layer's far surface repeats at its thickness, a ladder of lines that grow fainter.
    //
    //     ratio = r' r 10^(-loss / 20),   r' = -r of the near surface from outside
    //
    // for each time that sound crosses the layer and returns. Where the surfaces are not parallel, the ratio takes the
    // fraction of the first repetition that the aperture collects. Slopes, angles and thickness are those of the place
    // that is nearest to the probe: a needle rings alike in all planes that cut it.
    // @param far        the layer that begins at the far surface
    // @param shown      displayed depth of the far surface, metres
    // @param loss_db    attenuation down to it, there and back, of the peak of the pulse, dB
    // @param reflected  r of the far surface
    INSONIFY_FN void add_repetitions(curved_echo& one, const traced_line& line, const layer_entry& near,
                                     const layer& present, const layer& far, float shown, float loss_db,
                                     float reflected) const {
        constexpr float thickest = 2e-3F; // displayed: beyond, the beam has widened
        float step = shown - near.shown;
        if (near.reflected == 0 || !(step > 0) || step > thickest) return;
        const medium &inside = line.media[present.medium], &behind = line.media[far.medium];
        const float stretch = detail::displayed_stretch(timing, inside);
        const float speeds = inside.sound_speed / near.outside->sound_speed;
        vec2 near_slope = near.present->slope, far_slope = far.slope, whole = one.collected;
        float near_reflected = near.reflected;
        const vec2 near_bend{near.present->curvature.x, near.present->curvature.y},
            bend{far.curvature.x, far.curvature.y};
        // Metres across the line from there, at most half of the thickness.
        const float half = 0.5F * step / stretch;
        const auto nearest_along = [&](int i) {
            return bend[i] == 0 ? 0.0F : clamp(far_slope[i] / bend[i], -half, half);
        };
        const vec2 nearest{nearest_along(0), nearest_along(1)};
        if (nearest != vec2{0, 0}) {
            step += stretch * dot(near_slope - far_slope + 0.5F * (bend - near_bend) * nearest, nearest);
            near_slope -= near_bend * nearest;
            far_slope -= bend * nearest;
            const float sine = std::sqrt(dot(near_slope, near_slope) / (1 + dot(near_slope, near_slope))),
                        sine_inside = speeds * sine;
            if (sine_inside >= 1) return;
            const auto reflects = [&](const medium& from, const medium& to, float cosine) {
                return at_interface({from, to, cosine, line.frequency}).reflected;
            };
            near_reflected = reflects(*near.outside, inside, std::sqrt(1 - sine * sine));
            reflected = reflects(inside, behind, std::sqrt(1 - sine_inside * sine_inside));
            whole = collected(line, one.depth, far_slope);
        }
        const float ratio = -near_reflected * reflected * amplitude_of_decibels(min(near.loss_db - loss_db, 0));
        if (!(std::fabs(ratio) >= min_ringing)) return;
        // A wedge turns sound in the layer by twice its angle, and refraction changes that outside.
        const vec2 by = (far_slope - near_slope) / speeds;
        const vec2 turned = dot(by, by) < 1e-8F ? whole : collected(line, one.depth, far_slope + by);
        const float first = whole.x * whole.y;
        one.repeat_ratio = ratio * (first > 0 ? min(turned.x * turned.y / first, 1) : 0);
        one.repeat_step = step;
    }

    INSONIFY_FN gaussian_field surface_field() const { return {.seed = seed}; }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
