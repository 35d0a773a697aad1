#ifndef INSONIFY_TRACING_PLAN_FRAME_PLAN_HPP
#define INSONIFY_TRACING_PLAN_FRAME_PLAN_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/memo.hpp>
#include <insonify/geometry/ray.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/signal/kernel/kernel_table.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Upper bound of the samples of a frame.
inline constexpr std::uint64_t max_samples = std::uint64_t{1} << 28U;

/// Upper bound of the length of a line in wavelengths: the number of scatterers grows with it, whatever the samples.
inline constexpr float max_wavelengths = 1 << 24;

/// Checks the lines of a frame.
/// @throws usage_error     for a scene that was not built, or a probe or depth out of range
/// @throws geometry_error  for a pose that is not rigid
inline void check_lines(const scene& body, float frequency, const pose& at, float depth, const char* caller) {
    body.require_built();
    check_rigid(at, caller, "the pose of the probe");
    check_depth(depth, caller);
    if (depth * frequency > max_wavelengths * display_speed)
        throw usage_error{caller,    ": a depth of ",
                          depth,     " m at ",
                          frequency, " Hz is more than 2^24 wavelengths; lower the depth or the frequency"};
}

/// @return `samples`
/// @throws usage_error  for too many of them in all
inline std::uint32_t checked_samples(std::uint32_t lines, std::uint32_t samples, const char* caller) {
    if (std::uint64_t{samples} * lines > max_samples)
        throw usage_error{caller, ": ", lines, " lines of ", samples, " samples are more than 2^28; ask for fewer"};
    return samples;
}

/// Checks the arguments of a tracer.
/// @return the number of samples along each line
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <class Model>
std::uint32_t check_acquisition(const scene& body, const probe_settings& probe, const pose& at, const Model& model,
                                const acquisition& settings, const char* caller = "trace") {
    check_lines(body, probe.frequency, at, settings.depth, caller);
    if constexpr (requires { model.check(); }) model.check();
    return checked_samples(
        probe.lines, settings.samples != 0 ? settings.samples : model.samples(settings.depth, probe.frequency), caller);
}

/// The lines of a frame in all of its elevation planes. Trivially copyable.
struct frame_lines {
    view<const probe_line> lines{};                   ///< of the probe that sends and receives
    pose at{};                                        ///< probe to world
    float depth = 0;                                  ///< of the last sample's end, metres
    float max_depth = 0;                              ///< how far lines are followed, metres
    std::uint32_t planes = 1;                         ///< that represent the thickness of the slice
    elevation_plane plane[max_elevation_planes] = {}; ///< the slice plane, then pairs to both sides of it

    /// A line of the probe in one of the planes, in the world: displaced in elevation alone, so the distance along it
    /// stays the displayed one.
    INSONIFY_FN line_frame line(std::uint32_t number, std::uint32_t of_plane) const {
        const probe_line& beam = lines[number];
        const vec3 elevation = at.rotation[1];
        line_frame line{at.point(beam.origin) + plane[of_plane].height(beam.origin.z) * elevation,
                        at.direction(beam.direction), elevation, plane[of_plane].slope * beam.direction.z};
        if (!(beam.scatterer_axis == beam.direction))
            line.steering = at.direction(beam.direction - beam.scatterer_axis);
        return line;
    }
    INSONIFY_FN std::uint32_t count() const { return static_cast<std::uint32_t>(lines.size()); }
    /// The tilt of a line of any direction in the world that runs in one of the planes: see `line_frame`.
    INSONIFY_FN float tilt(vec3 direction, std::uint32_t of_plane) const {
        return plane[of_plane].slope * dot(direction, at.direction({0, 0, 1}));
    }
};

/// What the function of one line reads of a frame: its lines, sampling and kernels. Trivially copyable.
struct frame_view : frame_lines {
    float frequency = 0;                    ///< of the probe, hertz
    float spacing = 0;                      ///< metres from sample to sample
    float pulse_sigma = 0;                  ///< standard deviation of the pulse envelope, metres of displayed depth
    float bandwidth = 0;                    ///< see `traced_line`
    std::uint32_t samples = 0;              ///< along each line
    view<const std::uint32_t> plane_sets{}; ///< of each line, the number of its set of plane weights
    view<const float> plane_weights{};      ///< for each set, plane after plane, one weight for each sample
    line_aperture aperture{};               ///< that receives
    kernel_table_view kernels{};            ///< of the stages that follow
    std::uint32_t frame_number = 0;         ///< speckle of flowing media depends on it

    /// The weights of the samples of a line in one of the planes; where there are several.
    INSONIFY_FN const float* weights(std::uint32_t number, std::uint32_t of_plane) const {
        return plane_weights.data() + (std::size_t{plane_sets[number]} * planes + of_plane) * samples;
    }
};

