#ifndef INSONIFY_SCENE_SKIN_HPP
#define INSONIFY_SCENE_SKIN_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tissue/structure_gains.hpp>
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// How `add_skin` covers a body. Lengths are metres. Sources: skin of the trunk and the limbs, 1 to 2.5 mm, Gray's
/// Anatomy, 41st edition; the others by convention.
struct skin_settings {
    float thickness = 1.5e-3F; ///< of epidermis and dermis, on average
    float fat = 7e-3F;         ///< of the fat below it, where the background begins there; 0: none
    float gel = 0.65e-3F;      ///< of the film between the face and the skin, on average

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        check_length(thickness, "thickness", 0.02F, "add_skin");
        check_length(gel, "gel", 0.02F, "add_skin");
        if (fat != 0) check_length(fat, "fat", 0.2F, "add_skin");
    }

    friend bool operator==(const skin_settings&, const skin_settings&) = default;
};

namespace detail {

/// Smooth random numbers, of mean 0 and variance 1, within two standard deviations, over the plane.
/// @param place  in units of the distance of independent ones
inline float smooth_random(std::uint32_t seed, vec2 place) {
    const auto all = [](float value) { return wide_floats(value); };
    float value[wide_lanes];
    store(value_noise<wide_lanes>(mix_bits(seed), all(place.x), all(place.y), all(0)), value);
    return clamp(value[0], -2, 2);
}

/// The face of a probe, and what lies beside it, as points and directions into the body, in its own coordinates.
class face_grid {
  public:
    template <transducer Probe>
    explicit face_grid(const Probe& probe) {
        constexpr float margin = 12e-3F, apart = 0.8e-3F; // beside the face, and of the points
        const float last = static_cast<float>(probe.lines) - 1;
        const ray first = probe.beam(0), end = probe.beam(last);
        float length_along = length(end.origin - first.origin), height = 8e-3F;
        if constexpr (requires { probe.elevation_height; }) height = probe.elevation_height;
        const bool is_point = !(length_along > 1e-6F); // lines that leave one point of a plane face
        if constexpr (requires { probe.aperture(); })
            if (is_point) length_along = probe.aperture();
        columns_ = static_cast<std::uint32_t>(clamp((length_along + 2 * margin) / apart, 8, 2048)) + 1;
        rows_ = static_cast<std::uint32_t>(clamp((height + 2 * margin) / (2 * apart), 4, 512)) + 1;
        for (std::uint32_t row = 0; row < rows_; ++row)
            for (std::uint32_t i = 0; i < columns_; ++i) {
                const float along = static_cast<float>(i) / static_cast<float>(columns_ - 1) - 0.5F,
                            x = along * (length_along + 2 * margin),
                            y = (static_cast<float>(row) / static_cast<float>(rows_ - 1) - 0.5F) *
                                (height + 2 * margin);
                point one{.inwards = {0, 0, 1}, .place = {x, y}};
                if (is_point) {
                    one.at = {first.origin.x + x, y, first.origin.z};
                } else {
                    const ray beam = probe.beam((0.5F + x / length_along) * last);
                    one.at = beam.origin + vec3{0, y, 0};
                    one.inwards = normalize(vec3{beam.direction.x, 0, beam.direction.z});
                }
                points_.push_back(one);
            }
    }

    /// What lies between two depths below the face, as functions of the place on it, metres.
    template <class From, class To>
    mesh slab(const From& from, const To& to) const {
        mesh made;
        for (const point& one : points_) made.positions.push_back(one.at + to(one.place) * one.inwards);
        for (const point& one : points_) made.positions.push_back(one.at + from(one.place) * one.inwards);
        add_slab_faces(made, columns_, rows_);
        return made;
    }

  private:
    struct point {
        vec3 at{0, 0, 0};
        vec3 inwards{0, 0, 1};
        vec2 place{0, 0}; // along the face, and in elevation
    };
    std::uint32_t columns_ = 0, rows_ = 0;
    std::vector<point> points_{};
};

/// The object that encloses all others, if there is one and it is soft.
template <class Deferred = void>
std::optional<object_id> find_outer(const scene& body) {
    const auto box_of = [](const object& one) {
        aabb box;
        for (const vec3& p : one.surface.positions) box = merged(box, one.at.point(p));
        return box;
    };
    aabb whole;
    for (const object& one : body.objects()) whole = merged(whole, box_of(one));
    for (const object& one : body.objects())
        if (const aabb box = box_of(one);
            body.objects().size() > 1 && box.lower == whole.lower && box.upper == whole.upper && !is_hard(one.inside))
            return one.id;
    return std::nullopt;
}

/// The name, or with a number where an object has it.
template <class Deferred = void>
std::string unused_name(const scene& body, const std::string& name) {
    std::string unused = name;
    for (int number = 2; body.find(unused); ++number) unused = name + '.' + std::to_string(number);
    return unused;
}

/// A closed surface that is moved inwards, unevenly, wherever its faces point. @param by  metres, on average
template <class Deferred = void>
mesh moved_inwards(mesh surface, float by, std::uint32_t seed) {
    const std::vector<std::uint32_t> place = weld(surface.positions);
    std::vector<vec3> normals(surface.positions.size(), vec3{0, 0, 0}); // of each place
    for (const uvec3& face : surface.faces) {
        const vec3 a = surface.positions[face.x];
        const vec3 normal = cross(surface.positions[face.y] - a, surface.positions[face.z] - a);
        for (int i = 0; i < 3; ++i) normals[place[face[i]]] += normal;
    }
    if (enclosed_volume(surface) < 0) by = -by;
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const vec3 normal = normals[place[i]];
        const float size = length(normal);
        if (!(size > 0)) continue;
        vec3& p = surface.positions[i];
        const float uneven = 1 + 0.1F * smooth_random(seed, vec2{p.x + p.z, p.y - p.z} / 6e-3F);
        p -= by * uneven / size * normal;
    }
    return surface;
}

