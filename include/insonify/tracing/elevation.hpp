#ifndef INSONIFY_TRACING_ELEVATION_HPP
#define INSONIFY_TRACING_ELEVATION_HPP

#include <insonify/core/error.hpp>
#include <insonify/signal/beam.hpp>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Most elevation planes of a frame.
inline constexpr std::uint32_t max_elevation_planes = 7;

namespace detail {

/// Parallel planes that sample the thickness of the slice: the slice plane, and pairs to both sides of it.
///
/// A reflector out of the slice plane counts with the weights of the planes that intersect it, which change with depth as
/// the elevation width of the beam does.
class elevation_planes {
  public:
    /// @param count  1, 3, 5 or 7: the middle one, and pairs at 0.9, 2.2 and 5 standard deviations of the beam where it is
    ///               thinnest
    /// @throws usage_error  for another count
    elevation_planes(const beam_model& beam, std::uint32_t count) : beam_{beam}, count_{count} {
        if (count % 2 == 0 || count > max_elevation_planes)
            throw usage_error{"trace: `planes` is " + std::to_string(count) +
                              "; it must be 1, 3, 5 or 7: the slice plane, and pairs to both sides of it"};
        constexpr float deviations[] = {0, 0.9F, 2.2F, 5};
        const float sigma = beam.elevation_sigma(beam.elevation_focus);
        for (std::uint32_t i = 0; i < count; ++i) {
            offset_[i] = deviations[(i + 1) / 2] * (i % 2 == 0 ? sigma : -sigma);
            const float inner = i == 0 ? 0 : deviations[(i + 1) / 2 - 1];
            const bool last = i + 2 >= count;
            const float outer = last ? deviations[(i + 1) / 2] : deviations[(i + 1) / 2 + 1];
            width_[i] = i == 0 ? 2 * outer : outer - inner; // twice the strip that the plane represents
            height_[i] = count == 1 ? 0 : 0.5F * width_[i] * sigma;
        }
        if (count == 1) width_[0] = 1;
    }

    std::uint32_t count() const { return count_; }

    /// Metres out of the slice plane.
    float offset(std::uint32_t plane) const { return offset_[plane]; }

    /// Height of the strip that a plane represents, metres; 0 for a single plane.
    float height(std::uint32_t plane) const { return height_[plane]; }

    /// Height of the tissue that contributes to an echo, metres: an eighth of the aperture's, as the beam has in the middle of
    /// its range. It is the same at all depths, or speckle would change as tissue moves to and fro.
    float scatterer_height() const { return beam_.elevation_height / 8; }

    /// The weight of each plane at a depth in metres; their sum is 1.
    void weights(float depth, float (&weight)[max_elevation_planes]) const {
        const float sigma = beam_.elevation_sigma(depth);
        float sum = 0;
        for (std::uint32_t i = 0; i < count_; ++i) {
            const float deviations = offset_[i] / sigma;
            weight[i] = width_[i] * std::exp(-0.5F * deviations * deviations);
            sum += weight[i];
        }
        for (std::uint32_t i = 0; i < count_; ++i) weight[i] /= sum;
    }

    /// The same for every sample of a line: plane after plane, each with `samples` weights.
    void weights_of_samples(std::uint32_t samples, float spacing, std::vector<float>& all) const {
        all.resize(std::size_t{count_} * samples);
        float weight[max_elevation_planes];
        for (std::uint32_t k = 0; k < samples; ++k) {
            weights((static_cast<float>(k) + 0.5F) * spacing, weight);
            for (std::uint32_t i = 0; i < count_; ++i) all[std::size_t{i} * samples + k] = weight[i];
        }
    }

  private:
    beam_model beam_;
    std::uint32_t count_;
    float offset_[max_elevation_planes] = {};
    float width_[max_elevation_planes] = {};
    float height_[max_elevation_planes] = {};
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI
#endif
