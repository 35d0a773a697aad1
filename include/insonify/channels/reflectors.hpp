#ifndef INSONIFY_CHANNELS_REFLECTORS_HPP
#define INSONIFY_CHANNELS_REFLECTORS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/channels/element_array.hpp>
#include <insonify/channels/element_field.hpp>
#include <insonify/core/random.hpp>
#include <insonify/probe/probe_lines.hpp>
#include <insonify/scene/queries.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// A point that scatters sound equally in all directions, in the world.
struct point_scatterer {
    vec3 position{0, 0, 0};      ///< metres
    float scattering_length = 0; ///< scattered pressure at 1 m over the incident one, metres; may be negative
};

namespace detail {

/// One thing that returns sound: a scatterer, or a short piece of a surface.
struct reflector {
    vec2 place{0, 0};      ///< in the slice, of the probe: x and z, metres
    float y = 0;           ///< out of the slice, metres
    bool surface = false;  ///< a piece of a surface
    bool tall = false;     ///< it is as high as the beam: all but points of one's own
    vec2 normal{0, 0};     ///< of a surface in the slice, towards the array, of length at most 1
    vec2 nearest{0, 0};    ///< direction of the nearest element from a surface
    spectral_value root{}; ///< the root of what it returns: its scattering length; for a surface times metres
    std::uint32_t before = 0, after = 0;               ///< media on the side of the array and behind a surface
    std::uint32_t object_before = 0, object_after = 0; ///< as in `layer`
    float roughness = -1;                              ///< of a surface, as in `layer`
};

/// Number of the element that is nearest to a point of the slice.
inline std::size_t nearest_element(view<const ray> places, vec2 p) {
    std::size_t low = 0, high = places.size() - 1;
    const auto right_of = [&](std::size_t i) { // of the normal of an element
        const ray& one = places[i];
        return (p.x - one.origin.x) * one.direction.z - (p.y - one.origin.z) * one.direction.x > 0;
    };
    while (high - low > 1) {
        const std::size_t middle = (low + high) / 2;
        (right_of(middle) ? low : high) = middle;
    }
    const auto distance = [&](std::size_t i) { return length(vec2{places[i].origin.x, places[i].origin.z} - p); };
    return distance(low) <= distance(high) ? low : high;
}

/// What `trace_channels` fills the slice with lines by: parallel, or from an apex behind a curved face. A probe.
struct slice_lines {
    std::uint32_t lines = 1;
    float frequency = 1e6F; ///< hertz
    float radius = 0;       ///< of the face, metres; 0: flat
    float extent = 1;       ///< from the first to the last line: metres, or radians
    float bandwidth = 0.644F;

    ray beam(float line) const {
        if (radius == 0) return {.origin = {aperture_fraction(line, lines) * extent, 0, 0}};
        return sector{lines, radius, extent}.beam(line);
    }
    vec2 locate(vec2 p) const {
        if (radius == 0) return {line_at_fraction(p.x / extent, lines), p.y};
        return sector{lines, radius, extent}.locate(p);
    }
    void check() const {}
    /// Width of tissue that a line stands for, metres.
    float width(float depth) const {
        return extent / static_cast<float>(lines) * (radius == 0 ? 1.0F : radius + depth);
    }
};

/// All sound passes: used where only scatterers are wanted.
struct transparent {
    INSONIFY_FN response operator()(const incidence&) const { return {}; }
};
struct lossless {
    INSONIFY_FN float operator()(const medium&, float) const { return 0; }
};

/// Keeps the scatterers that a model emits, with their distances along the line. Beyond `max_count` of all lines they
/// are only counted.
template <class Deferred = void>
struct scatterer_sink {
    struct one {
        float distance;
        vec2 amplitude;
    };
    std::vector<one>& found;
    float end;
    std::atomic<std::uint64_t>& count; // of all lines
    std::uint64_t max_count;

