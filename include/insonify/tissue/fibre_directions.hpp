#ifndef INSONIFY_TISSUE_FIBRE_DIRECTIONS_HPP
#define INSONIFY_TISSUE_FIBRE_DIRECTIONS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <concepts>
#include <memory>
#include <type_traits>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// The direction of the fibres of an object, in its coordinates and of any length: one for all, or a function of the point.
///
///     body.add(surface, tissue::muscle, {.fibres = {1, 0, 0}});
///     body.add(surface, tissue::muscle, {.fibres = [](vec3 p) { return vec3{1, 0, 4 * p.x}; }});
class fibre_directions {
  public:
    fibre_directions() = default;                   ///< none: the axis of the mesh
    fibre_directions(vec3 along) : along_{along} {} ///< one for all; 0: the axis of the mesh
    /// The same by its components.
    template <class X, class Y, class Z>
    fibre_directions(X x, Y y, Z z) : along_{x, y, z} {}
    /// A function of the point, metres. It must be continuous, and defined in the whole box around the object.
    template <class Function>
        requires std::is_invocable_r_v<vec3, const Function&, vec3> fibre_directions(Function function)
            : own_{std::make_shared<const Function>(std::move(function))}, call_{[](const void* own,
                                                                                    vec3 point) -> vec3 {
                  return (*static_cast<const Function*>(own))(point);
              }} {}

        /// Whether it is a function.
        bool varies() const { return call_ != nullptr; }
        /// At a point, in coordinates of the object.
        vec3 operator()(vec3 point) const { return varies() ? call_(own_.get(), point) : along_; }

      private:
        vec3 along_{0, 0, 0};
        std::shared_ptr<const void> own_{};
        vec3 (*call_)(const void*, vec3) = nullptr;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
