#ifndef INSONIFY_ACOUSTICS_SHEATH_GAINS_HPP
#define INSONIFY_ACOUSTICS_SHEATH_GAINS_HPP

#include <insonify/acoustics/structure_gains.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Factors on the amplitude of speckle in the sheath of an object: see `structure::sheath_layer`.
class sheath_gains {
  public:
    /// @param origin, along  of a segment of a line: metres, and metres of material per metre of the line
    /// @param fnumber        of the receiving aperture
    /// @param key            of the object
    INSONIFY_FN sheath_gains(const structure::sheath_layer& of, vec3 origin, vec3 along, float fnumber,
                             std::uint32_t key)
        : of_{of}, origin_{origin}, along_{along}, key_{key}, lobe_{lobe_of(of.waviness, fnumber)} {}

    /// Multiplies complex amplitudes at equal steps from a distance on; metres from the origin of the segment. The arrays have
    /// room for whole registers.
    /// @param surface  distance of the surface, metres from the same origin
    /// @param cosine   of the angle of incidence on it; negative where the line leaves the object
    INSONIFY_FN void apply(float first, float step, std::uint32_t count, float surface, float cosine, float* real,
                           float* imaginary) const {
        const float sine_squared = 1 - min(cosine * cosine, 1), diffuse = amplitude_of_decibels(of_.diffuse_db);
        const float echo = diffuse + (1 - diffuse) * std::exp2(-sine_squared / (lobe_ * lobe_));
        const float deepest = 2 * of_.thickness;
        for (std::uint32_t i = 0; i < count; i += simd_width) {
            const float depth_first = (first + static_cast<float>(i) * step - surface) * cosine;
            const float depth_last = depth_first + simd_width * step * cosine;
            if (min(depth_first, depth_last) > deepest || max(depth_first, depth_last) < 0) continue;
            const floats distance =
                floats(first) + floats_of<simd_width>(steps_of_bits<simd_width>(i, 1)) * floats(step);
            const floats depth = (distance - floats(surface)) * floats(cosine);
            // In units of the thickness, which varies by 20 %.
            const floats varied = power_of_two<simd_width>(noise(6e-3F, 1, distance) * floats(0.3F));
            const floats within = depth / (varied * floats(of_.thickness));
            const float width = min(0.12e-3F / of_.thickness, 0.25F); // of a line, standard deviation
            const auto line = [&](float place) {
                const floats away = (within - floats(place)) * floats(1 / width);
                return power_of_two<simd_width>(away * away * floats(-0.72134752F));
            };
            const floats number = noise(3e-3F, 2, distance);
            const floats level = power_of_two<simd_width>(
                floats(bits_per_decibel) * multiply_add(number, floats(of_.spread_db), floats(of_.level_db)));
            const floats other = power_of_two<simd_width>(noise(4e-3F, 3, distance) - floats(0.5F));
            const floats both = multiply_add(line(0.85F), other, line(0.1F));
            const floats gain = multiply_add(level * floats(echo), both, floats(1.0F));
            store(load<simd_width>(real + i) * gain, real + i);
            store(load<simd_width>(imaginary + i) * gain, imaginary + i);
        }
    }

  private:
    using floats = lanes<simd_width>;

    INSONIFY_FN floats noise(float size, std::uint32_t number, const floats& distance) const {
        const auto coordinate = [&](int k) {
            return multiply_add(distance, floats(along_[k] / size), floats(origin_[k] / size));
        };
        return value_noise<simd_width>(mix_bits(key_ ^ (number * 0x632BE5ABU)), coordinate(0), coordinate(1),
                                       coordinate(2));
    }

    const structure::sheath_layer& of_;
    vec3 origin_, along_;
    std::uint32_t key_;
    float lobe_;
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
