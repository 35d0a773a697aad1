#ifndef INSONIFY_PAPER_LAW2011_HPP
#define INSONIFY_PAPER_LAW2011_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The acoustic model of Law et al. 2011: intensities along a beam, eqs. 1 to 6.
///
///     I(z)   = I_a I_t + I_r                                                                          (1)
///     R      = ((Z2 - Z1) / (Z2 + Z1))^2,   I_r = R I_t  within `reflection_length` of an interface      (2)
///     I_t    = product of 4 Z1 Z2 / (Z1 + Z2)^2 over the interfaces above z                           (3)
///     I_a    = 10^(-sum of alpha d f / 20) over the media above z                                     (6)
///
/// z and d are depth and path length in a medium, in m; Z is impedance in rayl, alpha attenuation in dB/m at 1 MHz, f
/// frequency in MHz. I is relative to the emitted intensity.
///
/// Eq. 3 is corrected: as printed, (4 Z1 Z2 / (Z1 + Z2))^2, it depends on the unit of impedance. Everything else
/// follows the paper by default; each departure is an option. Incidence is assumed normal, and a bright band ends at
/// the next interface.
/// Source: Law et al., "Ultrasound image simulation with GPU-based ray tracing", 2011.
struct law2011 {
    using sample_type = float;                     ///< relative intensity
    static constexpr bool normal_incidence = true; ///< angles are not computed
    static constexpr float nanoseconds = 0.5F;     ///< per sample

    /// Path of attenuation. With the paper's 20 log10, `two_way` is the loss of an echo's amplitude.
    enum class travel { one_way, two_way };
    /// Whether I_r of eq. 1 is attenuated on the path to the interface. As printed, it is not.
    enum class reflection { bare, attenuated };
    /// Side of an interface on which its bright band lies: towards the probe, as in the paper, or beyond, as of echoes.
    enum class band { before, after };
    /// Growth of attenuation with frequency: as f, as in eq. 4, or as f^attenuation_power of each medium.
    enum class spectrum { linear, power_law };
    /// Meaning of I_a I_t in eq. 1: the incident field, as printed, or its backscatter by the medium.
    enum class incident { field, backscattered };

    float reflection_length = 1e-3F;               ///< metres
    enum travel travel = travel::one_way;          ///< of attenuation
    enum reflection reflection = reflection::bare; ///< attenuation of I_r
    enum band band = band::before;                 ///< side of the bright band
    enum spectrum spectrum = spectrum::linear;     ///< of attenuation
    enum incident incident = incident::field;      ///< meaning of I_a I_t
    float texture = 1.78e-3F; ///< with `backscattered`: level of the speckle of liver; 1.78e-3 is -55 dB

    /// R: fraction of the intensity that an interface reflects, eq. 2.
    INSONIFY_FN static float reflected(const medium& before, const medium& after) {
        const float z1 = before.impedance(), z2 = after.impedance();
        const float r = (z2 - z1) * (1 / (z1 + z2));
        return r * r;
    }

    /// Fraction of the intensity that an interface transmits, 1 - R: eq. 3, corrected.
    INSONIFY_FN static float transmitted(const medium& before, const medium& after) {
        const float z1 = before.impedance(), z2 = after.impedance();
        const float inverse_sum = 1 / (z1 + z2);
        return 4 * (z1 * inverse_sum) * (z2 * inverse_sum);
    }

    /// Attenuation per metre of depth, dB/m, at a frequency in hertz; one way or two, depending on `travel`.
    INSONIFY_FN float loss(const medium& m, float frequency) const {
        const float megahertz = frequency * 1e-6F;
        const float growth = spectrum == spectrum::linear ? megahertz : std::pow(megahertz, m.attenuation_power);
        const float ways = travel == travel::two_way ? 2.0F : 1.0F;
        constexpr float max_loss = 1e30F; // keeps sums finite
        return min(m.attenuation * min(ways * growth, max_loss), max_loss);
    }

    /// Default number of samples of a line: four per wavelength at 1540 m/s, rounded up to a multiple of 64.
    INSONIFY_FN std::uint32_t samples(float depth, float frequency) const {
        const float blocks = std::ceil(4 * depth * frequency / 1540 / 64);
        return 64 * static_cast<std::uint32_t>(clamp(blocks, 1, 1024));
    }

    /// The bright band of an interface below the last sample may extend up to it.
    INSONIFY_FN float max_depth(float depth, view<const medium>) const { return depth + reflection_length; }

    /// Reflected and transmitted fractions of the intensity, for `ground_truth`.
    INSONIFY_FN response at_interface(const incidence& at) const {
        return {.reflected = reflected(at.before, at.after), .transmitted = transmitted(at.before, at.after)};
    }

