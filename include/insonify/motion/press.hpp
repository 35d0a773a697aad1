#ifndef INSONIFY_MOTION_PRESS_HPP
#define INSONIFY_MOTION_PRESS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/motion/pressed_face.hpp>
#include <insonify/motion/skin_heights.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/queries.hpp>
#include <concepts>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Settings of `press`.
struct press_settings {
    float stiffness = 500;  ///< of the body under the face, N/m: see `contact::force`
    float gel = 0.5e-3F;    ///< lines whose face is no further than this from the skin touch it, metres
    float decay = 20e-3F;   ///< see `indentation`
    float recovery = 8e-3F; ///< see `indentation`
};

/// How a probe touches a body: see `press`.
struct contact {
    float depth = 0;                   ///< of the face in the body at rest, metres: the largest; 0: it is not pressed
    float mean_depth = 0;              ///< the mean over the face, metres
    float force = 0;                   ///< stiffness times mean depth, N: a toy of elasticity, and no more
    float pressure = 0;                ///< force over the part of the face that is pressed, Pa: `collapse::outside`
    std::uint32_t touching = 0;        ///< number of lines that touch the body
    std::vector<std::uint8_t> lines{}; ///< 1 for each line that touches, 0 for the others
    pressed_face deformation{};        ///< for `scene::deform`
};

/// `press`, frame after frame: holds the contact and memory, so that it allocates only while buffers grow.
class presser {
  public:
    /// See `insonify::press`. @return valid until the next call
    template <transducer Probe, std::predicate<object_id> Filter = any_object>
    const contact& press(const scene& body, const Probe& probe, const pose& at, const press_settings& settings = {},
                         const Filter& accepts = {}) {
        constexpr float behind = 0.05e-3F;
        probe.check();
        body.require_built();
        if (!is_rigid(at))
            throw geometry_error{
                "press: the pose is not a rigid transform; make it with look_at, or mend it with orthonormalised"};
        if (!(settings.stiffness >= 0) || !(settings.gel >= 0) || !(settings.decay > 0) || !(settings.recovery > 0))
            throw usage_error{"press: `stiffness` and `gel` must be at least 0, `decay` and `recovery` above 0"};
        contact& found = touch_;
        found.depth = 0;
        found.touching = 0;
        found.lines.clear();
        pressed_face& face = found.deformation;
        face.at = at;
        face.decay = settings.decay;
        face.recovery = settings.recovery;
        const auto last = static_cast<float>(probe.lines) - 0.5F;
        face.left = min(probe.beam(-0.5F).origin.x, probe.beam(last).origin.x);
        face.right = max(probe.beam(-0.5F).origin.x, probe.beam(last).origin.x);
        face.elevation = pressed_face{}.elevation;
        if constexpr (requires { probe.elevation_height; }) face.elevation = probe.elevation_height;
        for (std::size_t i = 0; i < pressed_face::columns; ++i)
            face.height[i] = probe.beam(last * static_cast<float>(i) / (pressed_face::columns - 1))
                                 .origin.z; // lines are evenly spaced
        skin_.begin(face);
        for (const object& one : body.objects())
            if (accepts(one.id)) skin_.add(one.surface.faces, body.rest_positions(one.id), one.at);
        skin_.finish();
        float sum = 0, pressed = 0;
        for (std::size_t row = 0; row < pressed_face::rows; ++row)
            for (std::size_t i = 0; i < pressed_face::columns; ++i) {
                const float depth = max(skin_.depth(row, i), 0);
                found.depth = max(found.depth, depth);
                sum += depth;
                pressed += depth > 0 ? 1.0F : 0.0F;
                face.depth[row][i] = max(depth - behind, 0);
            }
        if (!(found.depth < settings.decay))
            throw usage_error{
                detail::joined({"press: the face is ", detail::number_text(found.depth * 1e3F),
                                " mm deep in the body, more than `decay`: tissue would fold over; raise the "
                                "probe or `decay`"})};
        constexpr auto points = static_cast<float>(pressed_face::rows * pressed_face::columns);
        found.mean_depth = sum / points;
        found.force = settings.stiffness * found.mean_depth;
        const float area = (face.right - face.left) * face.elevation * pressed / points;
        found.pressure = area > 0 ? found.force / area : 0;
        for (std::uint32_t line = 0; line < probe.lines; ++line) {
            const float x = probe.beam(static_cast<float>(line)).origin.x;
            const bool touches = skin_.depth(pressed_face::rows / 2, face.nearest_column(x)) >= -settings.gel;
            found.lines.push_back(touches ? 1 : 0);
            found.touching += touches ? 1 : 0;
        }
        return found;
    }

    const contact& touch() const { return touch_; } ///< of the last call

  private:
    contact touch_{};
    detail::skin_heights skin_{}; // where the skin is
};

/// How a probe at a pose touches the body at rest, whatever the present deformation: how deep its face is in the body, what
/// deformation that makes, and which lines touch.
///
///     const contact touch = press(body, probe, at);
///     body.deform(exec::par, touch.deformation);
///
/// The body is what is inside of any object that is accepted, and not the background. Pressed skin comes to lie 0.05 mm behind
/// the face, so that lines start in tissue. Costs one pass over the vertices and faces.
/// @param accepts  bool(object_id): objects that belong to the body, such as all but the needle
/// @throws usage_error     for a probe or a setting out of range, or a scene that was not built
/// @throws geometry_error  for a pose that is not rigid
template <transducer Probe, std::predicate<object_id> Filter = any_object>
contact press(const scene& body, const Probe& probe, const pose& at, const press_settings& settings = {},
              const Filter& accepts = {}) {
    return presser{}.press(body, probe, at, settings, accepts);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
