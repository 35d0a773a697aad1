#ifndef INSONIFY_TESTS_TRACING_SOLIDS_HPP
#define INSONIFY_TESTS_TRACING_SOLIDS_HPP

#include <insonify/core/math.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include <algorithm>
#include <vector>

/// Spheres and boxes as formulas in double precision, and as a scene of the library's: which of them a point lies in is
/// decided without rays, meshes or trees.
namespace solids {

using insonify::dvec3;

struct solid {
    bool round = false;
    dvec3 lower{}; // of a box; of a sphere, its centre
    dvec3 upper{};
    double radius = 0;
    insonify::medium inside{};
    insonify::object_settings settings{};

    bool contains(dvec3 world) const {
        const dvec3 p = glm::transpose(glm::dmat3{settings.at.rotation}) * (world - dvec3{settings.at.translation});
        if (round) return glm::length(p - lower) < radius;
        return glm::all(glm::lessThan(lower, p)) && glm::all(glm::lessThan(p, upper));
    }
    double volume() const {
        const dvec3 size = upper - lower;
        return round ? 4.18879020478639 * radius * radius * radius : size.x * size.y * size.z;
    }
    insonify::mesh surface() const {
        return round ? insonify::make_sphere(insonify::vec3{lower}, static_cast<float>(radius), 6)
                     : insonify::make_box(insonify::vec3{lower}, insonify::vec3{upper}, 1);
    }
};

inline solid sphere(dvec3 centre, double radius, const insonify::medium& inside,
                    const insonify::object_settings& settings = {}) {
    return {.round = true, .lower = centre, .radius = radius, .inside = inside, .settings = settings};
}
inline solid box(dvec3 lower, dvec3 upper, const insonify::medium& inside,
                 const insonify::object_settings& settings = {}) {
    return {.lower = lower, .upper = upper, .inside = inside, .settings = settings};
}

struct world {
    insonify::medium background{};
    std::vector<solid> all{};

    static constexpr std::uint32_t none = ~0U;

    /// Number of the solid that gives the medium at a point: of highest priority, then smallest, then last added.
    std::uint32_t at(dvec3 point) const {
        std::uint32_t best = none;
        for (std::uint32_t i = 0; i < all.size(); ++i) {
            if (!all[i].contains(point)) continue;
            const bool better =
                best == none || all[i].settings.priority > all[best].settings.priority ||
                (all[i].settings.priority == all[best].settings.priority && all[i].volume() <= all[best].volume());
            if (better) best = i;
        }
        return best;
    }
    const insonify::medium& medium_of(std::uint32_t solid) const {
        return solid == none ? background : all[solid].inside;
    }

    /// Solid i gets the id i.
    insonify::scene scene() const {
        insonify::scene body{background};
        for (const solid& one : all) body.add(one.surface(), one.inside, one.settings);
        body.build(insonify::exec::par);
        return body;
    }
};

/// One line, step by step of a micrometre: number i stands at i micrometres along the line.
struct walk {
    static constexpr double step = 1e-6;
    std::vector<std::uint32_t> solid{};
    std::vector<double> displayed{}; ///< metres
    std::vector<double> lost{};      ///< dB of an echo to attenuation alone, there and back

    walk(const world& body, const insonify::ray& beam, double until, double megahertz) {
        const dvec3 origin{beam.origin}, direction{beam.direction};
        double shown = 0, decibels = 0;
        for (std::size_t i = 0; shown < until || static_cast<double>(i) * step < until; ++i) {
            solid.push_back(body.at(origin + (static_cast<double>(i) + 0.5) * step * direction));
            displayed.push_back(shown);
            lost.push_back(decibels);
            const insonify::medium& m = body.medium_of(solid.back());
            shown += step * 1540 / static_cast<double>(m.sound_speed);
            decibels += step * 2 * static_cast<double>(m.attenuation) *
                        std::pow(megahertz, static_cast<double>(m.attenuation_power));
        }
    }

    /// The step at a displayed depth.
    std::size_t at_displayed(double depth) const {
        return static_cast<std::size_t>(std::upper_bound(displayed.begin(), displayed.end(), depth) -
                                        displayed.begin()) -
               1;
    }
    static std::size_t at_geometric(double depth) { return static_cast<std::size_t>(depth / step); }

    /// A surface lies within so many steps: there meshes, which cut their spheres' corners, and formulas may differ.
    bool in_doubt(std::size_t i, std::size_t steps) const {
        for (std::size_t j = i > steps ? i - steps : 0; j <= i + steps && j < solid.size(); ++j)
            if (solid[j] != solid[i]) return true;
        return false;
    }
};

} // namespace solids

#endif
