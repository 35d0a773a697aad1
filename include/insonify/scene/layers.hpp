#ifndef INSONIFY_SCENE_LAYERS_HPP
#define INSONIFY_SCENE_LAYERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/bvh/traverse.hpp>
#include <insonify/geometry/smooth_normals.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// An object as tracers see it. Trivially copyable; refers to the scene's arrays.
struct object_view {
    mesh_view surface{};                   ///< in object coordinates
    bvh_view<mesh_view> tree{};            ///< over `surface`; without nodes where it is out of date
    detail::face_groups_view groups{};     ///< for slicing where the tree is out of date
    detail::smooth_normals_view normals{}; ///< of `surface`
    pose at{};                             ///< object to world
    aabb box{};                            ///< in the world
    std::uint32_t id = 0;                  ///< its `object_id` as a number
    std::uint32_t medium = 0;              ///< index into `scene_view::media`
    bool tree_is_current = false;          ///< rays can be traced

    /// A world ray in object coordinates; distances along it are the same.
    INSONIFY_FN ray local(const ray& r) const {
        return {at.local_point(r.origin), at.local_direction(r.direction), r.min_distance, r.max_distance};
    }
};

/// A scene in flat arrays, as tracers and devices see it. Trivially copyable; valid until the scene changes.
///
/// Objects are ordered by rank: where several contain a point, the first one's medium applies.
struct scene_view {
    view<const object_view> objects{};             ///< by rank
    bvh_view<view<const aabb>> boxes{};            ///< the objects' world boxes, by rank
    view<const medium> media{};                    ///< the background first
    view<const pose> places{};                     ///< object to world: of the background (identity), then by rank
    view<const placed_structure> structures{};     ///< of the medium of each place
    view<const displacement_view> displacements{}; ///< of the tissue of each place, for one frame; empty: at rest
};

/// The objects that contain a point moving along a line, by rank, in fixed memory. The first one gives the medium.
struct media_stack {
    static constexpr std::uint32_t none = ~0U; ///< rank of the background

    view<std::uint32_t> ranks{}; ///< room for as many objects as may contain a point
    std::uint32_t count = 0;     ///< objects that do
    bool overflow = false;       ///< there were more than fit

    /// Outside all objects.
    INSONIFY_FN void clear() {
        count = 0;
        overflow = false;
    }

    /// The point crosses the surface of an object: enters it, or leaves it.
    INSONIFY_FN void toggle(std::uint32_t rank) {
        std::uint32_t place = 0;
        while (place < count && ranks[place] < rank) ++place;
        if (place < count && ranks[place] == rank) {
            --count;
            for (; place < count; ++place) ranks[place] = ranks[place + 1];
        } else if (count == ranks.size()) {
            overflow = true;
        } else {
            for (std::uint32_t i = count; i > place; --i) ranks[i] = ranks[i - 1];
            ranks[place] = rank;
            ++count;
        }
    }

    /// Rank of the object whose medium applies; `none` outside all.
    INSONIFY_FN std::uint32_t top() const { return count > 0 ? ranks[0] : none; }

    /// Takes over the objects of another stack, not its memory.
    INSONIFY_FN void assign(const media_stack& other) {
        overflow = other.overflow || other.count > ranks.size();
        count = overflow ? 0 : other.count;
        for (std::uint32_t i = 0; i < count; ++i) ranks[i] = other.ranks[i];
    }
};

/// A point where a line crosses the surface of an object.
struct crossing {
    float distance = 0;          ///< metres from the origin of the line
    std::uint32_t rank = 0;      ///< of the object: index into `scene_view::objects`
    std::uint32_t primitive = 0; ///< face of the object's mesh

    friend bool operator==(const crossing&, const crossing&) = default;
    /// Nearest first; ties by rank, then by face.
    INSONIFY_FN friend bool operator<(const crossing& a, const crossing& b) {
        return a.distance != b.distance ? a.distance < b.distance
               : a.rank != b.rank       ? a.rank < b.rank
                                        : a.primitive < b.primitive;
    }
};

/// All crossings of one line and the objects that contain its origin, in memory of fixed capacity.
struct line_crossings {
    view<crossing> room{};   ///< for the crossings
    std::uint32_t count = 0; ///< of crossings
    bool overflow = false;   ///< there were more than fit
    media_stack inside{};    ///< the objects that contain the origin