/// @throws usage_error  for a deformed body, whose present shape is not the one that the next deformation begins with
inline void check_undeformed(const scene& body) {
    if (body.is_deformed()) throw usage_error{"add_skin: the body is deformed; cover it before `deform`"};
}

template <class Deferred = void>
bool has_skin(const scene& body) {
    return std::any_of(body.objects().begin(), body.objects().end(),
                       [](const object& one) { return one.inside == tissue::skin; });
}

/// Makes the outer layer of the object that encloses all others skin. @return whether there is such an object
template <class Deferred = void>
bool cover_outer(scene& body, float thickness) {
    const std::optional<object_id> outer = find_outer(body);
    if (!outer) return false;
    const object whole = body[*outer];
    object_settings skin = whole;
    skin.name = unused_name(body, "skin");
    skin.fibres = {};
    skin.layer_normal = own_surface{};
    body.remove(*outer);
    mesh inner = moved_inwards(whole.surface, thickness, 1);
    body.add(whole.surface, tissue::skin, skin);
    body.add(std::move(inner), whole.inside, whole);
    return true;
}

} // namespace detail

/// What `add_skin` has covered.
enum class skin_place {
    none,    ///< nothing: the body has skin
    surface, ///< the object that encloses all others, by an offset inwards
    face     ///< what lies below the face of the probe
};

/// Covers a body that one soft object encloses, wherever a probe will be: its outer layer becomes an object "skin".
/// Call it before `build`. The outer object gets a new id, and keeps its name. A body with an object of `tissue::skin`,
/// or without an outer one, is left as it is.
/// @param settings  only `thickness` matters
/// @return `skin_place::surface` or `none`
/// @throws usage_error  for a setting out of range, or a deformed body
template <class Deferred = void>
skin_place add_skin(scene& body, const skin_settings& settings = {}) {
    settings.check();
    detail::check_undeformed(body);
    return !detail::has_skin(body) && detail::cover_outer(body, settings.thickness) ? skin_place::surface
                                                                                    : skin_place::none;
}

/// Covers a body whose meshes begin below the skin, as most anatomy does, so that pictures begin as real ones do: film
/// of gel, entry echo, dermis, fat. Call it before `build`.
///
/// Where one soft object encloses all others, its outer layer becomes an object "skin", and it gets a new id. Elsewhere
/// a film "gel", "skin" and "subcutaneous fat" follow the face of the probe, 12 mm beyond its edges; skin and gel have
/// the highest priority, fat the lowest: what is inside of it stays. A name that is taken gets a number: "skin.2". A
/// body with an object of `tissue::skin` is left as it is.
/// @param at  pose of the probe
/// @throws usage_error     for a setting out of range, a deformed body, or a probe that looks out of a full circle
/// @throws geometry_error  for a pose that is not rigid
template <transducer Probe>
skin_place add_skin(scene& body, const Probe& probe, const pose& at, const skin_settings& settings = {}) {
    settings.check();
    detail::check_undeformed(body);
    probe.check();
    detail::check_rigid(at, "add_skin");
    if (detail::has_skin(body)) return skin_place::none;
    if (detail::cover_outer(body, settings.thickness)) return skin_place::surface;
    constexpr int max_priority = 1'000'000;
    int highest = 0, lowest = 0;
    for (const object& one : body.objects()) {
        highest = std::max(highest, one.priority);
        lowest = std::min(lowest, one.priority);
    }
    if (highest > max_priority || lowest < -max_priority)
        throw usage_error{"add_skin: the priority of an object is ", highest > max_priority ? highest : lowest,
                          "; use -1000000 to 1000000, so that there is room above and below"};
    if (is_full_circle(probe))
        throw usage_error{"add_skin: a probe that looks out of a full circle does not stand on skin"};
    const detail::face_grid face{probe};
    // @param part  deviation over the mean
    const auto uneven = [](std::uint32_t seed, float mean, float part, float size) {
        return [=](vec2 place) { return mean * (1 + part * detail::smooth_random(seed, place / size)); };
    };
    const auto above = [](float distance) { return [=](vec2) { return -distance; }; };
    const auto gel = uneven(2, settings.gel, 0.18F, 4.5e-3F), skin = uneven(3, settings.thickness, 0.12F, 3.5e-3F),
               fat = uneven(4, settings.fat, 0.1F, 12e-3F);
    const auto below_skin = [&](vec2 place) { return gel(place) + skin(place); };
    body.add(face.slab(above(0.6e-3F), gel), tissue::gel,
             {.priority = highest + 2, .at = at, .name = detail::unused_name(body, "gel")});
    body.add(face.slab(above(0.4e-3F), below_skin), tissue::skin,
             {.priority = highest + 1,
              .at = at,
              .name = detail::unused_name(body, "skin"),
              .fibres = vec3{1, 0, 0},
              .layer_normal = own_surface{}});
    if (settings.fat > 0)
        body.add(face.slab(above(0.2e-3F), [&](vec2 place) { return below_skin(place) + fat(place); }), tissue::fat,
                 {.priority = lowest - 1,
                  .at = at,
                  .name = detail::unused_name(body, "subcutaneous fat"),
                  .fibres = vec3{1, 0, 0},
                  .layer_normal = vec3{0, 0, 1}});
    return skin_place::face;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