    float depth() const { return end; }
    void surface(float, float, vec2) const {}
    void curved_surface(const curved_echo&) const {}
    template <class Value>
    void rough_surface(float, float, vec2, vec3, const Value&) const {}
    void scatterers(const scatterer_echoes& run) const {
        if (count.fetch_add(run.count) + run.count > max_count) return;
        for (std::uint32_t i = 0; i < run.count; ++i) {
            const float part = static_cast<float>(i) / static_cast<float>(run.count);
            const float level = run.first_level + part * (run.last_level - run.first_level);
            if (const float at = run.depth + static_cast<float>(i) * run.step; at >= 0 && at < end)
                found.push_back({at, level * vec2{run.real[i], run.imaginary[i]}});
        }
    }
};

/// Finds what returns sound in the slice of an array.
template <class Model>
class reflector_search {
  public:
    /// @param node_step  of `spectral_value`, hertz
    /// @param depth    of the slice, metres
    /// @param opening  beyond the ends of the array, radians
    reflector_search(const scene& body, view<const ray> places, const pose& at, const Model& model, float frequency,
                     float bandwidth, float node_step, float depth, float opening)
        : body_{body}, places_{places}, at_{at}, model_{model}, depth_{depth}, step_of_nodes_{node_step} {
        const ray first = places[0], last = places[places.size() - 1];
        const float turn =
            std::atan2(last.direction.x, last.direction.z) - std::atan2(first.direction.x, first.direction.z);
        const float width = length(last.origin - first.origin), beside = depth * std::tan(opening);
        const float wavelength = display_speed / frequency;
        lines_.frequency = frequency;
        lines_.bandwidth = bandwidth;
        if (turn > 1e-3F) {
            lines_.radius = 0.5F * width / std::sin(0.5F * turn);
            lines_.extent = turn + 2 * beside / (lines_.radius + depth);
        } else {
            lines_.extent = width + 2 * beside + wavelength;
        }
        open_ = beside;
        const float widest = lines_.extent * (lines_.radius == 0 ? 1.0F : lines_.radius + depth);
        // Half a wavelength apart, lines resolve what any aperture does.
        lines_.lines = static_cast<std::uint32_t>(clamp(std::ceil(2 * widest / wavelength), 1, 1 << 16));
        step_ = wavelength / 4;
        incoherent_ = each_lane<spectral_value::nodes>(
            [&](int node) { return std::sqrt(std::sqrt(1 + spectral_value::steps(node) * node_step / frequency)); });
        probe_.assign(lines_);
        frame_ = frame_view{frame_lines{.lines = probe_.lines(), .at = at, .depth = depth, .max_depth = depth}};
        frame_.frequency = frequency;
        frame_.samples = 1;
        frame_.spacing = depth;
        frame_.pulse_sigma = axial_sigma(bandwidth, frequency);
        frame_.bandwidth = bandwidth;
    }

    /// Of the slice: its lines times wavelengths along them. The search takes some 100 ns for each.
    float size() const { return static_cast<float>(lines_.lines) * depth_ / (4 * step_); }

