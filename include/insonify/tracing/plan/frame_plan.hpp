#ifndef INSONIFY_TRACING_PLAN_FRAME_PLAN_HPP
#define INSONIFY_TRACING_PLAN_FRAME_PLAN_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/core/memo.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/signal/kernel/kernel_table.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/plan/check.hpp>
#include <insonify/tracing/plan/frame_lines.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// What the function of one line reads of a frame: its lines, sampling and kernels. Trivially copyable where the probe is.
template <transducer Probe>
struct frame_view : detail::frame_lines<Probe> {
    float spacing = 0;                      ///< metres from sample to sample
    float pulse_sigma = 0;                  ///< standard deviation of the pulse envelope, metres of displayed depth
    float bandwidth = 0;                    ///< see `traced_line`
    std::uint32_t samples = 0;              ///< along each line
    view<const std::uint32_t> plane_sets{}; ///< of each line, the number of its set of plane weights
    view<const float> plane_weights{};      ///< for each set, plane after plane, one weight for each sample
    line_aperture aperture{};               ///< that receives
    detail::kernel_table_view kernels{};    ///< of the stages that follow
    std::uint32_t frame_number = 0;         ///< speckle of flowing media depends on it

    /// The weights of the samples of a line in one of the planes; where there are several.
    INSONIFY_FN const float* weights(std::uint32_t number, std::uint32_t of_plane) const {
        return plane_weights.data() + (std::size_t{plane_sets[number]} * this->planes + of_plane) * samples;
    }
};

/// All that follows from probe, acquisition and model alone: kept between frames, recomputed where one of them changes.
template <transducer Probe, acoustic_model Model>
class frame_plan {
  public:
    /// @param samples  along each line, chosen
    /// @throws usage_error  for a number of planes other than 1, 3, 5 or 7
    template <class Policy>
    detail::frame_view<Probe> view_of(const Policy& policy, const Probe& probe, const pose& at, const Model& model,
                                      const acquisition& scan, std::uint32_t samples, view<const medium> media) {
        const tables& made =
            tables_([&](tables& t) { t.compute(policy, probe, scan.depth, samples, scan.planes, model); }, probe,
                    scan.depth, samples, scan.planes, model);
        detail::frame_view<Probe> frame{detail::frame_lines<Probe>{.probe = probe,
                                                                   .at = at,
                                                                   .depth = scan.depth,
                                                                   .max_depth = max_depth_of(model, scan.depth, media),
                                                                   .planes = scan.planes}};
        frame.spacing = scan.depth / static_cast<float>(samples);
        frame.pulse_sigma = nominal_pulse(probe).sigma_z(probe.frequency);
        frame.bandwidth = fractional_bandwidth(probe);
        frame.samples = samples;
        frame.plane_sets = made.plane_sets;
        frame.plane_weights = made.plane_weights;
        frame.aperture = made.aperture_view();
        frame.kernels = made.kernels.view_of();
        frame.frame_number = scan.frame;
        for (std::uint32_t i = 0; i < frame.planes; ++i) frame.plane[i] = made.plane[i];
        return frame;
    }

  private:
    struct tables {
        std::vector<detail::elevation_plane> plane{};
        std::vector<std::uint32_t> plane_sets{};
        std::vector<float> plane_weights{}, fnumbers{}, strips{}, phase_spreads{};
        float fnumber_spacing = 1, elevation_fnumber = 4, height = 0;
        planes_of_lines of_lines{};
        kernel_table kernels{};

        template <class Policy>
        void compute(const Policy& policy, const Probe& probe, float depth, std::uint32_t samples, std::uint32_t count,
                     const Model& model) {
            const beam_model beam = beam_of(probe, depth);
            const elevation_planes planes{beam, count, depth, lines_follow_depth(probe)};
            plane.clear();
            for (std::uint32_t i = 0; i < count; ++i) plane.push_back(planes[i]);
            of_lines.assign(policy, probe, planes);
            plane_sets = of_lines.set_of_line();
            plane_weights.clear();
            for (std::size_t set = 0; count > 1 && set < of_lines.sets(); ++set)
                of_lines[set].weights_of_samples(samples, depth / static_cast<float>(samples), plane_weights);
            compute_kernel_table(policy, probe, depth, of_lines, model, kernels);
            constexpr std::uint32_t parts = detail::kernel_table_view::depths;
            fnumber_spacing = depth / parts;
            fnumbers.clear();
            strips.clear();
            phase_spreads.clear();
            for (std::uint32_t k = 0; k < parts; ++k) {
                const float z = (static_cast<float>(k) + 0.5F) * fnumber_spacing;
                fnumbers.push_back(beam.fnumber(z));
                strips.push_back(planes.strip(z));
                phase_spreads.push_back(planes.phase_spread(z));
            }
            elevation_fnumber = beam.elevation_fnumber();
            height = planes.scatterer_height();
        }
        line_aperture aperture_view() const {
            return {fnumbers, fnumber_spacing, elevation_fnumber, height, strips, phase_spreads};
        }
    };

    memo<tables, Probe, float, std::uint32_t, std::uint32_t, Model> tables_{};
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
