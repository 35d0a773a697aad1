#ifndef INSONIFY_CHANNELS_TISSUE_MAPS_HPP
#define INSONIFY_CHANNELS_TISSUE_MAPS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/queries.hpp>
#include <insonify/scene/scene.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Pixels in the slice plane of an array, at equal steps. Pixel (column, row) is at
/// x = from.x + column * spacing, z = from.y + row * spacing.
struct map_grid {
    vec2 from{-20e-3F, 0};   ///< x and z of the first pixel in the frame of the probe, metres
    float spacing = 0.2e-3F; ///< metres
    uvec2 size{200, 200};    ///< columns and rows

    /// In the frame of the probe.
    vec3 at(std::uint32_t column, std::uint32_t row) const {
        return {from.x + static_cast<float>(column) * spacing, 0, from.y + static_cast<float>(row) * spacing};
    }
    /// Of pixels.
    std::size_t count() const { return std::size_t{size.x} * size.y; }

    friend bool operator==(const map_grid&, const map_grid&) = default;
};

/// Strain of tissue in the slice, relative to its size at rest: 0.01 is 1 % longer.
struct slice_strain {
    float lateral = 0; ///< along x
    float axial = 0;   ///< along z
    float shear = 0;   ///< (du_x/dz + du_z/dx) / 2

    friend bool operator==(const slice_strain&, const slice_strain&) = default;
};

/// The truth behind channel data, pixel by pixel, row after row.
struct tissue_maps {
    map_grid grid{};                        ///< where the pixels are
    std::vector<float> sound_speed{};       ///< m/s
    std::vector<float> density{};           ///< kg/m^3
    std::vector<float> attenuation{};       ///< dB/m at 1 MHz, one way
    std::vector<float> attenuation_power{}; ///< exponent of the frequency
    std::vector<label_id> labels{};         ///< the object, or `background_label`
    std::vector<vec2> displacement{};       ///< of tissue from rest, x and z of the probe, metres
    std::vector<slice_strain> strain{};     ///< of tissue

    friend bool operator==(const tissue_maps&, const tissue_maps&) = default;
};

/// What lies at each pixel of the slice plane of an array.
///
///     const tissue_maps truth = map_tissue(exec::par_unseq, body, at, {.from = {-19_mm, 0}, .size = {190, 200}});
///
/// Displacement and strain are those of `scene::deform`, of tissue that is now at the pixel; 0 where nothing is
/// deformed.
/// @param at  probe to world
/// @throws usage_error     for a scene that was not built, or a grid that is empty or has more than 2^26 pixels
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy>
tissue_maps map_tissue(const Policy& policy, const scene& body, const pose& at, const map_grid& grid) {
    const std::size_t count = grid.count();
    if (count == 0 || count > std::size_t{1} << 26U)
        throw usage_error{"map_tissue: the grid has no pixels, or more than 2^26; set `size` to columns and rows"};
    check_length(grid.spacing, "spacing", max_scan_depth, "map_tissue");
    if (!is_finite(grid.from.x) || !is_finite(grid.from.y)) throw usage_error{"map_tissue: `from` is not finite"};
    detail::check_rigid(at, "map_tissue");
    const detail::any_policy<false> any{policy};
    const scene_view seen = body.view_for_rays(any);
    std::vector<float> nodes;
    std::vector<displacement_view> places;
    constexpr float thickness = 1e-3F; // of the lattice, whose two layers lie on both sides of the slice, metres
    const detail::displacement_lattice lattice{
        .at = {at.rotation, at.point(grid.at(0, 0) - vec3{0, 0.5F * thickness, 0})},
        .spacing = {grid.spacing, thickness, grid.spacing},
        .size = {std::max(grid.size.x, 2U), 2, std::max(grid.size.y, 2U)}};
    const view<const displacement_view> displaced = body.displacements(any, lattice, nodes, places);

    tissue_maps maps{.grid = grid};
    maps.sound_speed.resize(count);
    maps.density.resize(count);
    maps.attenuation.resize(count);
    maps.attenuation_power.resize(count);
    maps.labels.resize(count);
    maps.displacement.resize(count);
    maps.strain.resize(count);
    exec::for_each_block(
        any, grid.size.y, 1, 1e3F * static_cast<float>(grid.size.x), [&](std::size_t row, std::size_t) {
            for (std::uint32_t column = 0; column < grid.size.x; ++column) {
                const std::size_t i = row * grid.size.x + column;
                const vec3 p = at.point(grid.at(column, static_cast<std::uint32_t>(row)));
                const object_view* const one = detail::top_at(seen, p);
                const medium& m = seen.media[one == nullptr ? 0 : one->medium];
                maps.sound_speed[i] = m.sound_speed;
                maps.density[i] = m.density;
                maps.attenuation[i] = m.attenuation;
                maps.attenuation_power[i] = m.attenuation_power;
                maps.labels[i] = one == nullptr ? background_label : one->id;
                const std::size_t place = one == nullptr ? 0 : 1 + static_cast<std::size_t>(one - seen.objects.data());
                if (place >= displaced.size() || displaced[place].nodes.empty()) continue;
                const pose of_object = one == nullptr ? pose{} : one->at;
                const vec3 local = of_object.local_point(p);
                const vec3 moved = at.local_direction(of_object.direction(local - displaced[place].rest(local)));
                maps.displacement[i] = {moved.x, moved.z};
                // From the gradient of rest by now to that of now by rest, in axes of the probe.
                const mat3 to_object = transpose(of_object.rotation) * at.rotation;
                const mat3 stretch = inverse(transpose(to_object) * displaced[place].gradient(local) * to_object);
                maps.strain[i] = {stretch[0][0] - 1, stretch[2][2] - 1, 0.5F * (stretch[2][0] + stretch[0][2])};
            }
        });
    return maps;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
