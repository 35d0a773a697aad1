#ifndef INSONIFY_TRACING_BEAM_TABLE_HPP
#define INSONIFY_TRACING_BEAM_TABLE_HPP

#include <insonify/acoustics/layer.hpp>
#include <insonify/bvh/large_array.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/signal/beam.hpp>
#include <insonify/signal/lateral_kernel.hpp>
#include <insonify/tracing/elevation.hpp>
#include <concepts>
#include <optional>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What an acoustic model must know of the beam, for every line.
///
/// Independent echoes lose level where the beam averages them, and how much depends on the lines and planes that there
/// are; `incoherent`, g, makes up for it: sum over j, k of w_j g_j w_k g_k C(x_j - x_k) = 1 on every line, with the weights w
/// of the beam and the covariance C of the echoes. Lines near the border have fewer neighbours, hence their own table.
class beam_table {
  public:
    static constexpr std::uint32_t depths = 128;

    /// @param texture, surface  covariances of the echoes of tissue, and of rough surfaces
    template <class Policy, transducer Probe, class Texture, class Surface>
    beam_table(const Policy& policy, const Probe& probe, float depth, const elevation_planes& planes,
               const Texture& texture, const Surface& surface)
        : lines_{probe.lines}, spacing_{depth / depths} {
        const beam_model beam = beam_of(probe, depth);
        // One step of the kernel for each of the depths.
        const lateral_kernel kernel =
            make_lateral_kernel(probe, {.depth = depth, .samples = depths * lateral_kernel::depth_step});
        border_ = kernel.full_circle ? 0 : std::min(static_cast<std::uint32_t>(kernel.reach()), (probe.lines - 1) / 2);
        samples_.resize(std::size_t{border_ + 1} * depths);
        for (std::uint32_t i = 0; i < planes.count(); ++i) plane_offsets_.push_back(planes.offset(i));
        plane_weights_.resize(std::size_t{depths} * planes.count());
        const float turned = probe.lines < 2 ? 0.0F : angle_between(probe.beam(0).direction, probe.beam(1).direction);
        for_each_index(policy, depths, [&](std::size_t k) {
            const float z = (static_cast<float>(k) + 0.5F) * spacing_;
            float weight[elevation_planes::most];
            planes.weights(z, weight);
            std::copy_n(weight, planes.count(),
                        plane_weights_.begin() + static_cast<std::ptrdiff_t>(k * planes.count()));
            const lateral_weights across = kernel.at(static_cast<std::uint32_t>(k) * lateral_kernel::depth_step);
            const levels of_texture = levels_of(across, turned, planes, weight, texture);
            const levels of_surface = levels_of(across, turned, planes, weight, surface);
            const levels of_noise = levels_of(across, turned, planes, weight, [](float, float) { return 0.0F; });
            for (std::uint32_t line = 0; line <= border_; ++line)
                samples_[std::size_t{line} * depths + k] = {.fnumber = beam.fnumber(z),
                                                            .elevation_fnumber = beam.elevation_fnumber(),
                                                            .lateral_sigma =
                                                                probe.lines > 1 ? beam.lateral_sigma(z) : 0.0F,
                                                            .line_spacing = across.spacing,
                                                            .incoherent = of_texture.gain[line],
                                                            .alike = of_texture.alike[line],
                                                            .surface_incoherent = of_surface.gain[line],
                                                            .surface_alike = of_surface.alike[line],
                                                            .independent = of_noise.gain[line]};
        });
    }

    /// No table: for models that ask for none.
    beam_table() = default;

    INSONIFY_LAZY line_beam of_line(std::uint32_t line) const {
        if (samples_.empty()) return {};
        return {.samples = {samples_.data() + std::size_t{to_border(line)} * depths, depths},
                .spacing = spacing_,
                .plane_offsets = plane_offsets_,
                .plane_weights = plane_weights_};
    }

  private:
    // By distance from the border.
    struct levels {
        std::vector<float> gain;
        std::vector<vec2> alike;
    };

