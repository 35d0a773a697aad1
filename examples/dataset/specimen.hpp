#ifndef INSONIFY_DATASET_SPECIMEN_HPP
#define INSONIFY_DATASET_SPECIMEN_HPP

#include "sample.hpp"
#include <algorithm>
#include <cmath>
#include <optional>

namespace dataset {

/// A smooth displacement: waves along three directions.
struct bending {
    vec3 direction[3]{};
    vec3 wave[3]{};      ///< radians per metre
    float phase[3]{};    ///< radians
    float amplitude = 0; ///< of each wave, metres

    bending() = default;
    bending(const description& d, const sample& s) {
        amplitude = s.bend * 1_mm * std::sqrt(2.0F / 3);
        for (std::uint64_t i = 0; i < 3; ++i) {
            const auto random = [&](std::uint64_t k) { return hash_normal(s.at.body, 2000 + 10 * i + k); };
            const vec2 a = random(0), b = random(1), c = random(2);
            direction[i] = normalize(vec3{a.x, a.y, b.x});
            wave[i] = normalize(vec3{b.y, c.x, c.y}) * (2 * pi / (d.bend_length * 1_mm));
            phase[i] = 2 * pi * hash_uniform(s.at.body, 2000 + 10 * i + 9);
        }
    }
    vec3 operator()(vec3 p) const {
        vec3 sum{0, 0, 0};
        for (int i = 0; i < 3; ++i) sum += amplitude * std::sin(dot(wave[i], p) + phase[i]) * direction[i];
        return sum;
    }
};

inline constexpr float needle_length = 200_mm; ///< the longest of spinal and biopsy needles

/// The body of a sample, and of others that have the same.
struct specimen {
    spot at{};                          ///< of one of these samples
    anatomy::values parameters{};       ///< of the region
    float scale = 1;                    ///< of the anatomy
    bending bend{};                     ///< of the scaled anatomy
    std::vector<vec2> factors{};        ///< of attenuation and backscatter, for each label but the needle
    std::vector<anatomy::view> views{}; ///< of the anatomy, neither scaled nor bent
    scene body{};                       ///< built, with its needle behind the probe, if samples have needles
    std::vector<object_id> soft{};      ///< all but the needle
    std::vector<object_id> stiff{};     ///< those of them that do not yield
    std::optional<object_id> needle{};
    std::vector<std::uint8_t> labels{}; ///< of the objects, by their ids

