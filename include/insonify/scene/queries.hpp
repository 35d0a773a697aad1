#ifndef INSONIFY_SCENE_QUERIES_HPP
#define INSONIFY_SCENE_QUERIES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

/// Queries for contact, collision and placement. Distances are metres, points and directions in the world.
///
/// All may be called from many threads at once. The first query after objects have moved refits their trees; where that
/// takes too long, as in a haptic loop, query a snapshot: see `scene_snapshots`.
namespace insonify::inline INSONIFY_ABI {

/// A point on the surface of an object.
struct surface_point {
    object_id object{};     ///< whose surface it is
    std::uint32_t face = 0; ///< index into `object::surface.faces`
    float distance = 0;     ///< from the origin of the ray, in units of its direction, or from the point of the query
    vec3 point{0, 0, 0};    ///< in the world
    vec3 normal{0, 0, 1};   ///< of the face, outwards, length 1
};

/// Accepts every object.
struct any_object {
    /// Always true.
    constexpr bool operator()(object_id) const { return true; }
};

/// Accepts none.
struct no_object {
    /// Always false.
    constexpr bool operator()(object_id) const { return false; }
};

namespace detail {

inline surface_point surface_point_at(const object_view& one, std::uint32_t face, float distance, vec3 point) {
    const vec3 normal = unit_normal(one.surface[face], {0, 0, 1});
    return {object_id{one.id}, face, distance, point, one.at.direction(normal)};
}

/// Whether an object contains a point: a half line from there crosses its surface an odd number of times.
inline bool contains(const object_view& one, vec3 point) {
    bool inside = false;
    one.tree.for_each_hit(one.local({.origin = point}), [&](const hit&) { inside = !inside; });
    return inside;
}

/// The object whose medium applies at a point; null in the background.
inline const object_view* top_at(const scene_view& flat, vec3 point) {
    std::uint32_t top = media_stack::none;
    flat.boxes.for_each_overlap(aabb{point, point}, [&](std::uint32_t rank) {
        if (rank < top && contains(flat.objects[rank], point)) top = rank;
    });
    return top == media_stack::none ? nullptr : &flat.objects[top];
}

/// @throws usage_error  for a ray that would miss everything
inline void check_ray(const ray& r, const char* caller) {
    const vec3 along = abs(r.direction);
    if (!is_finite(r.origin) || !is_finite(r.direction) || !(max(along.x, max(along.y, along.z)) > 1e-30F) ||
        !is_number(r.min_distance) || !is_number(r.max_distance))
        throw usage_error{
            caller, ": the ray needs a finite origin, a finite direction that is not 0, and limits that are not NaN"};
}

/// Follows a straight line through the media of a scene: in_layer(length, stretch) is called for each layer, metres and
/// displayed metres per metre, until it returns false.
template <class InLayer>
void follow_displayed(const scene& body, const ray& line, float depth, const char* caller, const InLayer& in_layer) {
    check_ray(line, caller);
    check_depth(depth, caller);
    const scene_view flat = body.view_for_rays(exec::par);
    const vec3 size = abs(line.direction), scaled = line.direction / max(max(size.x, size.y), size.z);
    const line_frame along{.origin = line.origin, .along = scaled / length(scaled)};
    line_memory{}.fit([&](line_room& room) {
        const view<const layer> layers = find_line(flat, along, depth, false, {}, room).layers;
        for (const layer& one : layers)
            if (!in_layer(one.end - one.begin, displayed_stretch(flat.media[one.medium]))) break;
        return !layers.empty();
    });
}

} // namespace detail

/// The object that gives the medium at a point; none in the background.
/// @throws usage_error  for a point that is not finite, or a scene that was not built
inline std::optional<object_id> object_at(const scene& body, vec3 point) {
    detail::check_point(point, "object_at");
    const object_view* one = detail::top_at(body.view_for_rays(exec::par), point);
    return one == nullptr ? std::nullopt : std::optional{object_id{one->id}};
}

/// The medium at a point: that of `object_at`, or the background's.
/// @throws usage_error  for a point that is not finite, or a scene that was not built
inline medium medium_at(const scene& body, vec3 point) {
    detail::check_point(point, "medium_at");
    const scene_view flat = body.view_for_rays(exec::par);
    const object_view* one = detail::top_at(flat, point);
    return flat.media[one == nullptr ? 0 : one->medium];
}

/// The first surface along a ray, within its limits, from either side; none where there is none.
///
///     const auto skin = first_surface(body, {tip, {0, 0, 1}}, [&](object_id id) { return id != needle; });
///
/// Of surfaces that touch, any may be reported: their distances differ by rounding errors.
/// @param accepts  bool(object_id): objects for which it returns false are passed through
/// @throws usage_error  for an origin or a direction that is not finite, a direction of length 0, a limit that is NaN,
///                      or a scene that was not built
template <std::predicate<object_id> Filter = any_object>
std::optional<surface_point> first_surface(const scene& body, const ray& r, const Filter& accepts = {}) {
    detail::check_ray(r, "first_surface");
    const scene_view flat = body.view_for_rays(exec::par);
    hit first;
    std::uint32_t rank = 0;
    flat.boxes.for_each_hit(r, [&](const hit& box) {
        const object_view& one = flat.objects[box.primitive];
        if (box.distance > first.distance || !accepts(object_id{one.id})) return;
        ray local = one.local(r);
        local.max_distance = min(local.max_distance, first.distance);
        const hit found = one.tree.closest(local);
        if (!found || (first && !(found.distance < first.distance || box.primitive < rank))) return;
        first = found;
        rank = box.primitive;
    });
    if (!first) return std::nullopt;
    return detail::surface_point_at(flat.objects[rank], first.primitive, first.distance, r.at(first.distance));
}

/// The point of an object's surface that is nearest to a point; none for an object without faces.
/// @throws usage_error  for an unknown id, a point that is not finite, or a scene that was not built
inline std::optional<surface_point> nearest_surface(const scene& body, object_id id, vec3 point) {
    detail::check_point(point, "nearest_surface");
    static_cast<void>(body[id]); // throws for an unknown id
    const scene_view flat = body.view_for_rays(exec::par);
    for (const object_view& one : flat.objects) {
        if (one.id != static_cast<std::uint32_t>(id)) continue;
        const detail::nearest_point found = detail::find_nearest(one.tree, one.at.local_point(point));
        if (found.primitive == detail::nearest_point{}.primitive) return std::nullopt;
        return detail::surface_point_at(one, found.primitive, std::sqrt(found.distance_squared),
                                        one.at.point(found.point));
    }
    return std::nullopt;
}

/// Depth at which an echo is displayed, metres: c0 t / 2 with c0 = 1540 m/s, as `physical` does, from the true depth
/// along a straight line.
///
///     shown = sum over the media along the line of d c0 / c
///
///     const float shown = displayed_depth(body, {at.point(beam.origin), at.direction(beam.direction)}, 20_mm);
///
/// Refraction and the shadows of obstacles are left out: see `physical`.
/// @param line   from the face of the probe, in the world; its limits are not used
/// @param depth  true one, metres along the line
/// @throws usage_error  for a scene that was not built, a line or a depth out of range
inline float displayed_depth(const scene& body, const ray& line, float depth) {
    double shown = 0;
    detail::follow_displayed(body, line, depth, "displayed_depth", [&](float part, float stretch) {
        shown += static_cast<double>(part) * static_cast<double>(stretch);
        return true;
    });
    return static_cast<float>(shown);
}

/// The inverse of `displayed_depth`: the true depth along a line of what a scanner displays at a depth, such as that of
/// `scan_map::point`, metres.
/// @throws usage_error  as `displayed_depth`
inline float true_depth(const scene& body, const ray& line, float shown) {
    check_depth(shown, "true_depth");
    float fastest = display_speed;
    for (const medium& m : body.media()) fastest = max(fastest, m.sound_speed);
    double depth = 0, left = static_cast<double>(shown);
    const float farthest = min(shown * fastest / display_speed * 1.001F, max_scan_depth);
    detail::follow_displayed(body, line, farthest, "true_depth", [&](float part, float stretch) {
        const double here = std::fmin(static_cast<double>(part), left / static_cast<double>(stretch));
        depth += here;
        left -= here * static_cast<double>(stretch);
        return left > 0;
    });
    return static_cast<float>(depth);
}

/// The surfaces of a scene at one frame, with trees that fit them.
struct scene_snapshot {
    std::uint64_t frame = 0;                     ///< its number
    scene body;                                  ///< to be queried
    mutable std::atomic<std::uint32_t> users{0}; ///< handles to it
};

/// Snapshots of a scene that moves, for queries by other threads, such as a haptic loop at 1 kHz. Lock-free.
///
///     scene_snapshots frozen{body};            // copies of a scene that is built
///     frozen.take(exec::seq, body, frame);     // simulation, each frame after `update` or `deform`: copies what moved
///     frozen.publish(exec::par);               // any thread: refits the trees
///     const auto now = frozen.newest();        // haptics: does not wait for either
///     first_surface(now->body, along);         // as of now->frame, for as long as `now` is held
///
/// One thread may take, one may publish, and up to `readers` may each hold a handle, all at once. Allocates only the
/// first times that an object moves. Snapshots follow the surfaces only: use the scene itself for `rest_of` and for
/// pictures of a deformed body.
class scene_snapshots {
  public:
    /// Gives a handle back.
    struct release {
        /// @param held  that it is of
        void operator()(const scene_snapshot* held) const { --held->users; }
    };
    /// A snapshot that stays as it is until the handle is destroyed, which must be before the `scene_snapshots`.
    using handle = std::unique_ptr<const scene_snapshot, release>;

