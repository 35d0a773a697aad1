#ifndef INSONIFY_ACOUSTICS_LAW2011_HPP
#define INSONIFY_ACOUSTICS_LAW2011_HPP

#include <insonify/acoustics/layer.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd_math.hpp>
#include <concepts>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// Over which path attenuation acts. With the paper's 20 log10, `two_way` is what an echo's amplitude suffers.
enum class travel { one_way, two_way };

/// Whether the reflected term of eq. 1 is weakened by the attenuation of the path to it. As printed it is not.
enum class reflection { bare, attenuated };

/// On which side of an interface its bright band lies: towards the probe, as in the paper, or beyond, as an echo does.
enum class band { before, after };

/// How attenuation grows with frequency: f, as eq. 4, or f^attenuation_power of each medium.
enum class spectrum { linear, power_law };

/// What I_a I_t of eq. 1 is: the field itself, as printed, or what the medium's texture sends back of it.
enum class incident { field, backscattered };

/// The acoustic model of the paper that this library started from: intensities along a beam, eqs. 1 to 6.
///
///     I(z)   = I_a I_t + I_r                                                                          (1)
///     R      = ((Z2 - Z1) / (Z2 + Z1))^2,   I_r = R I_t  within `reflection_length` of an interface      (2)
///     I_t    = product of 4 Z1 Z2 / (Z1 + Z2)^2 over the interfaces above z                           (3)
///     I_a    = 10^(-sum of alpha d f / 20) over the media above z                                     (6)
///
/// Eq. 3 is corrected: as printed, (4 Z1 Z2 / (Z1 + Z2))^2 depends on the unit of impedance. All else is literal by
/// default, each departure from it an option. Incidence is taken as normal, and a bright band ends where another
/// interface cuts it.
/// Source: "Ultrasound image simulation with GPU-based ray tracing", 2011; impedances in rayl.
struct law2011 {
    using sample_type = float;                     ///< an intensity
    static constexpr bool normal_incidence = true; ///< angles are not looked at
    static constexpr float nanoseconds = 0.5F;     ///< that a sample takes, about

    float reflection_length = 1e-3F;                              ///< metres
    insonify::travel travel = insonify::travel::one_way;          ///< of attenuation
    insonify::reflection reflection = insonify::reflection::bare; ///< I_r, attenuated or not
    insonify::band band = insonify::band::before;                 ///< side of the bright bands
    insonify::spectrum spectrum = insonify::spectrum::linear;     ///< of attenuation
    insonify::incident incident = insonify::incident::field;      ///< what I_a I_t is
    float texture = 1.78e-3F; ///< with `backscattered`: the echo of liver against a perfect mirror's (-55 dB)

    /// Share of the intensity that an interface sends back, eq. 2.
    INSONIFY_FN static float reflected(const medium& before, const medium& after) {
        const float z1 = before.impedance(), z2 = after.impedance();
        const float r = (z2 - z1) * (1 / (z1 + z2));
        return r * r;
    }

    /// Share of the intensity that goes on, eq. 3 corrected; with `reflected` it sums to 1.
    INSONIFY_FN static float transmitted(const medium& before, const medium& after) {
        const float z1 = before.impedance(), z2 = after.impedance();
        const float share = 1 / (z1 + z2);
        return 4 * (z1 * share) * (z2 * share);
    }

    /// What sound loses on each metre of depth: dB/m at a frequency in hertz, one way or two as `travel` says.
    INSONIFY_FN float loss(const medium& m, float frequency) const {
        const float megahertz = frequency * 1e-6F;
        const float growth =
            spectrum == insonify::spectrum::linear ? megahertz : std::pow(megahertz, m.attenuation_power);
        const float both_ways = travel == insonify::travel::two_way ? 2.0F : 1.0F;
        constexpr float all = 1e30F; // nothing is left after any distance, and sums of it stay finite
        return lesser(m.attenuation * lesser(both_ways * growth, all), all);
    }

    /// Samples of a line where the caller leaves it open: four a wavelength of 1540 m/s, a multiple of 64.
    INSONIFY_FN std::uint32_t samples(float depth, float frequency) const {
        const float blocks = std::ceil(4 * depth * frequency / 1540 / 64);
        return 64 * static_cast<std::uint32_t>(clamped(blocks, 1, 1024));
    }

    /// The bright band of an interface below the last sample may reach up to it.
    INSONIFY_FN float reach(float depth, view<const medium>) const { return depth + reflection_length; }

    /// The intensity at one depth of a line, metres: eq. 1, term by term.
    INSONIFY_FN float at(const traced_line& line, float depth) const {
        float lost = 0; // dB
        float transmitted_here = 1;
        interface_echo above{};
        for (std::size_t i = 0;;) {
            const std::size_t next = i + same_medium(line, i);
            const medium& m = line.media[line.layers[i].medium];
            const float begin = line.layers[i].begin, end = line.layers[next - 1].end;
            const interface_echo below = next_interface(line, next, transmitted_here);
            if (depth < end || next == line.layers.size()) {
                lost += loss(m, line.frequency) * (depth - begin);
                const float remaining = decay(lost);
                const interface_echo& echo = band == insonify::band::before ? below : above;
                const bool bright = std::fabs(echo.depth - depth) <= reflection_length;
                const float weakened = reflection == insonify::reflection::attenuated ? remaining : 1.0F;
                return remaining * transmitted_here * strength(m) + (bright ? echo.intensity * weakened : 0.0F);
            }
            lost += loss(m, line.frequency) * (end - begin);
            transmitted_here *= transmitted(m, line.media[line.layers[next].medium]);
            above = below;
            i = next;
        }
    }

