#ifndef INSONIFY_EXAMPLES_LIVE_PATIENT_HPP
#define INSONIFY_EXAMPLES_LIVE_PATIENT_HPP

#include "../anatomy/region.hpp"
#include "hands.hpp"
#include "probe.hpp"
#include "vessel.hpp"
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace live {

using namespace insonify;

/// The body under the probe: it is pressed by the face, pulses with the heart, and is dragged along by the needle. A film of
/// gel moves with the probe; where the face is further from the skin than that, there is air.
class patient {
  public:
    static constexpr float gel_film = 3_mm;  ///< no more gel than that
    static constexpr float max_press = 9_mm; ///< of the face, as far as the hand holds it
    static constexpr float decay = 24_mm;    ///< see `indentation`
    /// Pressure of the contact over its mean depth, Pa/m: 3 mmHg a millimetre.
    static constexpr float hardness = 3_mmHg / 1_mm;
    /// The artery whose wall moves by as much as the pulse says; others move in proportion to their radius.
    static constexpr float radius_of_pulse = 3_mm;

    /// @param anatomy  built or not; objects named "needle" and "gel" are replaced. Around a body that brings gel there is
    ///                 air; another one keeps its background
    /// @param vessels  of the anatomy
    explicit patient(scene anatomy = scene{}, std::vector<vessel> vessels = {})
        : body{without_tools(anatomy)}, at_rest_{surfaces_of(body)}, vessels_{std::move(vessels)} {
        flow = ::anatomy::flow_of(body, vessels_, 0);
        for (const object& one : body.objects()) {
            is_stiff_.resize(static_cast<std::size_t>(one.id) + 1);
            is_stiff_.back() = ::anatomy::is_stiff(one.inside) ? 1 : 0;
            for (const uvec3& face : one.surface.faces)
                for (int i = 0; i < 3; ++i)
                    longest_edge_ = std::max(longest_edge_, length(one.surface.positions[face[i]] -
                                                                   one.surface.positions[face[(i + 1) % 3]]));
        }
    }

    scene body;
    object_id needle_id{}, gel_id{};
    tissue_motion motion{};                                 ///< of the last frame
    blood_flow flow{};                                      ///< of the last frame
    const contact& touch() const { return press_.touch(); } ///< of the last frame
    const std::vector<vessel>& vessels() const { return vessels_; }

    /// The needle and the gel, for a probe; builds the body.
    void renew_tools(const needle_state& held, const array_probe& probe) {
        for (const char* name : {"needle", "gel"})
            if (const std::optional<object_id> old = body.find(name)) body.remove(*old);
        needle_id =
            body.add(make_needle(needle_diameter(held.gauge), needle_length, {.bevel = held.bevel}), tissue::steel,
                     {.priority = 1000, .at = held.at(), .name = "needle", .crease_angle = 0.8F * held.bevel});
        gel_id = body.add(make_along_face(probe, 0.5F * probe.face_width() + 3_mm,
                                          0.5F * probe.elevation_height + 6.5_mm, -2_mm, gel_film),
                          tissue::gel, {.priority = -1000, .name = "gel"});
        body.build(exec::par);
    }
    static constexpr float needle_length = 80_mm;

    /// Depth of the skin at rest; that of the whole body's upper edge where there is none.
    float skin_at(vec2 place) const {
        const aabb box = at_rest_.box();
        return depth_of_skin(place).value_or(box.empty() ? 0 : box.lower.z);
    }
    aabb box() const { return at_rest_.box(); }

    /// The probe on the skin, at most `max_press` deep at any point of its face. Where it slides, it turns with the skin.
    pose probe_pose(const hand_state& hand, const array_probe& probe) const {
        const float reach = 0.5F * probe.face_width();
        constexpr float max_turn = 80_deg; // else it would look out of the body
        const vec2 turned = inclination_at(hand.from, reach) - inclination_at(hand.on_skin, reach);
        const float rock = clamp(hand.rock + turned.x, -max_turn, max_turn),
                    tilt = clamp(hand.tilt + turned.y, -max_turn, max_turn);
        const vec3 down{std::sin(rock), std::sin(tilt), std::cos(rock) * std::cos(tilt)};
        const vec3 from{hand.on_skin, skin_at(hand.on_skin) - hand.gel};
        pose at =
            hand.held ? *hand.held : look_at(from, from + down, {std::cos(hand.rotate), std::sin(hand.rotate), 0});
        at.translation.z -= std::max(deepest(at, probe) - max_press, 0.0F);
        return at;
    }

    /// Moves the tissue to where it is at a time, with the probe and the needle there.
    /// @param depth  of the picture, metres
    template <exec::policy Policy>
    void move(const Policy& policy, const array_probe& probe, const pose& at, float depth, const needle_state& held,
              float time, const pulsation& beat) {
        const contact& touch =
            press_.press(at_rest_, probe, at,
                         {.stiffness = hardness * probe.face_width() * probe.elevation_height,
                          .gel = gel_film,
                          .decay = decay,
                          .yields = true},
                         any_object{}, [&](object_id id) { return is_stiff_[static_cast<std::size_t>(id)] != 0; });
        tissue_motion now;
        now.seen = seen_by(probe, at, depth);
        now.pressed = touch.depth > 0;
        if (now.pressed) {
            constexpr float slope = 1.2F; // where the body ends, there is no skin, and the depth of the face falls off
            now.face = touch.deformation;
            now.face.depth = now.face.with_slope(now.face.depth, slope);
        }
        move_vessels(now, touch, probe, time, beat);
        now.dragged = std::fabs(held.drag) > 1_um && held.inserted > 2_mm && !held.held;
        if (now.dragged) now.drag = {.entry = held.entry, .tip = held.tip(), .drag = held.drag};
        body.place(gel_id, at);
        if (now == motion && settled_) return;
        moved_.clear();
        for (const object& one : at_rest_.objects())
            if (overlaps(at_rest_.box(one.id), now.seen)) moved_.push_back(one.id);
        body.deform(policy, keep_contact(now, now.face), moved_);
        motion = std::move(now);
        settled_ = true;
    }

  private:
    std::optional<float> depth_of_skin(vec2 place) const {
        const vec3 above{place, at_rest_.box().lower.z - 1_mm};
        const std::optional<surface_point> skin = first_surface(at_rest_, {.origin = above, .direction = {0, 0, 1}});
        return skin ? std::optional{skin->point.z} : std::nullopt;
    }
    // By how much the skin falls off along x and y, radians, over `reach` to both sides; nearer to the edge of the body what
    // it is there.
    vec2 inclination_at(vec2 place, float reach) const {
        const aabb box = at_rest_.box();
        for (int i = 0; i < 2; ++i) {
            const float inside = min(reach, 0.5F * box.size()[i]);
            place[i] = clamp(place[i], box.lower[i] + inside, box.upper[i] - inside);
        }
        const auto along = [&](vec2 step) {
            const std::optional<float> here = depth_of_skin(place), before = depth_of_skin(place - step),
                                       behind = depth_of_skin(place + step);
            const std::optional<float> from = before ? before : here, to = behind ? behind : here;
            const float length = reach * static_cast<float>(before.has_value() + behind.has_value());
            constexpr float steepest = 60_deg;
            return from && to && length > 0 ? clamp(std::atan((*to - *from) / length), -steepest, steepest) : 0.0F;
        };
        return {along({reach, 0}), along({0, reach})};
    }
    // Not built.
    static scene without_tools(const scene& anatomy) {
        scene kept{anatomy.find("gel") ? tissue::air : anatomy.background()};
        for (const object& one : anatomy.objects())
            if (one.name != "needle" && one.name != "gel") kept.add(one.surface, one.inside, one);
        return kept;
    }
    // Surfaces alone: fibres take most of the time to build.
    static scene surfaces_of(const scene& body) {
        scene bare;
        for (const object& one : body.objects()) bare.add(one.surface, one.inside, {.at = one.at, .name = one.name});
        return bare.build(exec::par);
    }

    // Sets how vessels move, and how their blood flows then.
    void move_vessels(tissue_motion& now, const contact& touch, const array_probe& probe, float time,
                      const pulsation& beat) {
        ::anatomy::contact_pressure under{.pressure = touch.pressure, .decay = decay};
        for (const float fraction : along_face) under.face.push_back(face_point(touch.deformation.at, probe, fraction));
        pulsation wall = beat;
        wall.radius = radius_of_pulse;
        wall.time = time;
        now.vessels = ::anatomy::motion_of(vessels_, wall, under);
        flow.set(vessels_, beat.rate, under);
    }

    // Where whatever the picture shows has its vertices.
    aabb seen_by(const array_probe& probe, const pose& at, float depth) const {
        const float aside = 0.5F * probe.elevation_height;
        aabb box;
        for (int i = 0; i <= 8; ++i) {
            const ray line = probe.beam(static_cast<float>(probe.lines) * static_cast<float>(i) / 8 - 0.5F);
            for (const vec3 end : {line.origin, line.at(depth)})
                for (const float y : {-aside, aside}) box = merged(box, at.point({end.x, y, end.z}));
        }
        const float margin = longest_edge_ + 5_mm; // which tissue moves
        return {box.lower - margin, box.upper + margin};
    }

    static constexpr float along_face[] = {-0.5F, -0.25F, 0, 0.25F, 0.5F}; // of its width
    static vec3 face_point(const pose& at, const array_probe& probe, float part) {
        const float x = part * probe.face_width();
        return at.point({x, 0, probe.face_at(x)});
    }

    // How deep the face is in the body at rest, along it.
    float deepest(const pose& at, const array_probe& probe) const {
        float depth = -1;
        for (const float part : along_face) {
            const vec3 point = face_point(at, probe, part);
            depth = std::max(depth, point.z - skin_at({point.x, point.y}));
        }
        return depth;
    }

    scene at_rest_;
    std::vector<vessel> vessels_;
    std::vector<std::uint8_t> is_stiff_{}; // objects, by id
    std::vector<object_id> moved_{};
    float longest_edge_ = 0; // of all triangles
    presser press_{};
    bool settled_ = false;
};

} // namespace live

#endif
