#ifndef INSONIFY_TRACING_PATHS_HPP
#define INSONIFY_TRACING_PATHS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/tracing/paths/path_follower.hpp>
#include <insonify/tracing/trace.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Refraction and multiple reflection: a `tracer` for `trace` and `b_mode`.
///
///     b_mode(exec::par_unseq, body, probe, at, physical{}, {.depth = 40_mm}, paths{});
///
/// Sound goes out along a path and returns along the same one, so each surface on the way adds its echo, weakened
/// by all that the path crosses twice. A plate thus gives the ladder of its reverberations, a mirror the image
/// behind it, and a tilted layer displaces what lies below. Where two paths meet a surface at one point from one
/// direction, sound also goes out along one and returns along the other: plane layers thus give all of their
/// echoes, as the sum over every sequence of reflections does, above `min_amplitude`. Directions follow the model's
/// own interface law where it gives one, else Snell's. The face of the probe is an infinite plane, where paths end.
/// Curved mirrors spread or focus the sound, curved surfaces that refract it do not. Speckle is that of sound which
/// returns as it went out.
struct paths {
    path_settings settings{}; ///< how far they are followed

    /// @throws usage_error  for settings out of range
    void check() const {
        if (!(settings.min_amplitude > 0) || !(std::fabs(settings.face_reflection) <= 1))
            throw usage_error{"paths: `min_amplitude` must be above 0, `face_reflection` from -1 to 1"};
    }

    /// Traces one line: see `tracer`.
    template <class Policy, detail::path_model Model>
    INSONIFY_FN bool operator()(const Policy&, const line_task& task, const Model& model, line_scratch& scratch,
                                view<vec2> out) const {
        return detail::path_follower<Model>{task, model, settings, scratch, out}.run();
    }

    friend bool operator==(const paths&, const paths&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