    /// Copies the scene 2 + `readers` times. Make other snapshots after `build` or `set_medium`.
    /// @throws usage_error  for a scene that was not built
    explicit scene_snapshots(const scene& body, std::uint64_t frame = 0, std::uint32_t readers = 1) {
        for (std::uint32_t i = 0; i < readers + 2; ++i) {
            copies_.push_back(std::unique_ptr<scene_snapshot>{new scene_snapshot{.frame = frame, .body = body}});
            static_cast<void>(copies_.back()->body.view_for_rays(exec::par)); // refits the trees
        }
        newest_ = copies_[0].get();
    }

    /// Copies what has moved. The scene must not change meanwhile.
    /// @return  whether it did: false while the frame before waits for `publish`, or more than `readers` handles are held
    /// @throws usage_error     for a scene with other objects
    /// @throws geometry_error  for a vertex that is not finite
    template <exec::policy Policy>
    bool take(const Policy& policy, const scene& body, std::uint64_t frame) {
        if (taken_ != nullptr) return false;
        const auto spare = std::find_if(copies_.begin(), copies_.end(),
                                        [&](const auto& one) { return one.get() != newest_ && one->users == 0; });
        if (spare == copies_.end()) return false;
        scene& own = (*spare)->body;
        const std::vector<object>& objects = body.objects();
        const auto matches = [](const object& a, const object& b) {
            return a.id == b.id && a.surface.positions.size() == b.surface.positions.size();
        };
        if (!std::equal(objects.begin(), objects.end(), own.objects().begin(), own.objects().end(), matches))
            throw usage_error{
                "scene_snapshots: the scene has other objects than when the snapshots were made; make new "
                "ones after add or remove"};
        for (std::size_t i = 0; i < objects.size(); ++i) {
            const object &now = objects[i], &before = own.objects()[i];
            if (now.at != before.at) own.place(now.id, now.at);
            if (now.surface.positions == before.surface.positions) continue;
            std::copy(now.surface.positions.begin(), now.surface.positions.end(), own.positions(now.id).begin());
        }
        own.update(policy);
        (*spare)->frame = frame;
        taken_ = spare->get();
        return true;
    }

    /// Refits the trees of the frame that was taken, which is the newest afterwards. @return  whether there was one
    template <exec::policy Policy>
    bool publish(const Policy& policy) {
        scene_snapshot* const next = taken_;
        if (next == nullptr) return false;
        static_cast<void>(next->body.view_for_rays(policy));
        newest_ = next;
        taken_ = nullptr;
        return true;
    }

    /// The newest frame that was published.
    handle newest() const {
        for (;;) {
            const scene_snapshot* const found = newest_;
            ++found->users;
            handle held{found};
            if (found == newest_) return held; // else it may be overwritten
        }
    }

  private:
    std::vector<std::unique_ptr<scene_snapshot>> copies_{};
    std::atomic<scene_snapshot*> newest_{nullptr}, taken_{nullptr};
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
