#ifndef INSONIFY_EXAMPLES_LIVE_PATIENT_HPP
#define INSONIFY_EXAMPLES_LIVE_PATIENT_HPP

#include "hands.hpp"
#include "vessel.hpp"
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace live {

/// The body under the probe: it is pressed by the face, pulses with the heart, and is dragged along by the needle. A film of
/// gel moves with the probe; where the face is further from the skin than that, there is air.
class patient {
  public:
    static constexpr float gel_film = 3_mm;  ///< no more gel than that
    static constexpr float max_press = 9_mm; ///< of the face, as far as the hand holds it
    static constexpr float decay = 24_mm;    ///< see `indentation`
    static constexpr float stiffness = 76;   ///< N/m: 3 mmHg a millimetre below a face of 38 x 5 mm, see `contact`

    /// @param anatomy  built or not; objects named "needle" and "gel" are replaced. Around a body that brings gel there is
    ///                 air; another one keeps its background
    explicit patient(scene anatomy) : body{without_tools(anatomy)}, at_rest_{body} {
        for (const object& one : body.objects()) soft_.push_back(one.id);
        at_rest_.build(exec::par);
        const auto find_vessel = [&](const char* name, vessel& in_world, vessel& in_object) {
            const std::optional<object_id> found = body.find(name);
            if (!found || body[*found].surface.positions.size() < 8) return;
            const object& one = body[*found];
            std::vector<vec3> points = one.surface.positions;
            in_object = vessel{*found, points};
            for (vec3& point : points) point = one.at.point(point);
            in_world = vessel{*found, points};
        };
        find_vessel("artery", motion.artery, flow.artery);
        find_vessel("vein", motion.vein, flow.vein);
    }

    scene body;
    object_id needle_id{}, gel_id{};
    tissue_motion motion{};                                 ///< of the last frame
    blood_flow flow{};                                      ///< of the last frame
    const contact& touch() const { return press_.touch(); } ///< of the last frame

    /// The needle and the gel, of the size that a probe has.
    void renew_tools(const needle_state& held, float width) {
        for (const char* name : {"needle", "gel"})
            if (const std::optional<object_id> old = body.find(name)) body.remove(*old);
        needle_id = body.add(make_needle(needle_diameter(held.gauge), 80_mm, {.bevel = held.bevel}), tissue::steel,
                             {.priority = 1000, .at = held.at(), .name = "needle", .crease_angle = 0.8F * held.bevel});
        const float half = 0.5F * width + 3_mm;
        gel_id = body.add(make_box({-half, -9_mm, -2_mm}, {half, 9_mm, gel_film}), tissue::gel,
                          {.priority = -1000, .name = "gel"});
        body.build(exec::par);
    }

    /// Depth of the skin at rest; that of the whole body's upper edge where there is none.
    float skin_at(vec2 place) const {
        const aabb box = at_rest_.box();
        const std::optional<surface_point> skin =
            first_surface(at_rest_, {.origin = {place.x, place.y, box.lower.z - 1_mm}, .direction = {0, 0, 1}});
        return skin ? skin->point.z : box.empty() ? 0 : box.lower.z;
    }
    aabb box() const { return at_rest_.box(); }

    /// The probe on the skin, at most `max_press` deep at any point of its face.
    pose probe_pose(const hand_state& hand, const linear_array& probe) const {
        const vec3 down{std::sin(hand.rock), std::sin(hand.tilt), std::cos(hand.rock) * std::cos(hand.tilt)};
        const vec3 from{hand.on_skin, skin_at(hand.on_skin) - hand.gel};
        pose at =
            hand.held ? *hand.held : look_at(from, from + down, {std::cos(hand.rotate), std::sin(hand.rotate), 0});
        at.translation.z -= std::max(deepest(at, probe.width) - max_press, 0.0F);
        return at;
    }

    /// Moves the tissue to where it is at a time, with the probe and the needle there.
    template <exec::policy Policy>
    void move(const Policy& policy, const linear_array& probe, const pose& at, const needle_state& held, float time,
              const pulsation& beat) {
        tissue_motion now;
        now.artery = motion.artery;
        now.vein = motion.vein;
        now.beat = beat;
        now.beat.time = time;
        constexpr float any_depth = 1e9F; // as the probe of a tracker may be anywhere: see `limited`
        const contact& touch =
            press_.press(at_rest_, probe, at, {.stiffness = stiffness, .gel = gel_film, .decay = any_depth});
        now.pressed = touch.depth > 0;
        if (now.pressed) now.face = limited(touch.deformation);
        now.vein_wall.outside = touch.pressure;
        flow.vein_opening = now.vein_wall.opening();
        now.dragged = std::fabs(held.drag) > 1_um && held.inserted > 2_mm && !held.held;
        if (now.dragged) now.drag = {.entry = held.entry, .tip = held.tip(), .drag = held.drag};
        body.place(gel_id, at);
        if (now == motion && settled_) return;
        body.deform(policy, keep_contact(now, now.face), soft_);
        motion = now;
        settled_ = true;
    }

  private:
    static scene without_tools(const scene& anatomy) {
        scene body{anatomy.find("gel") ? tissue::air : anatomy.background()};
        for (const object& one : anatomy.objects())
            if (one.name != "needle" && one.name != "gel") body.add(one.surface, one.inside, one);
        return body.build(exec::par);
    }

    // Tissue that is pressed deeper than `decay` would fold over: the face is deeper in it than that only where a tracker puts
    // it there. Beyond the edge of a body there is no skin: there the depth of
    // the face ends on a slope.
    static pressed_face limited(pressed_face face) {
        constexpr float max_depth = 0.75F * decay;
        face.decay = decay;
        for (std::array<float, pressed_face::columns>& row : face.depth)
            for (float& depth : row) depth = std::min(depth, max_depth);
        const float step = 1.2F * (face.right - face.left) / (pressed_face::columns - 1),
                    step_along = 1.2F * face.elevation / (pressed_face::rows - 1);
        for (std::size_t pass = 0; pass < 2; ++pass)
            for (std::size_t k = 0; k < pressed_face::rows; ++k)
                for (std::size_t i = 0; i < pressed_face::columns; ++i) {
                    const std::size_t x = pass == 0 ? i : pressed_face::columns - 1 - i,
                                      y = pass == 0 ? k : pressed_face::rows - 1 - k;
                    const std::size_t before = pass == 0 ? x - 1 : x + 1, above = pass == 0 ? y - 1 : y + 1;
                    float& depth = face.depth[y][x];
                    if (before < pressed_face::columns) depth = std::min(depth, face.depth[y][before] + step);
                    if (above < pressed_face::rows) depth = std::min(depth, face.depth[above][x] + step_along);
                }
        return face;
    }

    // How deep the face is in the body at rest, at the middle and the ends.
    float deepest(const pose& at, float width) const {
        float depth = -1;
        for (const float share : {-0.5F, -0.25F, 0.0F, 0.25F, 0.5F}) {
            const vec3 point = at.point({share * width, 0, 0});
            depth = std::max(depth, point.z - skin_at({point.x, point.y}));
        }
        return depth;
    }

    scene at_rest_;
    std::vector<object_id> soft_{};
    presser press_{};
    bool settled_ = false;
};

} // namespace live

#endif
