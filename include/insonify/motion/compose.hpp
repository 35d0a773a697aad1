#ifndef INSONIFY_MOTION_COMPOSE_HPP
#define INSONIFY_MOTION_COMPOSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/motion/press.hpp>
#include <type_traits>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// Two maps for `scene::deform`, one after the other: see `compose`.
template <deformation_map First, deformation_map Then>
struct composed {
    First first{}; ///< from rest
    Then then{};   ///< of what the first one gives

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const { return then(first(rest)); }
    /// The inverse.
    vec3 rest_of(vec3 now) const requires invertible_map<First> && invertible_map<Then> {
        return first.rest_of(then.rest_of(now));
    }

    /// @throws usage_error, geometry_error  as the two maps
    void check() const {
        if constexpr (requires { first.check(); }) first.check();
        if constexpr (requires { then.check(); }) then.check();
    }
};

/// Returns the tissue that a face touches to the face, from where other maps take it along z of the probe: made by
/// `keep_contact`. Displacements decrease away from the face as those of `pressed_face` do.
class kept_contact {
  public:
    kept_contact() = default;
    /// @param map   all maps that deform the body, with the one of the face
    /// @param face  without it
    template <deformation_map Map>
    kept_contact(const Map& map, const pressed_face& face) : back_{face} {
        // Wider than the face: skin is straight between its vertices, of which some lie beside the face.
        constexpr float margin = 3e-3F;
        back_.left -= margin;
        back_.right += margin;
        back_.depth = {};
        float moved[pressed_face::rows][pressed_face::columns];
        bool touches[pressed_face::rows][pressed_face::columns], away = false;
        for (std::size_t k = 0; k < pressed_face::rows; ++k)
            for (std::size_t i = 0; i < pressed_face::columns; ++i) {
                const vec2 place = back_.place(k, i), on_face{clamp(place.x, face.left, face.right), place.y};
                back_.height[i] = face.surface_at(place);
                touches[k][i] = face.depth_at(on_face) > 0;
                if (!touches[k][i]) continue;
                const float largest = 0.9F * face.decay;
                moved[k][i] = clamp(distance_from_face(map, face, on_face), -largest, largest);
                away = away || std::fabs(moved[k][i]) > 1e-7F;
            }
        if (!away) return;
        // Displacements recover beside the part of the face that touches.
        for (std::size_t k = 0; k < pressed_face::rows; ++k)
            for (std::size_t i = 0; i < pressed_face::columns; ++i) {
                float nearest = FLT_MAX;
                for (std::size_t row = 0; row < pressed_face::rows; ++row)
                    for (std::size_t column = 0; column < pressed_face::columns; ++column) {
                        const float distance = length(back_.place(k, i) - back_.place(row, column));
                        if (!touches[row][column] || !(distance < nearest)) continue;
                        nearest = distance;
                        back_.depth[k][i] = moved[row][column] * detail::beside_face(distance, face.recovery);
                    }
            }
    }

    /// Where a point is that all other maps have moved.
    vec3 operator()(vec3 moved) const { return back_(moved); }
    /// The inverse.
    vec3 rest_of(vec3 now) const { return back_.rest_of(now); }

    friend bool operator==(const kept_contact&, const kept_contact&) = default;

  private:
    // How far tissue that comes to lie at a place of the face is in front of it, metres along z.
    template <deformation_map Map>
    static float distance_from_face(const Map& map, const pressed_face& face, vec2 place) {
        vec2 from = place; // where that tissue is at rest
        vec3 now{0, 0, 0};
        for (int i = 0; i < 4; ++i) {
            now = face.at.local_point(map(face.at.point({from, face.surface_at(from) - face.depth_at(from)})));
            from += place - vec2{now.x, now.y};
        }
        return face.surface_at(place) - now.z;
    }

    pressed_face back_{}; // its depths are those by which skin is in front of the face; below 0: behind it
};

/// A map that contains a pressed face, followed by what keeps the skin that the face touches on it, whatever the rest
/// of the map does there. `compose` does this by itself; it is needed for a map of your own:
///
///     body.deform(exec::par, keep_contact([&](vec3 rest) { return drag(touch.deformation(rest)); }, touch.deformation));
///
/// @param face  of `press`: where its depth is 0, it does not touch
template <deformation_map Map>
composed<Map, kept_contact> keep_contact(Map map, const pressed_face& face) {
    kept_contact keeper{map, face};
    return {std::move(map), keeper};
}

namespace detail {

/// Whether a map contains the face of a probe.
template <class Map>
inline constexpr bool has_face_v = std::is_same_v<Map, pressed_face> || std::is_same_v<Map, indentation>;
template <class First, class Then>
inline constexpr bool has_face_v<composed<First, Then>> = has_face_v<First> || has_face_v<Then>;

/// The last face of a map that contains one.
inline const pressed_face& face_of(const pressed_face& map) { return map; }
inline pressed_face face_of(const indentation& map) {
    pressed_face same{.at = map.at,
                      .left = -0.5F * map.face.x,
                      .right = 0.5F * map.face.x,
                      .elevation = map.face.y,
                      .decay = map.decay,
                      .recovery = map.recovery};
    for (std::array<float, pressed_face::columns>& row : same.depth) row.fill(map.depth);
    return same;
}
template <class First, class Then>
pressed_face face_of(const composed<First, Then>& map) {
    if constexpr (has_face_v<Then>)
        return face_of(map.then);
    else
        return face_of(map.first);
}

template <class First, class Then, class... Others>
auto in_order(First first, Then then, Others... others) {
    composed<First, Then> both{std::move(first), std::move(then)};
    if constexpr (sizeof...(Others) == 0)
        return both;
    else
        return in_order(std::move(both), std::move(others)...);
}

} // namespace detail

/// The map that applies several maps, from the first to the last.
///
///     body.deform(exec::par, compose(pulsation{.time = t}, breathing{.time = t}));
///
/// What the face of a probe touches (`pressed_face`, `indentation`) stays in touch with it, wherever the face is in the
/// list: see `keep_contact`.
template <deformation_map First, deformation_map Second, deformation_map... Others>
auto compose(First first, Second second, Others... others) {
    auto all = detail::in_order(std::move(first), std::move(second), std::move(others)...);
    if constexpr (detail::has_face_v<decltype(all)>)
        return keep_contact(all, detail::face_of(all));
    else
        return all;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
