#ifndef INSONIFY_SCENE_LINE_LAYERS_HPP
#define INSONIFY_SCENE_LINE_LAYERS_HPP

#include <insonify/acoustics/layer.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/scene/media_stack.hpp>
#include <insonify/scene/scene.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Crossings closer together than this count as one place: faces that touch make one interface, not a film between.
inline constexpr float touching_distance = 1e-6F;

/// Where a line goes through the surface of an object.
struct crossing {
    float distance = 0;          ///< metres from the face of the probe
    std::uint32_t rank = 0;      ///< of the object
    std::uint32_t primitive = 0; ///< face of the object's mesh

    friend bool operator==(const crossing&, const crossing&) = default;
    /// Nearest first; ties by rank, then by face.
    friend bool operator<(const crossing& a, const crossing& b) {
        return a.distance != b.distance ? a.distance < b.distance
               : a.rank != b.rank       ? a.rank < b.rank
                                        : a.primitive < b.primitive;
    }
};

/// What the search along one line fills, kept from line to line so that it allocates once.
struct line_crossings {
    std::vector<crossing> crossings; ///< ascending
    media_stack inside;              ///< the objects around the origin of the line

    /// Empty, with room for the scene's objects.
    INSONIFY_LAZY void clear(const scene& body) {
        crossings.clear();
        inside.clear(body.objects().size());
    }
    /// Puts the crossings in order, nearest first.
    INSONIFY_LAZY void sort() {
        auto& all = later<Later>(crossings);
        if (!std::is_sorted(all.begin(), all.end())) std::sort(all.begin(), all.end());
    }
};

/// True where the ray, from its origin to `reach`, may touch the box; never false where it does.
INSONIFY_LAZY bool may_touch(const aabb& box, const ray& r, float reach) {
    float in = 0, out = reach;
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = std::fabs(r.direction[axis]) > 1e-30F ? 1 / r.direction[axis] : 1e30F;
        const float a = (box.lower[axis] - r.origin[axis]) * inverse, b = (box.upper[axis] - r.origin[axis]) * inverse;
        in = greater(in, lesser(a, b));
        out = lesser(out, greater(a, b));
    }
    return in <= out * 1.000001F;
}

/// Adds every crossing of a line with one object, from its origin to `depth` metres, in any order.
///
/// An object is around the origin if the half line crosses its surface an odd number of times. The same crossings serve
/// for both, so the two never contradict each other, also where the probe touches a surface.
INSONIFY_LAZY void add_crossings(const object& one, const ray& line, float depth, line_crossings& found) {
    const bool around = one.box.contains(line.origin);
    if (!around && !may_touch(one.box, line, depth)) return;
    ray local = one.local(line);
    local.max_distance = around ? FLT_MAX : depth;
    one.tree_view().for_each_hit(local, [&](const hit& at) {
        if (around) found.inside.toggle(one.rank);
        if (at.distance <= depth) later<Later>(found.crossings).push_back({at.distance, one.rank, at.primitive});
    });
}

/// Finds every crossing of a line from its origin to `depth` metres, and the objects that its origin lies in.
INSONIFY_LAZY void find_crossings(const scene& body, const ray& line, float depth, line_crossings& found) {
    found.clear(body);
    for (const object& one : body.objects()) add_crossings(one, line, depth, found);
    found.sort();
}

/// How a line meets a surface: the cosine of the angle of incidence, and the tilt of the normal against the line, in
/// radians within the slice plane and out of it.
struct surface_incidence {
    float cosine = 1; ///< of the angle of incidence, 0 to 1
    vec2 tilt{0, 0};  ///< radians: within the slice plane, and out of it
};
/// How a line meets a face; head on where the face has no area.
INSONIFY_LAZY surface_incidence incidence_on(const object& one, std::uint32_t face, const line_frame& line) {
    const vec3 along = one.at.local_direction(line.along), elevation = one.at.local_direction(line.elevation);
    const vec3 normal = unit_normal(mesh_view{one.surface}[face], -along);
    const float facing = std::fabs(dot(normal, along));
    return {
        .cosine = lesser(facing, 1.0F),
        .tilt = {std::atan2(dot(normal, cross(elevation, along)), facing), std::atan2(dot(normal, elevation), facing)}};
}

/// Whether the angles at which a line meets surfaces are looked up.
enum class angles { find, skip };

/// Turns crossings into layers: which object's medium fills which stretch of the line. Replaces what `layers` held.
///
/// All crossings within `touching_distance` of one another are applied before the media are compared. Those at the face
/// of the probe belong to the face.
INSONIFY_LAZY void stack_layers(const scene& body, const line_frame& line, float depth, line_crossings& found,
                                std::vector<layer>& layers, angles wanted = angles::find) {
    media_stack& inside = found.inside;
    const std::vector<crossing>& crossings = found.crossings;
    const auto layer_of = [&](std::uint32_t rank, float begin, const surface_incidence& met) {
        layer next{.begin = begin, .end = depth, .cosine = met.cosine, .tilt = met.tilt};
        if (rank == media_stack::none) return next;
        const object& one = body.ranked(rank);
        next.medium = one.medium_index;
        next.object = static_cast<std::uint32_t>(one.id);
        next.place = 1 + static_cast<std::uint32_t>(&one - body.objects().data());
        return next;
    };
    std::size_t next = 0;
    for (; next < crossings.size() && crossings[next].distance <= touching_distance; ++next)
        inside.toggle(crossings[next].rank);
    std::uint32_t current = inside.top();
    layers.clear();
    layers.push_back(layer_of(current, 0, {}));
    while (next < crossings.size()) {
        const std::size_t first = next;
        const float place = crossings[first].distance;
        if (place >= depth) break;
        for (; next < crossings.size() && crossings[next].distance <= place + touching_distance; ++next)
            inside.toggle(crossings[next].rank);
        const std::uint32_t after = inside.top();
        if (after == current) continue;
        surface_incidence met;
        if (wanted == angles::find) {
            std::size_t surface = first; // of the group, a surface that the change of medium is due to
            while (surface + 1 < next && crossings[surface].rank != after && crossings[surface].rank != current)
                ++surface;
            const crossing& at = crossings[surface];
            met = incidence_on(body.ranked(at.rank), at.primitive, line);
        }
        layers.back().end = place;
        layers.push_back(layer_of(after, place, met));
        current = after;
    }
}

} // namespace insonify::inline INSONIFY_ABI
#endif