    /// The scatterers of the model's field, as they are in pictures.
    /// @param strength   scattering length of a scatterer of amplitude 1 that stands for an area of 1 m^2 of the plane
    ///                   across its line: see `speckle_strength`
    /// @param across     across(depth): see `elevation_field::tissue`, 1/m
    /// @param max_count  of scatterers
    /// @return           how many there are; more than `max_count`: they were not all kept
    template <class Policy, class Across>
    std::uint64_t add_speckle(const Policy& policy, float strength, float fnumber, float elevation_fnumber,
                              std::uint32_t frame_number, float height, const Across& across, std::uint64_t max_count,
                              std::vector<reflector>& found) {
        auto field = model_.with_boundary(transparent{}).with_attenuation(lossless{});
        field.timing = timing::uniform;
        field.shadow_floor_db = -FLT_MAX;
        field.min_ringing = 1;
        using field_model = decltype(field);
        // Lines closer than the field's covariance take scatterers of planes of their own.
        constexpr std::uint32_t max_planes = 64;
        std::uint32_t planes = 1;
        while (planes < max_planes && field.covariance(static_cast<float>(planes) * lines_.width(depth_), 0.0F) > 0.01F)
            ++planes;
        const std::vector<float> fnumbers{fnumber};
        frame_.aperture = {
            .fnumbers = fnumbers, .spacing = depth_, .elevation_fnumber = elevation_fnumber, .height = height};
        frame_.frame_number = frame_number;
        line_driver<vec2> driver;
        line_grid<vec2> grid{lines_.lines, 1, depth_};
        line_grid<vec2>* const sink = &grid;
        std::vector<std::vector<scatterer_sink<>::one>> of_line(lines_.lines);
        std::atomic<std::uint64_t> count{0};
        driver.emit_lines(policy, body_, probe_, frame_, field, straight_lines{.directions = 1}, 2e4F, {&sink, 1},
                          [&](std::size_t, const line_task& task, view<vec2>) {
                              traced_line line = task.line;
                              line.plane = task.number % planes;
                              static_cast<const field_model&>(field).emit(
                                  line, scatterer_sink<>{of_line[task.number], depth_, count, max_count});
                          });
        if (count > max_count) return count;
        std::size_t kept = found.size();
        for (const auto& own : of_line) kept += own.size();
        found.reserve(kept);
        for (std::uint32_t i = 0; i < lines_.lines; ++i) {
            const ray beam = lines_.beam(static_cast<float>(i));
            for (const auto& [distance, amplitude] : of_line[i]) {
                const vec3 p = beam.origin + distance * beam.direction;
                const float level = strength * std::sqrt(lines_.width(distance) * across(distance));
                found.push_back({.place = {p.x, p.z},
                                 .tall = true,
                                 .root = incoherent_ * spectral_value::everywhere(square_root(level * amplitude))});
            }
        }
        return count;
    }

    /// The surfaces that the slice cuts, in pieces of a quarter of a wavelength: Kirchhoff's integral, of which the
    /// part out of the slice is closed.
    /// @param field    of the elements out of the slice
    template <class Policy>
    void add_surfaces(const Policy& policy, const elevation_field& field, std::vector<reflector>& found) {
        layer_finder finder;
        finder.assign(probe_);
        finder.prepare(policy, body_, frame_, line_search::slices, false, 1, {.keep_all = true});
        const scene_view seen = body_.view_for_rays(policy);
        if (finder.slices() == nullptr) return;
        std::vector<cut_segment> segments;
        finder.slices()->segments().for_each_segment([&](const cut_segment& one) {
            if (!one.again) segments.push_back(one);
        });
        const pose upright = finder.fan().upright();
        constexpr std::size_t block = 16;
        std::vector<std::vector<reflector>> of_block((segments.size() + block - 1) / block);
        exec::for_each_in_blocks(policy, segments.size(), block, 2e4F, [&](std::size_t i) {
            add_segment(seen, field, segments[i], upright, of_block[i / block]);
        });
        std::size_t whole = found.size();
        for (const std::vector<reflector>& some : of_block) whole += some.size();
        found.reserve(whole);
        for (const std::vector<reflector>& some : of_block) found.insert(found.end(), some.begin(), some.end());
    }

  private:
    void add_segment(const scene_view& seen, const elevation_field& field, const cut_segment& segment,
                     const pose& upright, std::vector<reflector>& found) const {
        const vec3 from = upright.point({segment.from.x, 0, segment.from.y}),
                   to = upright.point({segment.to.x, 0, segment.to.y});
        const float size = length(to - from);
        if (!(size > 0) || !is_finite(size) || size > 100 * max(depth_, lines_.extent)) return;
        const auto pieces = static_cast<std::uint32_t>(std::ceil(size / step_));
        for (std::uint32_t i = 0; i < pieces; ++i) {
            const float part = (static_cast<float>(i) + 0.5F) / static_cast<float>(pieces);
            add_piece(seen, field, segment, from + part * (to - from), size / static_cast<float>(pieces), found);
        }
    }