    /// Removes all crossings and objects.
    INSONIFY_FN void clear() {
        count = 0;
        overflow = false;
        inside.clear();
    }
    /// Appends a crossing, or sets `overflow` where there is no room.
    INSONIFY_FN void add(const crossing& one) {
        if (count == room.size())
            overflow = true;
        else
            room[count++] = one;
    }
    /// Whether all crossings and containing objects fit.
    INSONIFY_FN bool complete() const { return !overflow && !inside.overflow; }

    /// Sorts the crossings, nearest first. Shell sort: fast for the nearly sorted, and available on a device.
    INSONIFY_FN void sort() {
        constexpr std::uint32_t gaps[] = {301, 57, 10, 1}; // of Ciura's sequence
        for (const std::uint32_t gap : gaps)
            for (std::uint32_t i = gap; i < count; ++i) {
                if (!(room[i] < room[i - gap])) continue;
                const crossing one = room[i];
                std::uint32_t place = i;
                for (; place >= gap && one < room[place - gap]; place -= gap) room[place] = room[place - gap];
                room[place] = one;
            }
    }
    /// The crossings, after `sort`.
    INSONIFY_FN view<const crossing> sorted() const { return {room.data(), count}; }
};

namespace detail {

/// Collects the crossings of one line, in any order, wherever they come from.
///
/// An object contains the origin if the half line crosses its surface an odd number of times. The same crossings decide
/// both, so that the two never contradict each other, even where the probe touches a surface.
struct crossing_collector {
    const scene_view& scene;
    ray line{};      ///< in the world
    float depth = 0; ///< where it ends, metres
    line_crossings& found;

    INSONIFY_FN bool may_begin_in(std::uint32_t rank) const { return scene.objects[rank].box.contains(line.origin); }
    /// Adds a crossing at any distance in front of the origin: all of those of an object that the line may begin in.
    INSONIFY_FN void add(const crossing& one) const {
        if (may_begin_in(one.rank)) found.inside.toggle(one.rank);
        if (one.distance <= depth) found.add(one);
    }
    /// Visits those with the objects that are not skipped, by rays through their trees.
    /// @param skipped  of each object, by rank; empty: none is
    /// @param visit    visit(crossing), `add` or what calls it
    template <class Visit>
    INSONIFY_FN void trace(view<const std::uint8_t> skipped, const Visit& visit) const {
        scene.boxes.for_each_hit({line.origin, line.direction, 0, line.max_distance}, [&](const hit& box) {
            const std::uint32_t rank = box.primitive;
            if (!skipped.empty() && skipped[rank] != 0) return;
            const object_view& one = scene.objects[rank];
            ray local = one.local(line);
            if (may_begin_in(rank)) local.max_distance = FLT_MAX;
            one.tree.for_each_hit(local, crossing_of<Visit>{rank, visit});
        });
    }

  private:
    template <class Visit>
    struct crossing_of {
        std::uint32_t rank;
        const Visit& visit;

        INSONIFY_VISITS
        INSONIFY_FN void operator()(const hit& at) const { visit(crossing{at.distance, rank, at.primitive}); }
    };
};

/// Where the crossings of a line come from: slices have found those with some objects, rays find those with the others.
struct crossing_source {
    view<const crossing> sliced{};  ///< at any distances
    view<const std::uint8_t> cut{}; ///< of each object, by rank, whether slices have cut it; empty: none
    bool rays = true;               ///< whether there are others

    /// Calls visit(crossing) for those in front of the origin.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each(const crossing_collector& collector, const Visit& visit) const {
        for (const crossing& one : sliced)
            if (one.distance >= 0) visit(one);
        if (rays) collector.trace(cut, visit);
    }
};

/// How a line meets a surface.
struct surface_incidence {
    float cosine = 1;        ///< of the angle of incidence, 0 to 1
    vec2 slope{0, 0};        ///< see `layer`
    vec3 curvature{0, 0, 0}; ///< see `layer`
    float roughness = -1;    ///< see `layer`
    vec3 normal{0, 0, 1};    ///< of the surface in the world, on the side away from the probe; length 1
    vec3 flat{0, 0, 1};      ///< of the face alone: the side of it that a point is on
};

