#ifndef INSONIFY_SCENE_COMPOSE_HPP
#define INSONIFY_SCENE_COMPOSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/inverse_map.hpp>
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

/// The map that applies several maps, from the first to the last.
///
///     body.deform(exec::par, compose(pulsation{.time = t}, breathing{.time = t}));
///
/// @{
template <deformation_map First, deformation_map Then>
composed<First, Then> compose(First first, Then then) {
    return {std::move(first), std::move(then)};
}
template <deformation_map First, deformation_map Second, deformation_map... Others>
auto compose(First first, Second second, Others... others) {
    return compose(compose(std::move(first), std::move(second)), std::move(others)...);
}
/// @}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
