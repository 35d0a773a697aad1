#ifndef INSONIFY_TISSUE_SHEATH_GAINS_HPP
#define INSONIFY_TISSUE_SHEATH_GAINS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tissue/structure_gains.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Factors on the amplitude of speckle in the sheath of an object, below one surface of a segment of a line: see
/// `structure::sheath_layer`.
class sheath_gains {
  public:
    /// @param origin, along  of a segment of a line: metres, and metres of material per metre of the line
    /// @param fnumber        of the receiving aperture
    /// @param key            of the object
    /// @param length         of the segment, metres
    /// @param surface        distance of the surface, metres from the same origin
    /// @param cosine         of the angle of incidence on it; negative where the line leaves the object, 0: no sheath
    /// @param max_range      length of the line that the sheath may take, metres: to the middle of a thin object, where it
    ///                       meets the sheath of the surface on the other side
    INSONIFY_FN sheath_gains(const structure::sheath_layer& of, vec3 origin, vec3 along, float fnumber,
                             std::uint32_t key, float length, float surface, float cosine, float max_range)
        : of_{of}, origin_{origin}, along_{along}, fnumber_{fnumber}, key_{key}, surface_{surface}, cosine_{cosine} {
        if (!(of.thickness > 0) || cosine == 0) return;
        range_ = min(2 * of.thickness / max(std::fabs(cosine), 1e-3F), max_range);
        begin_ = max(cosine > 0 ? surface : surface - range_, 0);
        end_ = min(cosine > 0 ? surface + range_ : surface, length);
    }

    /// Multiplies complex amplitudes at equal steps from a distance on; metres from the origin of the segment. The arrays have
    /// room for whole registers.
    INSONIFY_FN void apply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        const auto slot = [&](float distance) {
            return static_cast<std::uint32_t>(clamp((distance - first) / step, 0, static_cast<float>(count)));
        };
        if (!(begin_ < end_)) return;
        const std::uint32_t from = slot(begin_) / max_simd_width * max_simd_width,
                            to = slot(end_ + 1.5F * step); // past the slot that the end cuts
        if (from >= to) return;
        if (!prepared_) prepare();
        const floats per_width(1 / min(0.12e-3F / of_.thickness, 0.25F)); // standard deviation of a line
        for (std::uint32_t i = from; i < to; i += max_simd_width) {
            const float here = first + static_cast<float>(i) * step;
            const floats distance =
                floats(here - surface_) + floats_of<max_simd_width>(steps_of_bits<max_simd_width>(0, 1)) * floats(step);
            const floats within = distance * floats(cosine_ / of_.thickness) / thickness_.at(here, step);
            const auto line = [&](float place) {
                const floats away = (within - floats(place)) * per_width;
                return power_of_two<max_simd_width>(away * away * floats(-0.72134752F));
            };
            const floats both = multiply_add(line(0.85F), other_.at(here, step), line(0.1F));
            const floats gain = select(abs(distance) < floats(range_),
                                       multiply_add(level_.at(here, step), both, floats(1.0F)), floats(1.0F));
            store(load<max_simd_width>(real + i) * gain, real + i);
            store(load<max_simd_width>(imaginary + i) * gain, imaginary + i);
        }
    }

  private:
    using floats = lanes<max_simd_width>;

    INSONIFY_FN void prepare() {
        const float origin = dot(origin_, along_) / dot(along_, along_);
        const auto evaluate = [&](line_nodes& nodes, float size, std::uint32_t number, float factor, float offset) {
            nodes.evaluate(begin_, end_, 0.2F * size, origin, [&](const floats& distance) {
                return power_of_two<max_simd_width>(
                    multiply_add(noise(size, number, distance), floats(factor), floats(offset)));
            });
        };
        const float sine_squared = 1 - min(cosine_ * cosine_, 1), diffuse = amplitude_of_decibels(of_.diffuse_db);
        const float lobe = lobe_of(of_.waviness, fnumber_);
        const float echo = diffuse + (1 - diffuse) * std::exp2(-sine_squared / (lobe * lobe));
        evaluate(thickness_, 6e-3F, 1, 0.3F, 0);
        evaluate(level_, 3e-3F, 2, bits_per_decibel * of_.spread_db,
                 bits_per_decibel * of_.level_db + std::log2(max(echo, 1e-12F)));
        evaluate(other_, 4e-3F, 3, 1, -0.5F);
        prepared_ = true;
    }
    INSONIFY_FN floats noise(float size, std::uint32_t number, const floats& distance) const {
        const auto coordinate = [&](int k) {
            return multiply_add(distance, floats(along_[k] / size), floats(origin_[k] / size));
        };
        return value_noise<max_simd_width>(mix_bits(key_ ^ (number * 0x632BE5ABU)), coordinate(0), coordinate(1),
                                           coordinate(2));
    }

    const structure::sheath_layer& of_;
    vec3 origin_, along_;
    float fnumber_;
    std::uint32_t key_;
    float surface_, cosine_;
    float range_ = 0;           // length of the sheath, metres along the line
    float begin_ = 0, end_ = 0; // of it, metres from the origin
    bool prepared_ = false;
    line_nodes thickness_, level_,
        other_; // relative to the mean; amplitude of the first line, and of the other relative to it
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