/// How a line meets a face at a point in the world, with the normal that is interpolated over smooth edges; at normal
/// incidence where the face has no area.
INSONIFY_FN inline surface_incidence incidence_on(const object_view& one, std::uint32_t face, const line_frame& line,
                                                  vec3 point) {
    const vec3 along = one.at.local_direction(line.along), elevation = one.at.local_direction(line.elevation);
    const vec3 across = cross(elevation, along);
    const face_normals normals = one.normals.of_face(one.surface, face, -along);
    const float side = dot(normals.flat, along) < 0 ? -1.0F : 1.0F; // normals point along the line
    const vec3 flat = side * normals.flat;
    vec3 normal = flat;
    surface_incidence met;
    if (normals.curved) {
        const vec3 smooth = side * normals.at(one.at.local_point(point));
        const float towards = dot(smooth, along), size = length(smooth);
        if (towards > 0 && size > 0) { // else the line grazes the surface
            normal = smooth / size;
            // The change of the slope where the line moves across the surface grows with 1 / cos^3 i: an error of the
            // normal of 2 degrees, that of a mesh, makes one as large as itself at cos i = 0.1. From there on it is
            // held (+-30 %: 0.6 dB rms in a picture of surfaces alone).
            const float steep = 1 / max(towards, 0.1F * size);
            const vec2 slope = steep * vec2{dot(smooth, across), dot(smooth, elevation)};
            const auto slope_change = [&](vec3 to) {
                const vec3 on_surface = to - (steep * dot(smooth, to)) * along;
                const vec3 on_face = on_surface - dot(flat, on_surface) * flat;
                const vec3 change =
                    side * std::sqrt(dot(on_surface, on_surface) / dot(on_face, on_face)) * normals.change(on_face);
                return steep * (vec2{dot(change, across), dot(change, elevation)} - dot(change, along) * slope);
            };
            const vec2 in_slice = slope_change(across), out_of_it = slope_change(elevation);
            met.curvature = {-in_slice.x, -out_of_it.y, -0.5F * (in_slice.y + out_of_it.x)};
        }
    }
    const float facing = dot(normal, along), steep = 1 / max(facing, 1e-4F);
    met.cosine = min(facing, 1.0F);
    met.slope = steep * vec2{dot(normal, across), dot(normal, elevation)};
    met.normal = one.at.direction(normal);
    met.flat = one.at.direction(flat);
    return met;
}

/// Surfaces with less than this cosine of the angle of incidence are steep: 60 degrees. Convention: lines, which tilt
/// by less than 10 degrees, meet surfaces at more than 80 because of the tilt. +-30 %: below 0.3 dB rms.
inline constexpr float steep_cosine = 0.5F;

/// How a line meets a face at a distance. The tilt of a line does not count, except on steep surfaces, which are met
/// because of it. Lines that are turned about their origins (tracing/aperture/turned_line.hpp) have an overload of
/// their own.
INSONIFY_FN inline surface_incidence incidence_at(const line_frame& line, float distance, const object_view& one,
                                                  std::uint32_t face) {
    const vec3 point = line.at(distance);
    const surface_incidence met = incidence_on(one, face, line, point);
    if (line.tilt == 0 || met.cosine > steep_cosine) return met;
    return incidence_on(one, face, {line.origin, normalize(line.path()), line.elevation}, point);
}

/// Crossings closer together than this count as one, metres: touching faces make one interface, not a film between two.
inline constexpr float touching_distance = 1e-6F;

/// Turns the crossings of a line into layers, one at a time: which object's medium fills which part of the line.
///
/// Crossings within `touching_distance` of one another are applied together before the media are compared. For all
/// tracers: a straight line takes all layers, a path goes on until its medium changes.
/// @tparam Line  a type with `incidence_at`
template <class Line = line_frame>
class layer_walk {
  public:
    /// @param found     sorted; its `inside` follows the walk
    /// @param depth     where the line ends, metres
    /// @param incident  whether to compute how the line meets surfaces
    INSONIFY_FN layer_walk(const scene_view& scene, const Line& line, line_crossings& found, float depth, bool incident)
        : scene_{scene}, line_{line}, found_{found}, depth_{depth}, incident_{incident} {}

