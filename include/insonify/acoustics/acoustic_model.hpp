#ifndef INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP
#define INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP

#include <insonify/acoustics/layer.hpp>
#include <insonify/execution/for_each.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// What turns a line into samples. `law2011` is one; write your own with these three:
///
///     using sample_type = float;                                  // what a sample holds
///     std::uint32_t samples(float depth, float frequency) const;  // how many, where the caller does not say
///     void operator()(const auto& policy, const traced_line& line, float spacing, view<sample_type> samples) const;
///
/// The last makes every sample of one line, which all start at 0; sample k stands at depth (k + 1/2) * spacing metres. It
/// must not throw.
/// A model whose samples depend on what lies beyond their depth has a fourth, how far lines are to be followed (metres):
///
///     float reach(float depth, view<const medium> media) const;
///
/// and one that wants to know the beam (`traced_line::beam`) a fifth, how alike its independent echoes are on two lines
/// that lie so many metres apart and differ in direction by so many radians, 1 to 0:
///
///     float covariance(float apart, float turned) const;
///
/// One that takes all incidence as normal may say so; then the angles of its layers (`cosine`, `tilt`) are not looked up:
///
///     static constexpr bool normal_incidence = true;
///
/// One whose samples take much less, or more, than 5 nanoseconds may say so; frames that are soon done stay on one thread:
///
///     static constexpr float nanoseconds = 0.5F;
template <class Model>
concept acoustic_model = requires(const Model& model, const traced_line& line, view<typename Model::sample_type> out) {
    { model.samples(0.1F, 5e6F) } -> std::convertible_to<std::uint32_t>;
    model(exec::seq, line, 1e-3F, out);
};

/// How far a line is followed for samples down to `depth`, metres.
template <acoustic_model Model>
float reach_of(const Model& model, float depth, view<const medium> media) {
    if constexpr (requires { model.reach(depth, media); })
        return model.reach(depth, media);
    else
        return depth;
}

/// Whether a model says that it takes all incidence as normal.
template <acoustic_model Model>
constexpr bool takes_normal_incidence() {
    if constexpr (requires { Model::normal_incidence; })
        return Model::normal_incidence;
    else
        return false;
}

/// About what a sample of a model takes.
template <acoustic_model Model>
constexpr float nanoseconds_of() {
    if constexpr (requires { Model::nanoseconds; })
        return Model::nanoseconds;
    else
        return 5;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