    /// The intensity at one depth of a line, metres: eq. 1.
    INSONIFY_FN float at(const traced_line& line, float depth) const {
        float intensity = 0;
        (*this)(exec::sequenced_policy{}, line, 2 * max(depth, 1e-9F), {&intensity, 1}); // the middle of one sample
        return intensity;
    }

    /// Writes the intensity at each sample of a line; sample k lies at depth (k + 1/2) * spacing metres.
    /// @tparam Policy  unsequenced policies use SIMD along the line; results agree within rounding
    template <class Policy>
    INSONIFY_FN void operator()(const Policy&, const traced_line& line, float spacing, view<float> out) const {
        float loss_above = 0;       // of the layers above, dB
        float transmitted_here = 1; // I_t
        interface_echo above{};
        const auto count = static_cast<float>(out.size());
        const auto samples_before = [&](float depth) { return clamp(std::ceil(depth / spacing - 0.5F), 0, count); };
        float next_sample = 0;
        for (std::size_t i = 0, next = 0; i < line.layers.size(); i = next) {
            const std::uint32_t number = line.layers[i].medium; // layers of one medium have no interface between them
            while (next < line.layers.size() && line.layers[next].medium == number) ++next;
            const medium& m = line.media[number];
            const float begin = line.layers[i].begin, end = line.layers[next - 1].end;
            const float slope = loss(m, line.frequency);
            const float scattered = incident == incident::backscattered ? texture * m.backscatter : 1;
            const interface_echo below = next_interface(line, next, transmitted_here);
            const decay_segment field{.first = bits_per_db * (loss_above - slope * begin),
                                      .step = bits_per_db * slope * spacing,
                                      .strength = transmitted_here * scattered};
            const float last_sample = max(next_sample, samples_before(end));
            const bool before = band == band::before;
            const float end_of_band = before ? below.depth - reflection_length : above.depth + reflection_length;
            const float border = clamp(samples_before(end_of_band), next_sample, last_sample);
            fill<Policy>(out, next_sample, border, field, before ? 0 : above.intensity);
            fill<Policy>(out, border, last_sample, field, before ? below.intensity : 0);
            next_sample = last_sample;
            if (next == line.layers.size()) break;
            loss_above += slope * (end - begin);
            transmitted_here *= transmitted(m, line.media[line.layers[next].medium]);
            above = below;
        }
    }

  private:
    struct interface_echo {
        float depth = -FLT_MAX;
        float intensity = 0; // R I_t
    };

    // I_a I_t in one layer: strength * 2^(first + step (k + 1/2)) at sample k.
    struct decay_segment {
        float first = 0, step = 0;
        float strength = 1;
    };

    static constexpr float bits_per_db = -0.166096404744F; // 10^(-x/20) = 2^(-x log2(10)/20)

    // The echo of the interface at the beginning of layer `after`; none at the end of the line.
    INSONIFY_FN static interface_echo next_interface(const traced_line& line, std::size_t after, float intensity) {
        if (after == line.layers.size()) return {FLT_MAX, 0};
        const medium &above = line.media[line.layers[after - 1].medium], &below = line.media[line.layers[after].medium];
        return {line.layers[after].begin, intensity * reflected(above, below)};
    }

    // Fills the samples from `begin` to before `end`, both whole numbers.
    template <class Policy>
    INSONIFY_FN void fill(view<float> out, float begin, float end, const decay_segment& field, float echo) const {
        if (begin >= end) return;
        const float attenuated = reflection == reflection::attenuated ? echo : 0.0F;
        const float bare = echo - attenuated, scale = field.strength + attenuated;
        auto next = static_cast<std::size_t>(begin);
        const auto last = static_cast<std::size_t>(end);
#if !defined(INSONIFY_NO_SIMD)
        if constexpr (exec::is_unsequenced_v<Policy>) {
            constexpr int width = max_simd_width;
            using floats = lanes<width>;
            const floats ratio(last - next > width ? std::exp2(field.step * width) : 0.0F);
            floats position =
                each_lane<width>([](int lane) { return static_cast<float>(lane) + 0.5F; }) + floats(begin);
            // May overrun the end of the segment, where the next one writes. Powers are computed for every sixteenth
            // vector; the ratio between consecutive vectors is constant, and rounding adds up to 2e-6.
            constexpr int vectors = 16;
            while (next < last && next + width <= out.size()) {
                floats decayed = power_of_two<width>(position * floats(field.step) + floats(field.first));
                for (int i = 0; i < vectors && next < last && next + width <= out.size(); ++i, next += width) {
                    store(multiply_add(floats(scale), decayed, floats(bare)), out.data() + next);
                    decayed = decayed * ratio;
                }
                position = position + floats(vectors * width);
            }
        }
#endif
        for (; next < last; ++next)
            out[next] = scale * std::exp2((static_cast<float>(next) + 0.5F) * field.step + field.first) + bare;
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
