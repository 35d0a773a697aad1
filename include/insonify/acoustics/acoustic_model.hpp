#ifndef INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP
#define INSONIFY_ACOUSTICS_ACOUSTIC_MODEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/acoustics/medium.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Echoes of scatterers at equal steps of displayed depth. The level changes exponentially along the run, but grows by
/// 24 dB at most from one scatterer to the next.
struct scatterer_echoes {
    float depth = 0;                  ///< of the first echo, metres
    float step = 0;                   ///< metres, 0 or more
    std::uint32_t count = 0;          ///< number of scatterers
    const float* real = nullptr;      ///< real parts of the amplitudes
    const float* imaginary = nullptr; ///< imaginary parts
    float first_level = 0;            ///< factor on the amplitudes at the first scatterer ...
    float last_level = 0;             ///< ... and one step after its last scatterer
    vec2 slope{0, 0}; ///< change of displayed depth per metre across the line: in the slice plane, out of it
};

/// The specular echo of a plane or curved surface, with its repetitions where sound reverberates in a thin layer above
/// it.
struct curved_echo {
    float depth = 0;     ///< displayed, metres
    float amplitude = 0; ///< of the whole echo, before the aperture has its part
    vec2 collected{1,
                   1}; ///< fraction that the aperture collects of a plane of this slope: in the slice plane, out of it
    vec2 slope{0, 0};  ///< change of displayed depth per metre across the line, in the slice plane and out of it
    vec3 curvature{0, 0, 0}; ///< second derivatives of displayed depth, 1/m, as in `layer`
    float repeat_ratio = 0;  ///< of the amplitudes of each repetition and the echo before it; 0: not repeated
    float repeat_step = 0;   ///< from one to the next, metres of displayed depth

    /// Calls visit(deeper, factor) for the echo itself and for each repetition until they have fallen by 60 dB.
    /// @param range  metres of displayed depth after which they end
    template <class Visit>
    INSONIFY_FN void for_each_repetition(float range, const Visit& visit) const {
        constexpr std::uint32_t largest = 256;
        float factor = 1;
        for (std::uint32_t i = 0; i < largest && std::fabs(factor) > 1e-3F; ++i) {
            const float deeper = static_cast<float>(i) * repeat_step;
            if (i > 0 && !(deeper < range)) return;
            visit(deeper, factor);
            factor *= repeat_ratio;
        }
    }
};

/// Writes echoes into one line of complex samples at baseband.
///
///     s += a exp(-j 4 pi f0 z / c0)
///
/// for an echo of amplitude a at displayed depth z, in metres, f0 in hertz and c0 = `display_speed` in m/s; it is
/// divided linearly between the two neighbouring samples. Sample k lies at depth (k + 1/2) * spacing.
///
/// Models call `surface` or `curved_surface`, `rough_surface` and `scatterers`, and receive any type with these and
/// `depth`. The tracer substitutes one that compensates for the kernels of later stages.
/// Source: demodulation to baseband of an echo with delay 2 z / c0.
class echo_line {
  public:
    /// @param samples    to which echoes are added
    /// @param spacing    metres of displayed depth from sample to sample
    /// @param frequency  of the carrier, hertz
    INSONIFY_FN echo_line(view<vec2> samples, float spacing, float frequency)
        : samples_{samples}, per_spacing_{1 / spacing}, spacing_{spacing}, cycles_{2 * double{frequency} /
                                                                                   double{display_speed}} {}

    /// Metres to the end of the last sample.
    INSONIFY_FN float depth() const { return spacing_ * static_cast<float>(samples_.size()); }

    /// Adds one echo at a displayed depth, metres. Echoes beyond the ends of the line are dropped.
    INSONIFY_FN void add(float depth, vec2 amplitude) const {
        const vec2 value = detail::complex_product(amplitude, phase(depth));
        const float position = clamp(depth * per_spacing_ - 0.5F, -2.0F, static_cast<float>(samples_.size()) + 1.0F);
        const float below = std::floor(position), weight = position - below;
        add_pair(static_cast<std::uint32_t>(static_cast<std::int32_t>(below)), (1 - weight) * value, weight * value);
    }

    /// Adds the specular echo of a surface. The third argument is the change of its displayed depth per metre across
    /// the line, in the slice plane and out of it.
    INSONIFY_FN void surface(float depth, float amplitude, vec2 /* slope */) const { add(depth, {amplitude, 0}); }

    /// Adds the specular echo of a curved surface, as if it were plane, with its repetitions.
    INSONIFY_FN void curved_surface(const curved_echo& one) const {
        const float amplitude = one.amplitude * one.collected.x * one.collected.y;
        one.for_each_repetition(depth() - one.depth, [&](float deeper, float factor) {
            surface(one.depth + deeper, factor * amplitude, one.slope);
        });
    }

    /// Adds the diffuse echo of a rough surface: the same one, whatever its slope and its curvature (see `layer`).
    /// @param amplitude  rms
    /// @param value      vec2(float offset): the surface's random field, of power 1, `offset` metres deeper
    template <class Value>
    INSONIFY_FN void rough_surface(float depth, float amplitude, vec2 /* slope */, vec3 /* curvature */,
                                   const Value& value) const {
        add(depth, value(0.0F) * amplitude);
    }