/// All that follows from probe, acquisition and model alone: kept between frames, recomputed where one of them changes.
template <acoustic_model Model>
class frame_plan {
  public:
    /// @param samples  along each line, chosen
    /// @return         refers to `probe`
    /// @throws usage_error  for a number of planes other than 1, 3, 5 or 7
    template <class Policy>
    frame_view view_of(const Policy& policy, probe_lines&& probe, const pose& at, const Model& model,
                       const acquisition& scan, std::uint32_t samples, view<const medium> media) = delete;
    template <class Policy>
    frame_view view_of(const Policy& policy, const probe_lines& probe, const pose& at, const Model& model,
                       const acquisition& scan, std::uint32_t samples, view<const medium> media) {
        const tables& made =
            tables_([&](tables& t) { t.compute(policy, probe, scan.depth, samples, scan.planes, model); }, probe,
                    scan.depth, samples, scan.planes, model);
        const probe_settings& settings = probe.settings();
        frame_view frame{frame_lines{.lines = probe.lines(),
                                     .at = at,
                                     .depth = scan.depth,
                                     .max_depth = max_depth_of(model, scan.depth, media),
                                     .planes = scan.planes}};
        frame.frequency = settings.frequency;
        frame.spacing = scan.depth / static_cast<float>(samples);
        frame.pulse_sigma = axial_sigma(settings.bandwidth, settings.frequency);
        frame.bandwidth = settings.bandwidth;
        frame.samples = samples;
        frame.plane_sets = made.of_lines.set_of_line();
        frame.plane_weights = made.plane_weights;
        frame.aperture = made.aperture_view();
        frame.kernels = made.kernels.view_of();
        frame.frame_number = scan.frame;
        for (std::uint32_t i = 0; i < frame.planes; ++i) frame.plane[i] = made.plane[i];
        return frame;
    }

  private:
    struct tables {
        std::vector<elevation_plane> plane{};
        std::vector<float> plane_weights{}, fnumbers{}, strips{}, phase_spreads{};
        float fnumber_spacing = 1, elevation_fnumber = 4, height = 0;
        planes_of_lines of_lines{};
        kernel_table kernels{};

        template <class Policy>
        void compute(const Policy& policy, const probe_lines& probe, float depth, std::uint32_t samples,
                     std::uint32_t count, const Model& model) {
            const beam_model beam = make_beam(probe.settings(), depth);
            const elevation_planes planes{beam, count, depth, lines_follow_depth(probe)};
            plane.clear();
            for (std::uint32_t i = 0; i < count; ++i) plane.push_back(planes[i]);
            of_lines.assign(policy, probe, planes);
            const float spacing = depth / static_cast<float>(samples);
            plane_weights.resize(count > 1 ? of_lines.sets() * count * samples : 0);
            for (std::size_t set = 0; count > 1 && set < of_lines.sets(); ++set)
                for (std::uint32_t k = 0; k < samples; ++k) {
                    const elevation_planes::weights here = of_lines[set].at((static_cast<float>(k) + 0.5F) * spacing);
                    for (std::uint32_t i = 0; i < count; ++i)
                        plane_weights[(set * count + i) * samples + k] = here.coherent[i];
                }
            compute_kernel_table(policy, probe, depth, of_lines, model, kernels);
            constexpr std::uint32_t parts = kernel_table_view::depths;
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

    memo<tables, probe_lines, float, std::uint32_t, std::uint32_t, Model> tables_{};
};

/// How the tissue along the lines of one frame is displaced: see `scene::deform`. Sampled in the box of these lines
/// alone, in axes of the probe.
class frame_displacements {
  public:
    /// @throws geometry_error  where the map that deforms the scene folds over in the field of view
    template <class Policy>
    view<const displacement_view> compute(const Policy& policy, const scene& body, const frame_view& frame) {
        if (!body.is_deformed()) return {};
        const displacement_lattice where = lattice_of(frame);
        const view<const displacement_view> found = body.displacements(policy, where, nodes_, places_);
        for (std::size_t i = 0; !found.empty() && i < where.count(); ++i)
            if (nodes_[4 * i + 3] != 0 && is_seen(frame, where, where.point(i))) throw_folded(where.point(i));
        return found;
    }

  private:
    static constexpr float min_spacing = 1e-3F; // metres
    static constexpr float max_cells = 64;      // along an axis

    // Whether some line passes a node so closely that it is interpolated from it.
    static bool is_seen(const frame_view& frame, const displacement_lattice& where, vec3 node) {
        vec3 local = frame.at.local_point(node);
        local.y = 0;
        return std::any_of(frame.lines.begin(), frame.lines.end(), [&](const probe_line& line) {
            const vec3 from = local - line.origin;
            const float depth = dot(from, line.direction);
            return depth > 0 && depth < frame.depth && length(from - depth * line.direction) < where.spacing.x;
        });
    }

    static displacement_lattice lattice_of(const frame_view& frame) {
        aabb box;
        for (std::uint32_t plane = 0; plane < frame.planes; ++plane)
            for (std::uint32_t i = 0; i < frame.count(); ++i) {
                const line_frame line = frame.line(i, plane);
                box = merged(merged(box, frame.at.local_point(line.origin)),
                             frame.at.local_point(line.at(frame.max_depth)));
            }
        const vec3 extent = box.size();
        const float spacing = max(min_spacing, max(extent.x, max(extent.y, extent.z)) / max_cells);
        displacement_lattice lattice;
        vec3 cells;
        for (int axis = 0; axis < 3; ++axis) {
            cells[axis] = max(std::ceil(extent[axis] / spacing), 1);
            lattice.size[axis] = static_cast<std::uint32_t>(cells[axis]) + 1;
        }
        lattice.spacing = vec3{spacing};
        lattice.at = {frame.at.rotation, frame.at.point(box.centre() - 0.5F * spacing * cells)};
        return lattice;
    }

    std::vector<float> nodes_{};
    std::vector<displacement_view> places_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