    void add_piece(const scene_view& seen, const elevation_field& field, const cut_segment& segment, vec3 local,
                   float size, std::vector<reflector>& found) const {
        const object_view& owner = seen.objects[segment.object];
        const vec2 flat{local.x, local.z};
        const vec2 on_lines = lines_.locate(flat);
        if (!(on_lines.y > 0 && on_lines.y < depth_)) return;
        const float weight = taper(on_lines);
        if (!(weight > 0)) return;
        const ray& nearest = places_[nearest_element(places_, flat)];
        const vec3 apart = vec3{local.x, 0, local.z} - vec3{nearest.origin.x, 0, nearest.origin.z};
        const float distance = length(apart);
        if (!(distance > 1e-6F)) return;
        const vec3 world = at_.point(local);
        const line_frame line{at_.point({nearest.origin.x, 0, nearest.origin.z}), at_.direction(apart / distance),
                              at_.rotation[1]};
        const surface_incidence met = incidence_on(owner, segment.primitive, line, world);
        constexpr float clearance = 3e-6F; // metres: beyond what touches
        const object_view* const front = top_at(seen, world - clearance * met.flat);
        const object_view* const behind = top_at(seen, world + clearance * met.flat);
        const std::uint32_t before = front == nullptr ? 0 : front->medium,
                            after = behind == nullptr ? 0 : behind->medium;
        if (before == after) return;
        const object_view* const higher = front == nullptr    ? behind
                                          : behind == nullptr ? front
                                                              : std::min(front, behind); // the first by rank
        if (higher != &owner) return; // inside of another object, or where another's surface touches
        const vec3 bulge = at_.local_direction(bulge_of(owner, segment.primitive, world));
        const vec3 normal = at_.local_direction(-met.normal);
        const float own_roughness = seen.media[owner.medium].roughness;
        reflector one{.place = {local.x + bulge.x, local.z + bulge.z},
                      .surface = true,
                      .tall = true,
                      .normal = {normal.x, normal.z},
                      .nearest = -vec2{apart.x, apart.z} / distance,
                      .before = before,
                      .after = after,
                      .object_before = front == nullptr ? ~0U : front->id,
                      .object_after = behind == nullptr ? ~0U : behind->id,
                      .roughness = own_roughness > 0 ? own_roughness : -1};
        // (j k / 2 pi) r dl, of which `root` is the root; of r it has the sign, and each element the size.
        const float wave_number = 2 * pi * lines_.frequency / seen.media[before].sound_speed;
        constexpr float steepest = 5.8F; // 80 degrees
        const float reflected =
            model_.at_interface({seen.media[before], seen.media[after], met.cosine, lines_.frequency, one.roughness})
                .reflected;
        const float at_carrier = std::copysign(weight * size * wave_number / (2 * pi), reflected);
        const auto whole = spectral_value::each([&](int node) {
            return vec2{0, at_carrier * (1 + spectral_value::steps(node) * step_of_nodes_ / lines_.frequency)};
        });
        one.root = square_root(whole *
                               field.bent_surface(distance, -clamp(met.slope.y, -steepest, steepest), met.curvature.y));
        found.push_back(one);
        add_roughness(seen, field, one, met, weight * size, distance, segment, found);
    }

    // What a rough surface scatters: of each piece at random. Source: see `scattered_back`, whose power a solid angle
    // and area is r^2 / pi for Lambert's law at normal incidence.
    void add_roughness(const scene_view& seen, const elevation_field& field, const reflector& piece,
                       const surface_incidence& met, float size, float distance, const cut_segment& segment,
                       std::vector<reflector>& found) const {
        const medium &before = seen.media[piece.before], &after = seen.media[piece.after];
        const incidence at{before, after, met.cosine, lines_.frequency, piece.roughness};
        const float rough = model_.roughness.diffuse(at), reflected = model_.at_interface(at).reflected;
        if (!(rough > 1e-6F) || reflected == 0) return;
        const float power = reflected * reflected * rough *
                            scattered_back(is_hard(before) || is_hard(after), met.cosine) / pi * size *
                            field.tissue(distance);
        // Random numbers that stay where they are on the object, wherever the array is. Cells have their middle at 0,
        // so that rounding does not decide between two for a slice through the origin of the object.
        const object_view& owner = seen.objects[segment.object];
        const vec3 on_object =
            at_rest(owner, segment.primitive, owner.at.local_point(at_.point({piece.place.x, 0, piece.place.y}))) /
            step_;
        std::uint64_t place = owner.id;
        for (int axis = 0; axis < 3; ++axis)
            place =
                hash_bits(place, static_cast<std::uint64_t>(static_cast<std::int64_t>(std::round(on_object[axis]))));
        reflector one = piece;
        one.root = incoherent_ *
                   spectral_value::everywhere(square_root(std::sqrt(0.5F * power) * hash_normal(model_.seed, place)));
        one.normal = {0, 0};
        found.push_back(one);
    }

