#ifndef INSONIFY_MOTION_COMPOSE_HPP
#define INSONIFY_MOTION_COMPOSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/motion/keep_contact.hpp>
#include <type_traits>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

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

template <class First, class Then>
composed<First, Then> in_order(First first, Then then) {
    return {std::move(first), std::move(then)};
}
template <class First, class Second, class... Others>
auto in_order(First first, Second second, Others... others) requires(sizeof...(Others) > 0) {
    return in_order(in_order(std::move(first), std::move(second)), std::move(others)...);
}

} // namespace detail

/// The map that applies several maps, from the first to the last.
///
///     body.deform(exec::par, compose(pulsation{.time = t}, breathing{.time = t}));
///
/// What the face of a probe touches (`pressed_face`, `indentation`) stays in touch with it, wherever the face is in the list: see
/// `keep_contact`.
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
