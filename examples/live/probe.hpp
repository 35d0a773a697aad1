#ifndef INSONIFY_EXAMPLES_LIVE_PROBE_HPP
#define INSONIFY_EXAMPLES_LIVE_PROBE_HPP

#include <insonify/insonify.hpp>
#include <cmath>
#include <cstdint>

namespace live {

using namespace insonify;

/// A linear, convex or phased array: one type for all probes of a session, which may change while it runs. A `transducer`, whose
/// lines are those of the array of the library.
struct array_probe {
    enum class shape : std::uint32_t { linear, convex, phased };

    shape kind = shape::linear;
    float width = 38_mm;           ///< of the face of a linear or phased array, metres
    float radius = 60_mm;          ///< of the face of a convex array, metres
    float field_of_view = 60_deg;  ///< of a convex or phased array, radians
    std::uint32_t lines = 192;     ///< this and the members below: see `linear_array`
    float frequency = 7.5_MHz;     ///< hertz
    float fnumber = 2;             ///<
    float focus = 0;               ///< metres; 0: half the depth of the image
    float elevation_height = 5_mm; ///< metres
    float elevation_focus = 20_mm; ///< metres
    float bandwidth = 0.644F;      ///< fractional
    float side_lobes = 0;          ///< amplitude

    array_probe() = default;
    array_probe(const linear_array& array) : array_probe{shape::linear, array} { width = array.width; }
    array_probe(const convex_array& array) : array_probe{shape::convex, array} {
        radius = array.radius;
        field_of_view = array.field_of_view;
    }
    array_probe(const phased_array& array) : array_probe{shape::phased, array} {
        width = array.width;
        field_of_view = array.field_of_view;
    }

    /// Calls `call` with the array of the library that it is.
    template <class Call>
    auto as_array(const Call& call) const {
        if (kind == shape::convex) {
            auto array = with_settings(convex_array{});
            array.radius = radius;
            array.field_of_view = field_of_view;
            return call(array);
        }
        if (kind == shape::phased) {
            auto array = with_settings(phased_array{});
            array.width = width;
            array.field_of_view = field_of_view;
            return call(array);
        }
        auto array = with_settings(linear_array{});
        array.width = width;
        return call(array);
    }

    /// See `transducer`. @{
    ray beam(float line) const {
        return as_array([&](const auto& array) { return array.beam(line); });
    }
    vec2 locate(vec2 point) const {
        return as_array([&](const auto& array) { return array.locate(point); });
    }
    float aperture() const {
        return as_array([](const auto& array) { return array.aperture(); });
    }
    void check() const {
        as_array([](const auto& array) { array.check(); });
    }
    /// @}

    /// From end to end of the face, metres.
    float face_width() const { return kind == shape::convex ? 2 * radius * std::sin(0.5F * field_of_view) : width; }
    /// z of the face at an x within it, metres.
    float face_at(float x) const {
        return kind == shape::convex ? std::sqrt(std::fmax(radius * radius - x * x, 0.0F)) - radius : 0;
    }

    friend bool operator==(const array_probe&, const array_probe&) = default;

  private:
    template <class Array>
    array_probe(shape of, const Array& array)
        : kind{of}, lines{array.lines}, frequency{array.frequency}, fnumber{array.fnumber}, focus{array.focus},
          elevation_height{array.elevation_height}, elevation_focus{array.elevation_focus}, bandwidth{array.bandwidth},
          side_lobes{array.side_lobes} {}
    template <class Array>
    Array with_settings(Array array) const {
        array.lines = lines;
        array.frequency = frequency;
        array.fnumber = fnumber;
        array.focus = focus;
        array.elevation_height = elevation_height;
        array.elevation_focus = elevation_focus;
        array.bandwidth = bandwidth;
        array.side_lobes = side_lobes;
        return array;
    }
};

/// A closed shell along the face of a probe, such as a film of gel on it: a mesh in coordinates of the probe.
/// @param half_width, half_height  along x and y, metres
/// @param from, to                 along z from the face at the same x: z of a flat one, metres
inline mesh make_along_face(const array_probe& probe, float half_width, float half_height, float from, float to) {
    constexpr std::uint32_t columns = 25;
    const std::uint32_t last = probe.kind == array_probe::shape::convex ? columns - 1 : 1;
    const float half_face = 0.5F * probe.face_width();
    mesh shell;
    for (std::uint32_t i = 0; i <= last; ++i) {
        const float x = half_width * (2 * static_cast<float>(i) / static_cast<float>(last) - 1),
                    face = probe.face_at(clamp(x, -half_face, half_face));
        for (const float z : {from, to})
            for (const float side : {-1.0F, 1.0F}) shell.positions.push_back({x, side * half_height, face + z});
    }
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        shell.faces.insert(shell.faces.end(), {{a, b, c}, {a, c, d}});
    };
    // Of a column: 0 and 1 at `from`, 2 and 3 at `to`; 0 and 2 towards -y.
    quad(0, 2, 3, 1);
    for (std::uint32_t i = 0; i < last; ++i) {
        const std::uint32_t a = 4 * i, b = a + 4;
        quad(a, a + 1, b + 1, b);
        quad(a + 2, b + 2, b + 3, a + 3);
        quad(a, b, b + 2, a + 2);
        quad(a + 1, a + 3, b + 3, b + 1);
    }
    const std::uint32_t end = 4 * last;
    quad(end, end + 1, end + 3, end + 2);
    return shell;
}

} // namespace live

#endif
