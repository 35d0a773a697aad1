#ifndef INSONIFY_TRACING_PLAN_CHECK_HPP
#define INSONIFY_TRACING_PLAN_CHECK_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Upper bound of the samples of a frame.
inline constexpr std::uint64_t max_samples = std::uint64_t{1} << 28U;

/// Upper bound of the length of a line in wavelengths: the number of scatterers grows with it, whatever the samples.
inline constexpr float max_wavelengths = 1 << 24;

/// Checks the lines of a frame.
/// @throws usage_error     for a scene that was not built, or a probe or depth out of range
/// @throws geometry_error  for a pose that is not rigid
template <transducer Probe>
void check_lines(const scene& body, const Probe& probe, const pose& at, float depth, const char* caller) {
    body.require_built();
    probe.check();
    if (!is_rigid(at))
        throw geometry_error{joined({caller, ": the pose of the probe is not a rigid transform; make it with look_at, "
                                             "or mend it with orthonormalised"})};
    check_depth(depth, caller);
    if (depth * probe.frequency > max_wavelengths * display_speed)
        throw usage_error{joined({caller, ": a depth of ", number_text(depth), " m at ", number_text(probe.frequency),
                                  " Hz is more than 2^24 wavelengths; lower the depth or the frequency"})};
}

/// @return `samples`
/// @throws usage_error  for too many of them in all
inline std::uint32_t checked_samples(std::uint32_t lines, std::uint32_t samples, const char* caller) {
    if (std::uint64_t{samples} * lines > max_samples)
        throw usage_error{joined({caller, ": ", std::to_string(lines), " lines of ", std::to_string(samples),
                                  " samples are more than 2^28; ask for fewer"})};
    return samples;
}

/// Checks the arguments of a tracer.
/// @return the number of samples along each line
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <transducer Probe, class Model>
std::uint32_t check_acquisition(const scene& body, const Probe& probe, const pose& at, const Model& model,
                                const acquisition& settings) {
    check_lines(body, probe, at, settings.depth, "trace");
    if constexpr (requires { model.check(); }) model.check();
    return checked_samples(probe.lines,
                           settings.samples != 0 ? settings.samples : model.samples(settings.depth, probe.frequency),
                           "trace");
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