    template <class Covariance>
    levels levels_of(const lateral_weights& across, float turned, const elevation_planes& planes,
                     const float (&weight)[elevation_planes::most], const Covariance& covariance) const {
        float power = 0, apart_squared = 0;
        for (std::uint32_t i = 0; i < planes.count(); ++i)
            for (std::uint32_t j = 0; j < planes.count(); ++j) {
                const float apart = planes.offset(i) - planes.offset(j);
                const float common = weight[i] * weight[j] * (i == j ? 1.0F : covariance(apart, 0));
                power += common;
                apart_squared += common * apart * apart;
            }
        const auto between_lines = [&](int lag) {
            const auto lines = static_cast<float>(lag);
            return lag == 0 ? 1.0F : covariance(lines * across.spacing, lines * turned);
        };
        const auto lag_squared = [&](int lag) {
            const float apart = static_cast<float>(lag) * across.spacing;
            return between_lines(lag) * apart * apart;
        };
        levels found{std::vector<float>(border_ + 1, 1.0F), std::vector<vec2>(border_ + 1)};
        const auto gain_of = [&](std::uint32_t line) { return found.gain[to_border(line)]; };
        std::vector<float> level(border_ + 1);
        for (int round = 0; round < 5; ++round) { // a line's level depends on its neighbours' gains: settle
            for (std::uint32_t line = 0; line <= border_; ++line)
                level[line] = power * across.power(line, between_lines, gain_of);
            for (std::uint32_t line = 0; line <= border_; ++line) found.gain[line] /= std::sqrt(level[line]);
        }
        for (std::uint32_t line = 0; line <= border_; ++line)
            found.alike[line] = {power * across.power(line, lag_squared, gain_of), apart_squared / power};
        return found;
    }

    INSONIFY_LAZY static float angle_between(vec3 a, vec3 b) { return 2 * std::asin(lesser(0.5F * length(a - b), 1)); }

    // Which table a line has: its distance from the nearer end, as far as that matters.
    INSONIFY_LAZY std::uint32_t to_border(std::uint32_t line) const {
        return std::min({line, lines_ - 1 - line, border_});
    }

    std::uint32_t lines_ = 0;
    std::uint32_t border_ = 0;
    float spacing_ = 0;
    large_array<beam_sample> samples_;
    std::vector<float> plane_offsets_;
    std::vector<float> plane_weights_;
};

/// The table for a model that says how alike independent echoes are on two lines, with a member
/// `float covariance(float apart, float turned) const` (metres, radians); none for others.
template <class Policy, transducer Probe, class Model>
beam_table make_beam_table(const Policy& policy, const Probe& probe, float depth, const elevation_planes& planes,
                           const Model& model) {
    if constexpr (requires { model.covariance(depth, depth); })
        return {policy,
                probe,
                depth,
                planes,
                [&](float apart, float turned) { return model.covariance(apart, turned); },
                [&](float apart, float turned) {
                    if constexpr (requires { model.surface_covariance(apart, turned); })
                        return model.surface_covariance(apart, turned);
                    else
                        return model.covariance(apart, turned);
                }};
    else
        return {};
}

/// The table of the frame before, made anew where the probe, the depth, the planes or the model has changed, or where
/// probes or models cannot be compared.
template <transducer Probe, class Model>
class kept_beam_table {
  public:
    template <class Policy>
    const beam_table& operator()(const Policy& policy, const Probe& probe, float depth, const elevation_planes& planes,
                                 const Model& model) {
        if constexpr (std::equality_comparable<Probe> && std::equality_comparable<Model>) {
            if (made_for_ && made_for_->probe == probe && made_for_->depth == depth &&
                made_for_->planes == planes.count() && made_for_->model == model)
                return table_;
        }
        table_ = make_beam_table(policy, probe, depth, planes, model);
        made_for_.emplace(cause{probe, depth, planes.count(), model});
        return table_;
    }

  private:
    struct cause {
        Probe probe;
        float depth;
        std::uint32_t planes;
        Model model;
    };
    std::optional<cause> made_for_{};
    beam_table table_{};
};

} // namespace insonify::inline INSONIFY_ABI
#endif