    /// Crossings at the origin of the line belong to the probe's face: they are applied before the first layer.
    INSONIFY_FN void enter_at_face() {
        for (; next_ < found_.count && found_.room[next_].distance <= touching_distance; ++next_)
            found_.inside.toggle(found_.room[next_].rank);
    }
    /// Crossings at the origin belong to the surface that a path has just left: they are skipped.
    INSONIFY_FN void skip_departure(const object_surface& left) {
        own_ = left;
        while (next_ < found_.count && found_.room[next_].distance <= touching_distance) ++next_;
    }

    /// The next layer, which ends at a change of object or at the end of the line. @return false after the last one
    INSONIFY_FN bool next(layer& here) {
        if (at_end_) return false;
        const std::uint32_t current = found_.inside.top();
        start(here, current);
        here.own_begin = own_;
        while (next_ < found_.count && found_.room[next_].distance < depth_) {
            group_ = next_;
            const float place = found_.room[group_].distance;
            for (; next_ < found_.count && found_.room[next_].distance <= place + touching_distance; ++next_)
                found_.inside.toggle(found_.room[next_].rank);
            const std::uint32_t after = found_.inside.top();
            if (after == current) continue;
            if (incident_) met_ = incidence_at_change(current, after);
            here.end = begin_ = place;
            own_ = {};
            (after < current ? own_ : here.own_end) = {met_.cosine, met_.normal};
            return true;
        }
        at_end_ = true;
        return true;
    }
    /// Whether the last layer ended at the end of the line.
    INSONIFY_FN bool at_end() const { return at_end_; }

    /// What follows the surface at which the last layer ended, as a layer of no thickness.
    INSONIFY_FN layer beyond() const {
        layer after;
        start(after, found_.inside.top());
        after.end = begin_;
        after.own_begin = own_;
        return after;
    }
    /// Whether that surface belongs to the object behind it, not to the one before.
    INSONIFY_FN bool is_own() const { return own_.cosine > 0; }
    /// How the line meets that surface.
    INSONIFY_FN const surface_incidence& met() const { return met_; }
    /// Applies the crossings at that surface once more: the objects are again those before it.
    INSONIFY_FN void step_back(media_stack& inside) const {
        for (std::uint32_t i = group_; i < next_; ++i) inside.toggle(found_.room[i].rank);
    }

  private:
    // Member by member, where the layer lies: copies of what was just written in parts wait for it.
    INSONIFY_FN void start(layer& here, std::uint32_t rank) const {
        const bool is_object = rank != media_stack::none;
        here.begin = begin_;
        here.end = depth_;
        here.medium = is_object ? scene_.objects[rank].medium : 0;
        here.object = is_object ? scene_.objects[rank].id : layer{}.object;
        here.place = is_object ? 1 + rank : 0;
        here.cosine = met_.cosine;
        here.slope = met_.slope;
        here.curvature = met_.curvature;
        here.roughness = met_.roughness;
        here.own_end = {};
        here.moved = {0, 0};
    }

    // Of the touching surfaces, the first one that belongs to either medium.
    INSONIFY_FN surface_incidence incidence_at_change(std::uint32_t before, std::uint32_t after) const {
        std::uint32_t surface = group_;
        while (surface + 1 < next_ && found_.room[surface].rank != after && found_.room[surface].rank != before)
            ++surface;
        const crossing& at = found_.room[surface];
        surface_incidence met = incidence_at(line_, at.distance, scene_.objects[at.rank], at.primitive);
        const std::uint32_t owner = before < after ? before : after; // of the boundary
        const float own = scene_.media[scene_.objects[owner].medium].roughness;
        met.roughness = own > 0 ? own : -1; // one without a roughness of its own: the larger of the two media
        return met;
    }

    const scene_view& scene_;
    const Line& line_;
    line_crossings& found_;
    float depth_;
    bool incident_;
    std::uint32_t next_ = 0, group_ = 0; // crossings: the next one, and the first at the last surface
    float begin_ = 0;
    surface_incidence met_{};
    object_surface own_{}; // the last one, if it belongs to the object behind it
    bool at_end_ = false;
};

} // namespace detail

