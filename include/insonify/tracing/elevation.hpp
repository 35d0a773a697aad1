#ifndef INSONIFY_TRACING_ELEVATION_HPP
#define INSONIFY_TRACING_ELEVATION_HPP

#include <insonify/core/error.hpp>
#include <insonify/signal/beam.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// The slices that stand for the thickness of the beam: parallel to the slice plane, in the middle and to both sides.
///
/// A thing out of plane counts with the weight of the slices that it reaches, which changes with depth as the beam's
/// height does.
class elevation_planes {
  public:
    static constexpr std::uint32_t most = 7; ///< planes

    /// @param count  1, 3, 5 or 7: the middle one, and pairs at 0.9, 2.2 and 5 deviations of the beam at its thinnest
    /// @throws usage_error  for another count
    INSONIFY_LAZY elevation_planes(const beam_model& beam, std::uint32_t count) : beam_{beam}, count_{count} {
        if (count % 2 == 0 || count > most)
            throw usage_error{"trace: `planes` must be 1, 3, 5 or 7; one plane, or pairs to both sides of it"};
        constexpr float deviations[] = {0, 0.9F, 2.2F, 5};
        const float sigma = beam.elevation_sigma(beam.elevation_focus);
        for (std::uint32_t i = 0; i < count; ++i) {
            offset_[i] = deviations[(i + 1) / 2] * (i % 2 == 0 ? sigma : -sigma);
            const float inner = i == 0 ? 0 : deviations[(i + 1) / 2 - 1];
            const bool last = i + 2 >= count;
            const float outer = last ? deviations[(i + 1) / 2] : deviations[(i + 1) / 2 + 1];
            width_[i] = i == 0 ? 2 * outer : outer - inner; // twice the strip that the plane stands for
            height_[i] = count == 1 ? 0 : 0.5F * width_[i] * sigma;
        }
        if (count == 1) width_[0] = 1;
    }

    /// How many planes there are.
    std::uint32_t count() const { return count_; }

    /// Metres out of the slice plane.
    float offset(std::uint32_t plane) const { return offset_[plane]; }

    /// Metres out of the slice plane that a plane stands for; 0 of a plane alone.
    float height(std::uint32_t plane) const { return height_[plane]; }

    /// What each plane counts for at a depth in metres; together 1.
    INSONIFY_LAZY void weights(float depth, float (&weight)[most]) const {
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
    INSONIFY_LAZY void weights_of_samples(std::uint32_t samples, float spacing, std::vector<float>& all) const {
        all.resize(std::size_t{count_} * samples);
        float weight[most];
        for (std::uint32_t k = 0; k < samples; ++k) {
            weights((static_cast<float>(k) + 0.5F) * spacing, weight);
            for (std::uint32_t i = 0; i < count_; ++i) all[std::size_t{i} * samples + k] = weight[i];
        }
    }

  private:
    beam_model beam_;
    std::uint32_t count_;
    float offset_[most] = {};
    float width_[most] = {};
    float height_[most] = {};
};

} // namespace insonify::inline INSONIFY_ABI
#endif