    // Where a point on a face was before its object was deformed, both in coordinates of the object.
    vec3 at_rest(const object_view& owner, std::uint32_t face, vec3 point) const {
        const std::span<const vec3> rest = body_.rest_positions(object_id{owner.id});
        const uvec3 corners = owner.surface.faces[face];
        const triangle now = owner.surface[face];
        const vec3 normal = area_vector(now);
        const float from_a = dot(cross(now.c - now.b, point - now.b), normal),
                    from_b = dot(cross(now.a - now.c, point - now.c), normal), whole = dot(normal, normal);
        if (!(whole > 0)) return point;
        return point + (from_a * (rest[corners.x] - now.a) + from_b * (rest[corners.y] - now.b) +
                        (whole - from_a - from_b) * (rest[corners.z] - now.c)) /
                           whole;
    }

    // 0 at the borders of the region that is covered, 1 from three tenths of the opening on: a surface that ended there
    // would return a wave from its edge.
    float taper(vec2 on_lines) const {
        const float widest = 0.5F * lines_.extent * (lines_.radius == 0 ? 1.0F : lines_.radius + on_lines.y);
        const float beside = std::fabs(aperture_fraction(on_lines.x, lines_.lines)) * 2 * widest;
        const float room = max(0.3F * open_, 1e-6F), inside = clamp((widest - beside) / room, 0, 1);
        return inside * inside * (3 - 2 * inside);
    }

    // How far the surface that a mesh stands for lies from one of its faces at a point: the quadratic surface with the
    // normals of the corners, 1/2 sum over the edges of u v (n_b - n_a) (b - a). World axes, metres.
    static vec3 bulge_of(const object_view& one, std::uint32_t face, vec3 world) {
        const face_normals normals = one.normals.of_face(one.surface, face, {0, 0, 1});
        if (!normals.curved) return {0, 0, 0};
        const triangle t = one.surface[face];
        const vec3 local = one.at.local_point(world), from_third = local - normals.third;
        const float u = clamp(dot(normals.gradient[0], from_third), 0, 1),
                    v = clamp(dot(normals.gradient[1], from_third), 0, 1 - u), w = 1 - u - v;
        const vec3* const n = normals.corner;
        const float rise = 0.5F * (u * v * dot(n[1] - n[0], t.b - t.a) + v * w * dot(n[2] - n[1], t.c - t.b) +
                                   w * u * dot(n[0] - n[2], t.a - t.c));
        const vec3 smooth = normals.at(local);
        const float size = length(smooth);
        return size > 0 ? one.at.direction(rise / size * smooth) : vec3{0, 0, 0};
    }

    const scene& body_;
    view<const ray> places_;
    pose at_;
    const Model& model_;
    float depth_, open_ = 0, step_ = 0;
    float step_of_nodes_; // see `spectral_value`, hertz
    // Root of a factor on amplitude. What scatters at all heights returns a power of integral |E|^4 dy, which is as 1 /
    // f; of a tall reflector it is |integral E^2 dy|^2, as 1 / f^2.
    lanes<spectral_value::nodes> incoherent_{1.0F};
    slice_lines lines_{};
    probe_lines probe_{};
    frame_view frame_{};
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