/// Finds every crossing of a line from its origin to `depth` metres, nearest first, and the objects that contain its
/// origin, by a ray through the objects' trees, all of which must be up to date.
/// @return false where they do not fit into `found`
INSONIFY_FN inline bool find_crossings(const scene_view& scene, const ray& line, float depth, line_crossings& found) {
    found.clear();
    const detail::crossing_collector collector{scene, {line.origin, line.direction, 0, depth}, depth, found};
    collector.trace({}, [&](const crossing& one) { collector.add(one); });
    found.sort();
    return found.complete();
}

/// Turns the sorted crossings of a straight line into layers.
///
/// @param depth     where the line ends, metres
/// @param room      for the layers
/// @param incident  whether to compute how the line meets surfaces (`layer::cosine` and the members after it)
/// @return          the layers, a part of `room`; none where they do not fit
template <class Line = line_frame>
INSONIFY_FN view<const layer> stack_layers(const scene_view& scene, const Line& line, float depth,
                                           line_crossings& found, view<layer> room, bool incident = true) {
    detail::layer_walk walk{scene, line, found, depth, incident};
    walk.enter_at_face();
    std::size_t count = 0;
    for (; !walk.at_end(); ++count) {
        if (count == room.size()) return {};
        walk.next(room[count]);
    }
    return found.inside.overflow ? view<const layer>{} : view<const layer>{room.data(), count};
}

/// Memory of fixed capacity in which the layers of one line are found.
struct line_room {
    line_crossings found{};            ///< its crossings, and the objects that contain its origin
    view<layer> layers{};              ///< room for its layers
    view<std::uint32_t> behind_face{}; ///< room for ranks of objects
};

namespace detail {

/// The same on the stack, for most lines.
struct short_line_memory {
    static constexpr std::size_t size = 8;
    crossing crossings[2 * size];
    std::uint32_t inside[size], behind_face[size];
    layer layers[size];

    line_room room() {
        return {
            {.room = {crossings, 2 * size}, .inside = {.ranks = {inside, size}}}, {layers, size}, {behind_face, size}};
    }
};

/// The same on the heap: allocated when it is first needed, and grows until the line fits.
struct line_memory {
    std::vector<crossing> crossings{};
    std::vector<std::uint32_t> inside{}, behind_face{};
    std::vector<layer> layers{};

    line_room room() { return {{.room = crossings, .inside = {.ranks = inside}}, layers, behind_face}; }

    void grow() {
        const std::size_t size = std::max(short_line_memory::size, 2 * layers.size());
        crossings.resize(2 * size);
        inside.resize(size);
        behind_face.resize(size);
        layers.resize(size);
    }

    /// Calls attempt(room), in larger and larger memory, until it returns true.
    template <class Attempt>
    void fit(const Attempt& attempt) {
        if (layers.empty()) grow();
        for (line_room own = room(); !attempt(own); own = room()) grow();
    }
    /// The same, first in memory of the caller, until a line has not fitted there.
    template <class Attempt>
    void fit(line_room first, const Attempt& attempt) {
        if (layers.empty() && attempt(first)) return;
        fit(attempt);
    }
};

/// What lies along a line, in the memory in which it was found.
struct found_line {
    view<const layer> layers{}; ///< none: the memory was too small
    view<const std::uint32_t>
        behind_face{}; ///< ranks of the objects that contain its origin, behind the face; ascending
};

/// Finds what lies along a straight line.
/// @param max_depth  how far it is followed, metres
/// @param incident   whether to compute how it intersects surfaces: see `stack_layers`
/// @param room       where it is found
INSONIFY_FN inline found_line find_line(const scene_view& scene, const line_frame& line, float max_depth, bool incident,
                                        const crossing_source& from, line_room& room) {
    room.found.clear();
    const crossing_collector collector{scene, {line.origin, line.path(), 0, max_depth}, max_depth, room.found};
    from.for_each(collector, [&](const crossing& one) { collector.add(one); });
    room.found.sort();
    if (!room.found.complete()) return {};
    media_stack behind_face{.ranks = room.behind_face};
    behind_face.assign(room.found.inside);
    for (const crossing& one : room.found.sorted()) {
        if (one.distance > touching_distance) break;
        behind_face.toggle(one.rank);
    }
    if (behind_face.overflow) return {};
    return {stack_layers(scene, line, max_depth, room.found, room.layers, incident),
            {behind_face.ranks.data(), behind_face.count}};
}

} // namespace detail

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