    /// Writes the intensity at each sample of a line: sample k stands at depth (k + 1/2) * spacing metres.
    ///
    /// @tparam Policy  one that asks for SIMD gets it along the line; equal within rounding
    template <class Policy>
    INSONIFY_FN void operator()(const Policy&, const traced_line& line, float spacing, view<float> out) const {
        float loss_above = 0;       // dB, of the layers above
        float transmitted_here = 1; // I_t
        interface_echo above{};
        const auto most = static_cast<float>(out.size());
        const auto samples_before = [&](float depth) { return clamped(std::ceil(depth / spacing - 0.5F), 0, most); };
        float next_sample = 0;
        for (std::size_t i = 0, next = 0; i < line.layers.size(); i = next) {
            next = i + same_medium(line, i);
            const medium& m = line.media[line.layers[i].medium];
            const float begin = line.layers[i].begin, end = line.layers[next - 1].end;
            const float slope = loss(m, line.frequency);
            const interface_echo below = next_interface(line, next, transmitted_here);
            const stretch field{.first = bits_per_db * (loss_above - slope * begin),
                                .step = bits_per_db * slope * spacing,
                                .strength = transmitted_here * strength(m)};
            const float last_sample = greater(next_sample, samples_before(end));
            if (band == insonify::band::before) {
                const float bright = clamped(samples_before(below.depth - reflection_length), next_sample, last_sample);
                fill<Policy>(out, next_sample, bright, field, 0);
                fill<Policy>(out, bright, last_sample, field, below.intensity);
            } else {
                const float bright = clamped(samples_before(above.depth + reflection_length), next_sample, last_sample);
                fill<Policy>(out, next_sample, bright, field, above.intensity);
                fill<Policy>(out, bright, last_sample, field, 0);
            }
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

    // I_a I_t within one layer: of sample k strength * 2^(first + step (k + 1/2)).
    struct stretch {
        float first = 0, step = 0;
        float strength = 1;
    };

    static constexpr float bits_per_db = -0.166096404744F; // 10^(-x/20) = 2^(-x log2(10)/20)
    INSONIFY_FN static float decay(float decibels) { return std::exp2(bits_per_db * decibels); }

    // How many layers from this one on have its medium: objects may touch, an interface is where the medium changes.
    INSONIFY_FN static std::size_t same_medium(const traced_line& line, std::size_t first) {
        std::size_t next = first + 1;
        while (next < line.layers.size() && line.layers[next].medium == line.layers[first].medium) ++next;
        return next - first;
    }

    // The echo of the interface at which layer `after` begins; none where the line ends before it.
    INSONIFY_FN static interface_echo next_interface(const traced_line& line, std::size_t after, float intensity) {
        if (after == line.layers.size()) return {FLT_MAX, 0};
        const medium &above = line.media[line.layers[after - 1].medium], &below = line.media[line.layers[after].medium];
        return {line.layers[after].begin, intensity * reflected(above, below)};
    }

    INSONIFY_FN float strength(const medium& m) const {
        return incident == insonify::incident::backscattered ? texture * m.backscatter : 1.0F;
    }

    // Fills the samples from `begin` on that stand before `end`, whole numbers.
    template <class Policy>
    INSONIFY_FN void fill(view<float> out, float begin, float end, const stretch& field, float echo) const {
        if (begin >= end) return;
        const float weakened = reflection == insonify::reflection::attenuated ? echo : 0.0F;
        const float bare = echo - weakened, scale = field.strength + weakened;
        auto next = static_cast<std::size_t>(begin);
        const auto last = static_cast<std::size_t>(end);
#if !defined(INSONIFY_NO_SIMD)
        if constexpr (exec::is_unsequenced_v<Policy>) {
            constexpr int width = simd_width;
            using floats = lanes<width>;
            const floats ratio(last - next > width ? std::exp2(field.step * width) : 0.0F);
            floats place = floats([](auto lane) { return static_cast<float>(lane) + 0.5F; }) + floats(begin);
            // The last ones may run over the end of the stretch: the next one writes there. Powers are taken at one of
            // four; from each to the next the ratio is the same.
            while (next < last && next + width <= out.size()) {
                floats decayed = power_of_two<width>(place * floats(field.step) + floats(field.first));
                for (int i = 0; i < 4 && next < last && next + width <= out.size(); ++i, next += width) {
                    store(multiply_add(floats(scale), decayed, floats(bare)), out.data() + next);
                    decayed = decayed * ratio;
                }
                place = place + floats(4 * width);
            }
        }
#endif
        for (; next < last; ++next)
            out[next] = scale * std::exp2((static_cast<float>(next) + 0.5F) * field.step + field.first) + bare;
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
