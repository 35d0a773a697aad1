#ifndef INSONIFY_TRACING_CHECK_HPP
#define INSONIFY_TRACING_CHECK_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/text.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/probe/plausible.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Upper bound of the samples of a frame.
inline constexpr std::uint64_t max_samples = std::uint64_t{1} << 28U;

/// Upper bound of the length of a line in wavelengths: the number of scatterers grows with it, whatever the samples.
inline constexpr float max_wavelengths = 1 << 24;

/// Checks the arguments of a tracer.
/// @return the number of samples along each line
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <transducer Probe, class Model>
std::uint32_t check_acquisition(const scene& body, const Probe& probe, const pose& at, const Model& model,
                                const acquisition& settings) {
    body.require_built();
    probe.check();
    if constexpr (requires { model.check(); }) model.check();
    if (!is_rigid(at))
        throw geometry_error{"trace: the pose of the probe is not a rigid transform; make it with look_at, or mend it "
                             "with orthonormalised"};
    check_depth(settings.depth, "trace");
    if (settings.depth * probe.frequency > max_wavelengths * display_speed)
        throw usage_error{
            joined({"trace: a depth of ", number_text(settings.depth), " m at ", number_text(probe.frequency),
                    " Hz is more than 2^24 wavelengths; lower the depth or the frequency"})};
    const std::uint32_t samples =
        settings.samples != 0 ? settings.samples : model.samples(settings.depth, probe.frequency);
    if (std::uint64_t{samples} * probe.lines > max_samples)
        throw usage_error{joined({"trace: ", std::to_string(probe.lines), " lines of ", std::to_string(samples),
                                  " samples are more than 2^28; ask for fewer"})};
    return samples;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
