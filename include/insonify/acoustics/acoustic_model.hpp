#ifndef INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP
#define INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_line.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/execution/policy.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Computes the samples of a line from its layers, as `physical` and `law2011` do. A model needs three members:
///
///     using sample_type = float;                                  // of one sample
///     std::uint32_t samples(float depth, float frequency) const;  // default number of samples
///     void operator()(const auto& policy, const traced_line& line, float spacing, view<sample_type> samples) const;
///
/// The last writes the samples of one line, which start at 0; sample k lies at depth (k + 1/2) * spacing metres. It
/// must not throw. All other members are optional, and each has a concept: `follows_lines_deeper`, `emits_echoes`,
/// `states_covariance`, `states_surface_covariance`, `states_arrivals`. A tracer refuses to compile a model that has a member of
/// such a name with another signature. Beside them,
///
///     static constexpr bool normal_incidence = true;    // angles (`layer::cosine`, `layer::slope`) are not computed
///     static constexpr bool independent_planes = true;  // speckle is independent from elevation plane to plane
///     static constexpr float nanoseconds = 0.5F;        // per sample, if far from 5: short frames are not divided among threads
///     void check() const;                               // throws `usage_error` for settings out of range
template <class Model>
concept acoustic_model = requires(const Model& model, const traced_line& line, view<typename Model::sample_type> out) {
    { model.samples(0.1F, 5e6F) } -> std::convertible_to<std::uint32_t>;
    model(exec::seq, line, 1e-3F, out);
};

/// A model whose samples depend on what lies beyond their depth: it states the length of the line to trace, metres.
template <class Model>
concept follows_lines_deeper = requires(const Model& model, view<const medium> media) {
    { model.max_depth(0.1F, media) } -> std::convertible_to<float>;
};

/// A model that makes complex echoes for `convolve`. It emits them to an `echo_line`, or to another sink with its members, which
/// compensates their levels for what follows, or distributes them over the pulses of a train:
///
///     template <class Echoes> void emit(const traced_line& line, const Echoes& echoes) const;
template <class Model>
concept emits_echoes = requires(const Model& model, const traced_line& line, const echo_line& echoes) {
    model.emit(line, echoes);
};

/// A model that states the covariance of its speckle on two lines: 1 at distance 0, metres, at an angle in radians.
template <class Model>
concept states_covariance = requires(const Model& model) {
    { model.covariance(1e-3F, 0.1F) } -> std::convertible_to<float>;
};

/// The same for the echoes of rough surfaces, where it differs.
template <class Model>
concept states_surface_covariance = requires(const Model& model) {
    { model.surface_covariance(1e-3F, 0.1F) } -> std::convertible_to<float>;
};

/// A model whose shadows have a penumbra: it states what arrives along a line, and applies `traced_line::gains`, which are
/// computed from that. See `physical::arrivals`.
///
///     void arrivals(const traced_line& line, float spacing, view<vec2> out) const;
template <class Model>
concept states_arrivals = requires(const Model& model, const traced_line& line, view<vec2> out) {
    model.arrivals(line, 1e-3F, out);
};

namespace detail {

/// Finds members that were meant to be optional ones of an `acoustic_model`, and are not.
template <acoustic_model Model>
struct model_check {
    static_assert(
        !requires { &Model::max_depth; } || follows_lines_deeper<Model>,
        "acoustic model: `max_depth` must be float max_depth(float depth, view<const medium> media) const");
    static_assert(
        !requires { &Model::covariance; } || states_covariance<Model>,
        "acoustic model: `covariance` must be float covariance(float distance, float angle) const");
    static_assert(
        !requires { &Model::surface_covariance; } || states_surface_covariance<Model>,
        "acoustic model: `surface_covariance` must be float surface_covariance(float distance, float angle) const");
    static_assert(
        !requires { &Model::arrivals; } || states_arrivals<Model>,
        "acoustic model: `arrivals` must be void arrivals(const traced_line&, float spacing, view<vec2> out) const");
    static_assert(emits_echoes<Model> || !states_covariance<Model>,
                  "acoustic model: `covariance` has an effect on models with `emit` only: is it misspelt?");
    static_assert(
        !emits_echoes<Model> || states_covariance<Model>,
        "acoustic model: a model with `emit` needs `covariance`, by which its levels are kept: is it misspelt?");
    static_assert(
        !emits_echoes<Model> || states_arrivals<Model> || requires { Model::sharp_shadows; },
        "acoustic model: a model with `emit` needs `arrivals`, from which its shadows have a penumbra: is it "
        "misspelt? If shadows are to be sharp, add static constexpr bool sharp_shadows = true");
    static constexpr bool passed = true;
};

/// Length of the line to trace for samples down to `depth`, metres.
template <acoustic_model Model>
float max_depth_of(const Model& model, float depth, view<const medium> media) {
    if constexpr (follows_lines_deeper<Model>)
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