    /// Adds the echoes of scatterers.
    INSONIFY_FN void scatterers(const scatterer_echoes& run) const {
        constexpr float min_level = 1e-15F, // -300 dB
            max_log_ratio = 4;              // 24 dB from one to the next: higher powers could overflow
        const float ratio =
            run.first_level > min_level && run.last_level > 0
                ? std::exp2(
                      min(std::log2(run.last_level / run.first_level) / static_cast<float>(run.count), max_log_ratio))
                : 1.0F;
        constexpr int width = max_simd_width;
        using floats = lanes<width>;
        // Of the first register, and the factor from each register to the next.
        float carrier[2][width];
        const vec2 first_carrier = run.first_level * phase(run.depth);
        carrier[0][0] = first_carrier.x;
        carrier[1][0] = first_carrier.y;
        vec2 factor = ratio * phase(run.step);
        for (int known = 1; known < width; known *= 2) {
            for (int i = 0; i < known; ++i) {
                const vec2 next = detail::complex_product({carrier[0][i], carrier[1][i]}, factor);
                carrier[0][known + i] = next.x;
                carrier[1][known + i] = next.y;
            }
            factor = detail::complex_product(factor, factor);
        }
        floats carrier_x = load<width>(carrier[0]), carrier_y = load<width>(carrier[1]);
        const auto last = static_cast<std::uint32_t>(samples_.size()) - 1;
        const floats factor_x(factor.x), factor_y(factor.y), one(1.0F);
        for (std::uint32_t first = 0; first < run.count; first += width) {
            const floats x = load_some(run.real + first, run.count - first),
                         y = load_some(run.imaginary + first, run.count - first);
            const floats value_x = x * carrier_x - y * carrier_y, value_y = x * carrier_y + y * carrier_x;
            const floats index = floats_of<width>(steps_of_bits<width>(first, 1));
            const floats position =
                (floats(run.depth) + index * floats(run.step)) * floats(per_spacing_) - floats(0.5F);
            const bit_lanes<width> below = floor_bits<width>(
                min(max(position, floats(-2.0F)), floats(static_cast<float>(samples_.size()) + 1.0F)));
            const floats weight = position - floats_of<width>(below);
            vec2 here[width], next[width];
            store_pairs((one - weight) * value_x, (one - weight) * value_y, here);
            store_pairs(weight * value_x, weight * value_y, next);
            std::uint32_t sample[width];
            store_bits<width>(below, sample);
            if (run.count - first >= width && sample[0] < last && sample[width - 1] < last)
                for (int i = 0; i < width; ++i) {
                    samples_[sample[i]] += here[i];
                    samples_[sample[i] + 1] += next[i];
                }
            else
                for (std::uint32_t i = 0; i < width && i < run.count - first; ++i)
                    add_pair(sample[i], here[i], next[i]);
            if (run.count - first <= width) return;
            const floats next_x = carrier_x * factor_x - carrier_y * factor_y;
            carrier_y = carrier_x * factor_y + carrier_y * factor_x;
            carrier_x = next_x;
        }
    }

  private:
    INSONIFY_FN vec2 phase(float depth) const {
        const vec2 forwards = detail::turned(cycles_ * static_cast<double>(depth));
        return {forwards.x, -forwards.y};
    }

    // Loads `count` floats, at most a register; the other lanes are 0.
    INSONIFY_FN INSONIFY_INLINE static lanes<max_simd_width> load_some(const float* from, std::uint32_t count) {
        if (count >= max_simd_width) return load<max_simd_width>(from);
        float some[max_simd_width] = {};
        for (std::uint32_t i = 0; i < count; ++i) some[i] = from[i];
        return load<max_simd_width>(some);
    }

    template <class Lanes>
    INSONIFY_FN INSONIFY_INLINE static void store_pairs(const Lanes& x, const Lanes& y, vec2* to) {
        float apart[2][max_simd_width];
        store(x, apart[0]);
        store(y, apart[1]);
        for (int i = 0; i < max_simd_width; ++i) to[i] = {apart[0][i], apart[1][i]};
    }

    // Adds to a sample and the next one; an index below 0 wraps around.
    INSONIFY_FN void add_pair(std::uint32_t sample, vec2 here, vec2 next) const {
        const auto end = static_cast<std::uint32_t>(samples_.size());
        if (sample < end) samples_[sample] += here;
        if (sample + 1 < end) samples_[sample + 1] += next;
    }

    view<vec2> samples_;
    float per_spacing_, spacing_;
    double cycles_; // of the carrier per metre of displayed depth
};

/// Computes the samples of a line from its layers, as `physical` and `law2011` do. A model needs three members:
///
///     using sample_type = float;                                  // of one sample
///     std::uint32_t samples(float depth, float frequency) const;  // default number of samples
///     void operator()(const auto& policy, const traced_line& line, float spacing, view<sample_type> samples) const;
///
/// The last writes the samples of one line, which start at 0; sample k lies at depth (k + 1/2) * spacing metres. It
/// must not throw. All other members are optional, and each has a concept: `follows_lines_deeper`, `emits_echoes`,
/// `states_covariance`, `states_surface_covariance`, `states_arrivals`. A tracer refuses to compile a model that has a
/// member of such a name with another signature. Beside them,
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

/// A model that makes complex echoes for `convolve`. It emits them to an `echo_line`, or to another sink with its
/// members, which compensates their levels for what follows, or distributes them over the pulses of a train:
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

/// A model whose shadows have a penumbra: it states what arrives along a line, and applies `traced_line::gains`, which
/// are computed from that. See `physical::arrivals`.
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

template <class Model>
concept takes_normal_incidence = requires {
    requires Model::normal_incidence;
};

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
