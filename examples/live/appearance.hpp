#ifndef INSONIFY_EXAMPLES_LIVE_APPEARANCE_HPP
#define INSONIFY_EXAMPLES_LIVE_APPEARANCE_HPP

#include <insonify/insonify.hpp>
#include "probe.hpp"
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace live {

using namespace insonify;

/// Whether an object is shown by itself in a 3-D view, and not as a part of the anatomy.
inline bool is_tool(const object& one) { return one.name == "needle" || one.name == "gel"; }

/// The anatomy's bounds in the world, without needle and gel.
inline aabb anatomy_box(const scene& body) {
    aabb whole;
    for (const object& one : body.objects())
        if (!is_tool(one)) whole = merged(whole, body.box(one.id));
    return whole;
}

/// The head of a probe in a 3-D view, in coordinates of the probe: its face is just above the skin.
inline mesh make_probe_body(const array_probe& probe) {
    return make_along_face(probe, 0.5F * probe.face_width() + 2_mm, 0.5F * probe.elevation_height + 1.5_mm, -18_mm,
                           -0.5_mm);
}

/// The edge of the last picture in the world: along the face from left to right, and back at its depth.
inline std::vector<vec3> field_of_view(const scanner<array_probe>& machine) {
    const array_probe& probe = machine.probe;
    const int steps = probe.kind == array_probe::shape::linear ? 1 : 24;
    std::vector<vec3> edge;
    for (int i = 0; i <= 2 * steps + 1; ++i) {
        const int step = i <= steps ? i : 2 * steps + 1 - i;
        const float part = static_cast<float>(step) / static_cast<float>(steps);
        edge.push_back(machine.at().point(
            probe.beam(part * static_cast<float>(probe.lines) - 0.5F).at(i <= steps ? 0 : machine.settings.depth)));
    }
    return edge;
}

/// Whether a pixel of the last picture is within it, and not beside a sector.
inline bool is_seen(const scanner<array_probe>& machine, std::size_t pixel) {
    const std::vector<std::uint32_t>& first = machine.map().first;
    return pixel >= first.size() || first[pixel] != scan_map::outside;
}

namespace detail {

// Whether most of an object is inside another one, which is in a scene alone.
inline bool encloses(const scene& outer, const object& inner) {
    constexpr std::size_t samples = 9;
    constexpr vec3 up{0, 0, -1};
    const std::vector<vec3>& points = inner.surface.positions;
    std::size_t inside = 0;
    for (std::size_t i = 0; i < samples && !points.empty(); ++i) {
        const vec3 from = inner.at.point(points[i * (points.size() - 1) / (samples - 1)]);
        const std::optional<surface_point> left = first_surface(outer, {.origin = from, .direction = up});
        if (left && dot(left->normal, up) > 0) ++inside;
    }
    return 2 * inside > samples;
}

} // namespace detail

/// The opacities of all objects in a 3-D view, 0 to 1, in the order of `body.objects()`.
///
/// Transparent is what encloses others and is at least half as large as the body in two directions, such as skin: along a line
/// of sight, such surfaces together hide about a third of what is behind them. All else is opaque.
inline std::vector<float> opacities(const scene& body) {
    constexpr float seen_through = 0.65F;
    const auto& all = body.objects();
    const vec3 whole = anatomy_box(body).size();
    const auto is_large = [&](const object& one) {
        const vec3 size = body.box(one.id).size();
        return (size.x >= 0.5F * whole.x) + (size.y >= 0.5F * whole.y) + (size.z >= 0.5F * whole.z) >= 2;
    };
    std::vector<std::vector<std::size_t>> inner(all.size()); // what each large object encloses
    std::vector<std::size_t> around(all.size(), 0);          // how many of those enclose it
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (is_tool(all[i]) || !is_large(all[i])) continue;
        scene alone;
        alone.add(all[i].surface, all[i].inside, {.at = all[i].at});
        alone.build(exec::par);
        for (std::size_t k = 0; k < all.size(); ++k)
            if (i != k && !is_tool(all[k]) && detail::encloses(alone, all[k])) {
                inner[i].push_back(k);
                ++around[k];
            }
    }
    std::vector<float> opacity(all.size(), 1);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (inner[i].empty()) continue;
        std::size_t nested = around[i] + 1; // transparent surfaces on the way to the innermost
        for (const std::size_t k : inner[i])
            if (!inner[k].empty()) nested = std::max(nested, around[k] + 1);
        opacity[i] = 1 - std::pow(seen_through, 1 / static_cast<float>(nested));
    }
    return opacity;
}

/// Whether an object is cut at the plane of the picture in a 3-D view, because what lies before it would hide it: all but
/// what is as thin and round as vessels, nerves and tendons are.
inline bool is_cut(const object& one) {
    constexpr double thickest = 1e-4; // m^2, of the mean section, and at most 1 / 25 of the square of the longest side
    constexpr double flattest = 30;   // area^2 / (volume * longest side): 4 pi of a long cylinder, far more of a sheet
    aabb box;
    for (const vec3& point : one.surface.positions) box = merged(box, point);
    double area = 0;
    const mesh_view faces{one.surface};
    for (std::size_t i = 0; i < faces.size(); ++i) area += static_cast<double>(length(area_vector(faces[i]))) / 2;
    const vec3 size = box.size();
    const double volume = enclosed_volume(faces), longest = static_cast<double>(max(size.x, max(size.y, size.z)));
    return volume > longest * std::min(thickest, longest * longest / 25) || area * area > flattest * volume * longest;
}

} // namespace live

#endif