    /// Where a point of the anatomy is in the body at rest.
    vec3 moved(vec3 p) const { return scale * p + bend(scale * p); }
};

/// The fibres of an object, or the normals of its layers, where it has been moved to: as if it were not bent.
template <class Directions>
Directions moved_directions(const Directions& of, const pose& at, float scale) {
    if constexpr (requires { of.follows_surface(); })
        if (of.follows_surface()) return of;
    if (!of.varies()) return at.direction(of({0, 0, 0}));
    return [of, at, scale](vec3 p) { return at.direction(of(at.local_point(p / scale))); };
}

/// Makes the body of a sample: scaled, bent, with its own media.
inline specimen make_specimen(const description& d, const anatomies& all, const spot& at) {
    const subject& from = all[at.anatomy];
    specimen made{.at = at, .parameters = from.drawn(at.body_seed)};
    anatomy::body original = from.make(made.parameters);
    const sample s = draw_sample(d, at, original.views[at.view]);
    made.scale = s.scale;
    made.bend = bending{d, s};
    made.views = std::move(original.views);
    for (std::uint64_t i = 0; i < 2 * std::uint64_t{all.labels().needle()}; ++i) {
        constexpr std::uint64_t beyond_those_of_draw_sample = 100'000;
        const float factor =
            d.media.from + (d.media.to - d.media.from) * hash_uniform(at.body, beyond_those_of_draw_sample + i);
        if (i % 2 == 0) made.factors.push_back({factor, factor});
        made.factors.back().y = factor;
    }
    const auto varied = [&](medium one, std::uint8_t label) {
        one.attenuation *= made.factors[label].x;
        one.backscatter *= made.factors[label].y;
        return one;
    };
    made.body = scene{varied(original.anatomy.background(), 0)};
    const auto add = [&](mesh surface, const medium& inside, const object_settings& how, std::uint8_t label) {
        const object_id id = made.body.add(std::move(surface), inside, how);
        made.labels.resize(static_cast<std::uint32_t>(id) + std::size_t{1});
        made.labels.back() = label;
        return id;
    };
    for (const object& one : original.anatomy.objects()) {
        mesh surface = one.surface;
        for (vec3& p : surface.positions) p = made.moved(one.at.point(p));
        const std::uint8_t label = all.labels().of(from.structure(one));
        if (label >= all.labels().needle())
            throw usage_error{from.name() + ": no other body has an object '" + one.name + "'"};
        made.soft.push_back(add(std::move(surface), varied(one.inside, label),
                                {.priority = one.priority,
                                 .name = one.name,
                                 .fibres = moved_directions(one.fibres, one.at, s.scale),
                                 .layer_normal = moved_directions(one.layer_normal, one.at, s.scale),
                                 .crease_angle = one.crease_angle},
                                label));
        if (anatomy::is_stiff(one.inside)) made.stiff.push_back(made.soft.back());
    }
    if (d.needle > 0)
        made.needle = add(make_needle(needle_diameter(s.gauge), needle_length), tissue::steel,
                          {.priority = 100, .name = "needle"}, all.labels().needle());
    made.body.build(exec::seq);
    return made;
}

/// What was done with the body of a sample.
struct placement {
    scene body;
    pose at{};              ///< of the probe
    bool on_surface = true; ///< false: the probe's place is beside the anatomy
    contact touch{};        ///< of the probe, where it is pressed
};

namespace detail {

/// Where the probe is, and a point in front of the surface there.
struct probe_place {
    pose skin{}; ///< before it is tilted, rocked and turned, what `at` is a turn of
    pose at{};
    vec3 outside{0, 0, 0};
    bool on_surface = true;
};

/// The rotation that takes one direction to another one on the shortest way.
inline vec3 rotated(vec3 from, vec3 to, vec3 v) {
    const vec3 axis = cross(from, to); // of length sin
    const float c = dot(from, to);
    return c * v + cross(axis, v) + dot(axis, v) / max(1 + c, 1e-3F) * axis; // Rodrigues
}

/// On the surface of the body, facing inwards.
inline probe_place place_probe(const specimen& of, const standpoint& from, const sample& s) {
    const scene& body = of.body;
    const std::optional<object_id> on = from.on.empty() ? std::nullopt : body.find(from.on);
    const pose& straight = from.straight;
    const vec3 centre = of.scale * from.centre;
    const float away = of.scale * from.away, spread = s.spread * 1_deg, azimuth = s.azimuth * 1_deg;
    const auto surface = [&](vec3 shift, vec3 outwards) {
        return first_surface(body, {.origin = centre + shift + away * outwards, .direction = -outwards},
                             [&](object_id id) { return on ? id == *on : id != of.needle; });
    };
    const vec3 outwards = straight.direction(
        {std::sin(spread) * std::cos(azimuth), std::sin(spread) * std::sin(azimuth), -std::cos(spread)});
    const vec3 shift = straight.direction({s.along * 1_mm, s.across * 1_mm, 0});
    const auto hit = surface(shift, outwards);
    // A ray that misses leaves the probe beside the body, looking at its middle.
    const vec3 place = hit ? hit->point : centre + shift + 0.5F * away * outwards;
    vec3 inwards = hit ? -hit->normal : -outwards, lateral = straight.direction({1, 0, 0});
    if (hit && !from.faces_skin) // as in the view, relative to the skin
        if (const auto usual = surface({0, 0, 0}, straight.direction({0, 0, -1}))) {
            inwards = rotated(usual->normal, hit->normal, straight.direction({0, 0, 1}));
            lateral = rotated(usual->normal, hit->normal, lateral);
        }
    const pose skin = look_at(place + (s.pressure - s.standoff) * 1_mm * inwards, place + inwards,
                              std::fabs(dot(lateral, inwards)) < 0.99F ? lateral : straight.direction({0, 1, 0}));
    const auto turned = [](float degrees, int axis) {
        const float c = std::cos(degrees * 1_deg), n = std::sin(degrees * 1_deg);
        const int i = (axis + 1) % 3, j = (axis + 2) % 3;
        mat3 m{1};
        m[i][i] = m[j][j] = c;
        m[i][j] = n;
        m[j][i] = -n;
        return pose{m, {0, 0, 0}};
    };
    return {skin, skin * turned(s.turn, 2) * turned(s.tilt, 0) * turned(s.rock, 1), place - 0.1_mm * inwards,
            hit.has_value()};
}

/// Whether tissue under a face would fold over with this `decay`.
inline bool folds(const pressed_face& face) {
    for (std::size_t row = 0; row < pressed_face::rows; ++row)
        for (std::size_t i = 0; i < pressed_face::columns; ++i)
            if (face.depth[row][i] > 0 && !(face.depth[row][i] < face.decay * (1 - face.stop[row][i]))) return true;
    return false;
}

/// Deforms the body, but not the needle, where the face of the probe is in it: where it is pressed, and where an edge of
/// it is lower than its middle. A face that would reach bone is raised.
template <transducer Probe>
contact yield(placement& made, const specimen& of, const Probe& probe, vec3 outside) {
    const auto contains_outside = [&](object_id id) { // gel, which makes way
        const ray away{.origin = outside, .direction = {0, 0, 1}};
        const auto hit = first_surface(made.body, away, [=](object_id other) { return other == id; });
        return hit && dot(hit->normal, away.direction) > 0;
    };
    const auto is_one_of = [](const std::vector<object_id>& ids) {
        return [&ids](object_id id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); };
    };
    std::vector<object_id> pressed;
    for (const object_id id : of.soft)
        if (is_one_of(of.stiff)(id) || !contains_outside(id)) pressed.push_back(id);
    constexpr float far_decay = 1; // so that tissue folds only where it is pressed against something stiff
    constexpr float usual_decay = 20_mm, step = 1_mm;
    const float highest = length(made.body.box().size()); // above which there is no bone
    const auto press_from = [&](const auto& self, float raised) -> contact {
        try {
            return press(made.body, probe, made.at, {.decay = far_decay}, is_one_of(pressed), is_one_of(of.stiff));
        } catch (const usage_error&) { // of a face in bone
            if (raised > highest) throw;
        }
        made.at.translation -= made.at.direction({0, 0, step});
        return self(self, raised + step);
    };
    contact touch = press_from(press_from, 0);
    pressed_face& face = touch.deformation;
    const auto stop = face.stop; // exp(-S / far_decay), S metres below the skin
    const auto use_decay = [&](float decay) {
        face.decay = decay;
        for (std::size_t row = 0; row < pressed_face::rows; ++row)
            for (std::size_t i = 0; i < pressed_face::columns; ++i)
                face.stop[row][i] = std::pow(stop[row][i], far_decay / decay);
        face.recover_beside();
    };
    use_decay(max(usual_decay, 2 * touch.depth)); // an edge of a tilted probe may be deep
    while (folds(face) && face.decay < far_decay) use_decay(1.5F * face.decay);
    made.body.deform(exec::seq, face, of.soft);
    return touch;
}

/// Keeps the tip of a needle in the image, so far from its sides that the needle is seen, whatever side it is from; and
/// above its lower end, unless an option says how deep it is.
template <transducer Probe>
void keep_in_image(const description& d, const Probe& probe, sample& s) {
    constexpr float margin = 6_mm;
    if (!d.needle_depth) s.needle_depth = min(s.needle_depth, s.depth - margin / 1_mm);
    const auto side = [&](float line) {
        const ray edge = probe.beam(line);
        return edge.origin.x + (s.needle_depth * 1_mm - edge.origin.z) * edge.direction.x / edge.direction.z;
    };
    const float one = side(-0.5F), other = side(static_cast<float>(probe.lines) - 0.5F);
    const float reach = max(0.5F * std::fabs(other - one) - margin, 0), middle = 0.5F * (one + other);
    s.needle_lateral = clamp(s.needle_lateral * 1_mm, middle - reach, middle + reach) / 1_mm;
}

/// The direction of a needle in the frame of the probe.
inline vec3 direction_of_needle(const sample& s) {
    const float angle = s.needle_angle * 1_deg, aside = s.needle_from == image_side::left ? 1.0F : -1.0F;
    return {aside * std::cos(angle), 0, std::sin(angle)};
}

/// Whether a needle runs through bone or cartilage.
inline bool is_in_bone(const placement& made, const specimen& of, const sample& s) {
    const vec3 inwards = made.at.direction(direction_of_needle(s)),
               tip = made.at.point(vec3{s.needle_lateral, 0, s.needle_depth} * 1_mm);
    const auto bone = first_surface(
        made.body, {.origin = tip - needle_length * inwards, .direction = inwards, .max_distance = needle_length},
        [&](object_id id) { return std::find(of.stiff.begin(), of.stiff.end(), id) != of.stiff.end(); });
    return bone.has_value();
}

/// Keeps the tip of a needle in the image and the needle out of bone: its tip is less deep, and its path flatter where it
/// would begin under the face. A sample with bone in the way at every depth has none.
template <transducer Probe>
void keep_visible(const description& d, const placement& made, const specimen& of, const Probe& probe, sample& s) {
    constexpr std::uint32_t depths = 12;
    const float drawn = s.needle_depth, lateral = s.needle_lateral, angle = s.needle_angle,
                smallest = d.needle_depth ? d.needle_depth->from : 1;
    for (std::uint32_t part = depths; part > 0; --part) {
        s.needle_depth = max(drawn * static_cast<float>(part) / depths, smallest);
        s.needle_lateral = lateral;
        keep_in_image(d, probe, s);
        if (!d.needle_angle)
            s.needle_angle = min(angle, angle_beside_face(s, of.views[s.at.view], about_view::beside_face.from));
        if (!is_in_bone(made, of, s)) return;
    }
    s.needle = false;
}

} // namespace detail

