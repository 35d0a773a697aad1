#ifndef INSONIFY_ACOUSTICS_PHYSICAL_HPP
#define INSONIFY_ACOUSTICS_PHYSICAL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_line.hpp>
#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/emit_speckle.hpp>
#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/fresnel.hpp>
#include <insonify/acoustics/ringing.hpp>
#include <insonify/acoustics/roughness.hpp>
#include <insonify/acoustics/scatterers/cell_field.hpp>
#include <insonify/acoustics/specular.hpp>
#include <insonify/core/units.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The pulse-echo model: complex pressure amplitudes at baseband, as input for `convolve`.
///
///     specular   T A r(i) exp(-2 k^2 h^2 cos^2 i) L(phi_x) L(phi_y)          `fresnel`, `kirchhoff`, `specular_return`
///     diffuse    T A sqrt(r^2 (1 - exp(-4 k^2 h^2 cos^2 i)) 0.166 / (Fx Fy)) cos i, rms
///     speckle    T A backscatter 10^(texture_db / 20), rms                   `gaussian_field`
///
/// T is the product of the interfaces' transmission there and back, A = 10^(-loss / 20) the attenuation of the peak of the
/// pulse there and back (`echo_loss`, `attenuated`). r is the pressure reflection at the angle of incidence i, k the wave number
/// in 1/m, h the rms height in m; phi and F are tilt and F-number in the slice plane (x) and out of it (y).
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

    Boundary boundary{};                                     ///< reflection and transmission at interfaces
    Scattering scattering{};                                 ///< speckle
    Specular specular{};                                     ///< fraction of specular echoes that the aperture collects
    insonify::timing timing = insonify::timing::sound_speed; ///< depth at which echoes are displayed
    insonify::angle angle = insonify::angle::oblique;        ///< of incidence
    insonify::pulse_bandwidth bandwidth = insonify::pulse_bandwidth::broad; ///< of the pulse under attenuation
    float texture_db = -55;           ///< level of the speckle of liver relative to a perfect mirror
    float shadow_floor_db = -FLT_MAX; ///< lower bound on the level of speckle relative to the background alone
    std::uint32_t seed = 0x5EED;      ///< of the diffuse echoes of rough surfaces
    Roughness roughness{};            ///< of surfaces
    Attenuation attenuation{};        ///< dB per metre, there and back
    float min_ringing =
        0.5F; ///< thin hard layers ring on straight lines, such as a needle: their far surface repeats its echo
              ///< where each repetition has at least this fraction of the one before; 1: none rings

    /// The same model with another interface law.
    template <interface_law Law>
    physical<Law, Scattering, Specular, Roughness, Attenuation> with_boundary(const Law& law) const {
        return with(law, scattering, specular, roughness, attenuation);
    }
    /// The same model with another scatterer field.
    template <scattering_field Field>
    physical<Boundary, Field, Specular, Roughness, Attenuation> with_scattering(const Field& field) const {
        return with(boundary, field, specular, roughness, attenuation);
    }
    /// The same model with another specular law.
    template <specular_law Law>
    physical<Boundary, Scattering, Law, Roughness, Attenuation> with_specular(const Law& law) const {
        return with(boundary, scattering, law, roughness, attenuation);
    }
    /// The same model with another roughness law.
    template <roughness_law Law>
    physical<Boundary, Scattering, Specular, Law, Attenuation> with_roughness(const Law& law) const {
        return with(boundary, scattering, specular, law, attenuation);
    }
    /// The same model with another attenuation law.
    template <attenuation_law Law>
    physical<Boundary, Scattering, Specular, Roughness, Law> with_attenuation(const Law& law) const {
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
        return samples_for(depth, detail::nominal_sigma(frequency));
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
    /// The direction of sound behind an interface, by the interface law's own `refracted` or by Snell's law; {0, 0, 0} where
    /// it is totally reflected. Unchanged where all media have one speed (`timing::uniform`) or all incidence is normal.
    INSONIFY_FN vec3 refracted(vec3 direction, vec3 normal, const medium& before, const medium& after) const {
        if (timing == insonify::timing::uniform || angle == insonify::angle::normal) return direction;
        return detail::refracted_by(boundary, direction, normal, before, after);
    }
    /// Attenuation of an echo per metre of a medium, there and back, dB/m; the frequency is in hertz.
    INSONIFY_FN float loss(const medium& m, float frequency) const { return attenuation(m, frequency); }
    /// What the peak of the pulse of a line loses, dB. @param loss_db  what its carrier would lose alone
    INSONIFY_FN float pulse_loss(const traced_line& line, float loss_db) const {
        return detail::peak_loss(bandwidth, line, loss_db);
    }

    /// What arrives along a line, at equal steps of depth: x, the amplitude there and back, 1 at the probe face, and y, the
    /// displayed depth; element k at (k + 1) * spacing. From these, tracers compute `aperture_gains`.
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
        detail::layer_entry entry{};
        const auto add_surface = [&](std::size_t i, const layer& here, const echo_path& path) {
            const layer& above = line.layers[i - 1];
            const response met = add_interface(line, above, here, path, echoes, entry);
            entry = {met.reflected, path.shown, pulse_loss(line, path.loss_db), &line.layers[i],
                     &line.media[above.medium]};
            return met.transmitted;
        };
        detail::follow_sound(*this, line, add_surface, [&](std::size_t, const layer& here, const echo_path& path) {
            if (path.shown + path.gains.min_deeper() >= echoes.depth()) return false;
            detail::emit_speckle(*this, line, here, path, echoes);
            return true;
        });
    }

    /// Emits the speckle of a layer and advances `path` to its end.
    template <class Echoes>
    INSONIFY_FN void add_layer(const traced_line& line, const layer& here, echo_path& path,
                               const Echoes& echoes) const {
        detail::emit_speckle(*this, line, here, path, echoes);
        detail::pass(*this, line, here, path);
    }

    /// Emits the echoes of the surface between two layers, at the position of `path`; returns the response of the
    /// interface.
    /// @param entry  the surface at which the layer above began; by default the echo does not repeat
    template <class Echoes>
    INSONIFY_FN response add_interface(const traced_line& line, const layer& above, const layer& below,
                                       const echo_path& path, const Echoes& echoes,
                                       const detail::layer_entry& entry = {}) const {
        const medium &before = line.media[above.medium], &after = line.media[below.medium];
        const bool normal_incidence = angle == insonify::angle::normal;
        const float cosine = normal_incidence ? 1.0F : below.cosine;
        const vec2 tangent = normal_incidence ? vec2{0, 0} : below.slope;
        const incidence at{before, after, cosine, line.frequency, below.roughness};
        const response wave = at_interface(at);
        const float elevation_fnumber = line.aperture.elevation_fnumber;
        const float loss_db = pulse_loss(line, path.loss_db);
        const float arrived =
            line.gains.amplitude(path.passed * amplitude_of_decibels(-loss_db), path.gains.last().surfaces);
        const float shown = path.shown + path.gains.last().deeper;

        const float fnumber = line.aperture.fnumber(shown);
        const float wavelengths = max(shown, 1e-4F) * line.frequency / display_speed;
        constexpr float steepest = 5.8F; // 80 degrees
        const vec2 slope = detail::displayed_stretch(timing, before) *
                           vec2{clamp(tangent.x, -steepest, steepest), clamp(tangent.y, -steepest, steepest)};
        const auto collected_by = [&](vec2 of) -> vec2 {
            return {specular(std::atan(of.x), fnumber, wavelengths),
                    specular(std::atan(of.y), elevation_fnumber, wavelengths)};
        };
        const vec3 curvature = normal_incidence ? vec3{0, 0, 0} : below.curvature;
        curved_echo coherent{.depth = shown,
                             .amplitude = arrived * wave.reflected * roughness.coherent(at),
                             .collected = collected_by(tangent),
                             .slope = slope,
                             .curvature = detail::displayed_stretch(timing, before) * curvature};
        if (min_ringing < 1)
            detail::add_repetitions(coherent, entry, below, before, after, detail::displayed_stretch(timing, before),
                                    path.shown, loss_db, wave.reflected, min_ringing, collected_by,
                                    [&](const medium& from, const medium& to, float cosine_there) {
                                        return at_interface({from, to, cosine_there, line.frequency}).reflected;
                                    });
        add_specular(echoes, coherent);

        // Lambert's law over the solid angle of the array: 0.166 / (Fx Fy), calibrated by an independent simulation.
        const float scattered = wave.reflected * wave.reflected * roughness.diffuse(at);
        const float diffuse =
            std::fabs(arrived) * std::sqrt(scattered * 0.166F / (fnumber * elevation_fnumber)) * cosine;
        if (diffuse > 0) {
            const pose at_place = line.places.empty() ? pose{} : line.places[below.place];
            material_line inside = in_object(line.frame, at_place, below.object);
            inside.displacement = line.displacement(below.place);
            const gaussian_field field = surface_field();
            gaussian_field::surface_values values{field, inside, detail::surface_grain(line.frequency)};
            const float stretch = detail::displayed_stretch(timing, before);
            echoes.rough_surface(shown, diffuse, slope, coherent.curvature,
                                 [&](float x) { return values(below.begin + x / stretch); });
        }
        return wave;
    }

    friend bool operator==(const physical&, const physical&) = default;

  private:
    template <class A, class B, class C, class D, class E>
    physical<A, B, C, D, E> with(const A& a, const B& b, const C& c, const D& d, const E& e) const {
        return {a, b, c, timing, angle, bandwidth, texture_db, shadow_floor_db, seed, d, e, min_ringing};
    }

    // At normal incidence throughout, no surface turns from line to line.
    template <class Echoes>
    INSONIFY_FN void add_specular(const Echoes& echoes, const curved_echo& one) const {
        if constexpr (requires { echoes.curved_surface(one); })
            if (angle != insonify::angle::normal || one.repeat_ratio != 0) {
                if (one.amplitude != 0) echoes.curved_surface(one);
                return;
            }
        const float whole = one.amplitude * (one.collected.x * one.collected.y);
        if (whole != 0) echoes.surface(one.depth, whole, one.slope);
    }

    INSONIFY_FN gaussian_field surface_field() const { return {.seed = seed}; }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
