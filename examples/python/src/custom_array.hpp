#ifndef INSONIFY_PYTHON_CUSTOM_ARRAY_HPP
#define INSONIFY_PYTHON_CUSTOM_ARRAY_HPP

#include "bindings.hpp"
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace insonify_python {

/// An `element_transducer` as data: where its elements are.
struct custom_element_array {
    std::uint32_t elements = 0;
    std::vector<vec3> positions{};  ///< centres, from left to right
    std::vector<vec3> directions{}; ///< normals; empty: all along z
    float element_width = element_array{}.element_width;
    float frequency = element_array{}.frequency;
    float height = element_array{}.height;
    float elevation_focus = element_array{}.elevation_focus;
    float bandwidth = element_array{}.bandwidth;
    float sound_speed = element_array{}.sound_speed;
    float fnumber = element_array{}.fnumber;

    ray element(std::uint32_t i) const {
        return {.origin = positions[i], .direction = directions.empty() ? vec3{0, 0, 1} : directions[i]};
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        const std::string owner = "custom_element_array: ";
        if (positions.empty())
            throw usage_error{owner + "there are no elements; state `positions`, an array of N x 3, metres"};
        if (!directions.empty() && directions.size() != positions.size())
            throw usage_error{owner + "`directions` are " + std::to_string(directions.size()) +
                              ", but `positions` are " + std::to_string(positions.size()) +
                              "; state one for each, or none: all along z"};
        insonify::detail::check_elements(*this, element_width, "custom_element_array");
        for (std::uint32_t i = 0; i < elements; ++i) {
            if (!is_finite(positions[i]) || !is_finite(element(i).direction))
                throw usage_error{owner + "element " + std::to_string(i) +
                                  " is not finite; check `positions` and `directions`"};
            for (std::uint32_t k = 0; k < i; ++k)
                if (overlap(positions[i] - positions[k]))
                    throw usage_error{owner + "elements " + std::to_string(k) + " and " + std::to_string(i) +
                                      " overlap; move them apart, or lower `element_width` or `height`"};
        }
    }

    friend bool operator==(const custom_element_array&, const custom_element_array&) = default;

  private:
    // Of the faces of two elements that are so far apart.
    bool overlap(vec3 apart) const {
        constexpr float touching = 0.9999F; // of the rounding of positions
        return length(vec2{apart.x, apart.z}) < touching * element_width && std::fabs(apart.y) < touching * height;
    }
};
static_assert(element_transducer<custom_element_array>);

/// The argument `array` of functions.
inline argument array_argument() {
    return {"array",
            "an element_array, a convex_element_array or a custom_element_array, such as presets.l11_5v_elements",
            fits<element_array, convex_element_array, custom_element_array>};
}

} // namespace insonify_python
#endif