/// Places the probe of a sample on its body, presses it in, and places the needle.
/// @param s  its needle's tip becomes that of the image
template <transducer Probe>
placement place(const description& d, const anatomies& all, const specimen& of, const Probe& probe, sample& s) {
    const anatomy::view& seen = of.views[s.at.view];
    const detail::probe_place where = detail::place_probe(of, all[s.at.anatomy].standpoint_of(seen), s);
    placement made{.body = of.body, .at = where.at, .on_surface = where.on_surface};
    made.body.set_background_fibres(where.skin.direction({1, 0, 0}), where.skin.direction({0, 0, 1}));
    made.touch = detail::yield(made, of, probe, where.outside);
    if (!of.needle) return made;
    if (seen.needle) { // the tip stays as far from the target as it was drawn, wherever that has moved
        const vec3 target = of.moved(seen.needle->target);
        const vec3 now = made.at.local_point(made.touch.deformation(target)),
                   usual = seen.at.local_point(seen.needle->target);
        s.needle_lateral += (now.x - usual.x) / 1_mm;
        if (!d.needle_depth) s.needle_depth = max(s.needle_depth + (now.z - usual.z) / 1_mm, 1);
    }
    if (s.needle) detail::keep_visible(d, made, of, probe, s);
    // In the plane of the image; a sample without a needle has it behind the probe.
    const vec3 tip = s.needle ? vec3{s.needle_lateral, 0, s.needle_depth} * 1_mm : vec3{0, 0, -300_mm};
    made.body.place(*of.needle, needle_pose(made.at.point(tip), made.at.direction(detail::direction_of_needle(s)),
                                            made.at.direction({0, 0, -1})));
    return made;
}

} // namespace dataset
#endif
