#ifndef INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP
#define INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/execution/for_each.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Computes the samples of a line from its layers, as `physical` and `law2011` do. A model needs three members:
///
///     using sample_type = float;                                  // of one sample
///     std::uint32_t samples(float depth, float frequency) const;  // default number of samples
///     void operator()(const auto& policy, const traced_line& line, float spacing, view<sample_type> samples) const;
///
/// The last writes the samples of one line, which start at 0; sample k lies at depth (k + 1/2) * spacing metres. It
/// must not throw. All other members are optional. If samples depend on what lies beyond `depth`, the length of the
/// line to trace, in metres:
///
///     float max_depth(float depth, view<const medium> media) const;
///
/// For complex echoes that `convolve` follows, a model may emit them to an `echo_line` instead of writing samples; the
/// tracer then compensates their levels for the kernels. Such a model also gives the covariance of its random
/// echoes on two lines, 1 at distance 0, by their distance in metres and the angle between them in radians. It may also give
/// that of rough surfaces, if it differs, and state that speckle is independent from elevation plane to plane:
///
///     template <class Echoes> void emit(const traced_line& line, const Echoes& echoes) const;
///     float covariance(float distance, float angle) const;
///     float surface_covariance(float distance, float angle) const;
///     static constexpr bool independent_planes = true;
///
/// For a model whose shadows are to have a penumbra, what arrives along a line; it then applies `traced_line::gains`, which
/// the tracer computes from that. See `physical::arrivals`:
///
///     void arrivals(const traced_line& line, float spacing, view<vec2> out) const;
///
/// For a model that assumes normal incidence, angles (`layer::cosine`, `layer::slope`) are not computed:
///
///     static constexpr bool normal_incidence = true;
///
/// Nanoseconds per sample, if far from 5; short frames are not divided among threads:
///
///     static constexpr float nanoseconds = 0.5F;
template <class Model>
concept acoustic_model = requires(const Model& model, const traced_line& line, view<typename Model::sample_type> out) {
    { model.samples(0.1F, 5e6F) } -> std::convertible_to<std::uint32_t>;
    model(exec::seq, line, 1e-3F, out);
};

namespace detail {

/// Length of the line to trace for samples down to `depth`, metres.
template <acoustic_model Model>
float max_depth_of(const Model& model, float depth, view<const medium> media) {
    if constexpr (requires { model.max_depth(depth, media); })
        return model.max_depth(depth, media);
    else
        return depth;
}

/// True for models that assume normal incidence.
template <acoustic_model Model>
INSONIFY_FN constexpr bool takes_normal_incidence() {
    if constexpr (requires { Model::normal_incidence; })
        return Model::normal_incidence;
    else
        return false;
}

/// Nanoseconds per sample.
template <acoustic_model Model>
constexpr float nanoseconds_of() {
    if constexpr (requires { Model::nanoseconds; })
        return Model::nanoseconds;
    else
        return 5;
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
