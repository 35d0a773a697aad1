#ifndef INSONIFY_TRACING_CHECK_HPP
#define INSONIFY_TRACING_CHECK_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Most samples of one frame: lines times samples a line.
inline constexpr std::uint64_t most_samples = std::uint64_t{1} << 28U;

/// No line is longer than so many wavelengths: the time to make texture grows with them, whatever the samples.
inline constexpr float most_wavelengths = 1 << 24;

/// What every tracer asks of its arguments before it starts.
/// @return the number of samples along each line
/// @throws usage_error     for an unbuilt scene, senseless settings, absurd sizes
/// @throws geometry_error  for a pose that is not rigid
template <transducer Probe, class Model>
std::uint32_t check_acquisition(const scene& body, const Probe& probe, const pose& at, const Model& model,
                                const acquisition& settings) {
    body.require_built();
    probe.check();
    if constexpr (requires { model.check(); }) model.check();
    if (!is_rigid(at)) throw geometry_error{"trace: the pose of the probe is no rigid motion; make it with look_at"};
    if (!is_depth(settings.depth))
        throw usage_error{"trace: `depth` must be a number of metres, from 1 nm to 1000 km, such as 80_mm"};
    if (settings.depth * probe.frequency > most_wavelengths * display_speed)
        throw usage_error{"trace: a depth of " + std::to_string(settings.depth) +
                          " m is more than 2^24 wavelengths; give it in metres, such as 80_mm"};
    const std::uint32_t samples =
        settings.samples != 0 ? settings.samples : model.samples(settings.depth, probe.frequency);
    if (std::uint64_t{samples} * probe.lines > most_samples)
        throw usage_error{"trace: " + std::to_string(probe.lines) + " lines of " + std::to_string(samples) +
                          " samples are more than 2^28; ask for fewer"};
    return samples;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
