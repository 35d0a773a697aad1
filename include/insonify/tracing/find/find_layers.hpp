#ifndef INSONIFY_TRACING_FIND_FIND_LAYERS_HPP
#define INSONIFY_TRACING_FIND_FIND_LAYERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/policy.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/find/line_layers.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <insonify/tracing/find/slice_finder.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <algorithm>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// How the crossings of straight lines with surfaces are found. All find the same, except on lines within rounding
/// error of a vertex or an edge.
enum class line_search {
    best,   ///< for each object whichever is faster
    rays,   ///< one ray for each line and plane, through the trees
    slices, ///< by slices, which need no trees; rays where the lines are neither parallel nor from one point
};

namespace detail {

/// Normals at the corners of the faces that slices cut, of surfaces whose vertices have moved. Many lines meet each of
/// these faces, and none meets the others. Keeps its memory from frame to frame.
class cut_normals {
  public:
    /// Computes them and makes the scene refer to them.
    template <exec::policy Policy>
    void compute(const Policy& policy, scene_view& scene, const slice_cut& cut) {
        if (std::none_of(scene.objects.begin(), scene.objects.end(), lacks_normals)) return;
        ++frame_;
        wanted_.clear();
        objects_.assign(scene.objects.begin(), scene.objects.end());
        if (surfaces_.size() < objects_.size()) surfaces_.resize(objects_.size());
        for (std::size_t i = 0; i < objects_.size(); ++i) {
            if (!lacks_normals(objects_[i])) continue;
            surface& own = surfaces_[i];
            own.normals.resize(objects_[i].normals.ends.size());
            own.wanted_in.resize(own.normals.size());
            objects_[i].normals.normals = own.normals;
        }
        cut.for_each_segment([&](const cut_segment& segment) {
            const object_view& one = scene.objects[segment.object];
            if (segment.again || !lacks_normals(one)) return;
            const uvec3 numbers = one.normals.corners[segment.primitive];
            for (const std::uint32_t number : {numbers.x, numbers.y, numbers.z}) {
                std::uint32_t& wanted_in = surfaces_[segment.object].wanted_in[number];
                if (wanted_in != frame_) wanted_.push_back({segment.object, number});
                wanted_in = frame_;
            }
        });
        exec::for_each_in_blocks(policy, wanted_.size(), 256, 150, [&](std::size_t i) {
            const auto [object, number] = wanted_[i];
            surfaces_[object].normals[number] =
                scene.objects[object].normals.computed(scene.objects[object].surface, number);
        });
        scene.objects = objects_;
    }

  private:
    struct surface {
        std::vector<vec3> normals;            // those of this frame are valid
        std::vector<std::uint32_t> wanted_in; // the last frame in which each was
    };
    struct wanted {
        std::uint32_t object = 0, number = 0;
    };

    static bool lacks_normals(const object_view& one) {
        return one.normals.normals.empty() && !one.normals.corners.empty();
    }

    std::uint32_t frame_ = 0;
    std::vector<object_view> objects_{};
    std::vector<surface> surfaces_{}; // of each object
    std::vector<wanted> wanted_{};
};

/// Finds the layers of all lines of a frame, for each object by slices or by rays. Keeps its memory from frame to
/// frame.
class layer_finder {
  public:
    /// Takes over the lines of a probe. @return whether slices contain them: see `slice_finder`
    bool assign(const probe_lines& probe) {
        can_cut_ = slices_.assign(probe);
        return can_cut_;
    }

    /// Chooses how each object is found, after `assign`, and cuts those for which slices pay.
    /// @param incident    whether `find` or `find_block` is to compute how lines meet surfaces
    /// @param directions  in which each line is traced
    /// @param beyond      other lines that segments are kept for
    template <exec::policy Policy>
    void prepare(const Policy& policy, const scene& body, const frame_lines& frame, line_search how, bool incident,
                 std::uint32_t directions = 1, const outer_lines& beyond = {}) {
        const view<const elevation_plane> planes{frame.plane, frame.planes};
        sliced_ = false;
        if (how != line_search::rays && can_cut_) {
            scene_ = body.view_for_slices(policy);
            sliced_ = slices_.choose(scene_, frame.at, planes, how == line_search::slices, directions);
        }
        if (sliced_) {
            slices_.cut(policy, scene_, frame.at, planes, frame.max_depth, beyond);
            if (incident) normals_.compute(policy, scene_, slices_.segments());
        } else {
            scene_ = body.view_for_rays(policy);
        }
        if (memory_.size() < blocks_of(frame.count())) memory_.resize(blocks_of(frame.count()));
    }

    /// The scene as `prepare` has seen it.
    const scene_view& scene_seen() const { return scene_; }
    /// The slices, where some objects were cut; else null: then everything is found by rays.
    const slice_finder* slices() const { return sliced_ ? &slices_ : nullptr; }
    const line_fan& fan() const { return slices_.fan(); }

    /// Nanoseconds to find the layers of a line, roughly.
    float search_time() const {
        const auto objects = static_cast<float>(scene_.objects.size());
        const float by_rays = !sliced_ || slices_.leaves_rays() ? 300 + 20 * min(objects, 64) : 0.0F;
        return by_rays + (sliced_ ? slices_.search_time() : 0.0F);
    }

    /// Begins a frame, whose blocks are then found.
    void begin(const frame_lines& frame, line_layers& found) const {
        found.begin(frame.count(), frame.planes, scene_.media);
    }
    /// Finds the layers of the block of lines that begins with one; different blocks on any threads.
    /// @param incident  whether to compute how lines meet surfaces: see `stack_layers`
    void find_block(const frame_lines& frame, std::size_t begin, bool incident, line_layers& found) {
        block_memory& own = memory_[begin / lines_per_block];
        const crossing_lists& sliced = own.sliced;
        layer_block& into = found.block_at(begin);
        const std::size_t lines = std::size_t{lines_per_block} * frame.planes;
        into.lines.clear();
        into.layers.clear();
        into.objects.clear();
        into.lines.reserve(lines);
        into.layers.reserve(4 * lines);
        if (sliced_) slices_.find_block(begin, own.sliced);
        short_line_memory memory;
        const auto count = static_cast<std::uint32_t>(begin) + lines_per_block;
        for (auto number = static_cast<std::uint32_t>(begin); number < frame.count() && number < count; ++number)
            for (std::uint32_t plane = 0; plane < frame.planes; ++plane) {
                layer_block::line& line = into.lines.emplace_back(frame, number, plane);
                const crossing_source from =
                    sliced_ ? slices_.source(sliced[slice_finder::list_of(number, plane)]) : crossing_source{};
                own.line.fit(memory.room(), [&](line_room& room) {
                    const found_line one = find_line(scene_, line.frame, frame.max_depth, incident, from, room);
                    if (one.layers.empty()) return false;
                    line.first_layer = into.layers.size(), line.layers = one.layers.size();
                    line.first_object = into.objects.size(), line.objects = one.behind_face.size();
                    into.layers.insert(into.layers.end(), one.layers.begin(), one.layers.end());
                    into.objects.insert(into.objects.end(), one.behind_face.begin(), one.behind_face.end());
                    return true;
                });
            }
    }

    /// Finds those of all lines.
    template <exec::policy Policy>
    void find(const Policy& policy, const frame_lines& frame, bool incident, line_layers& found) {
        begin(frame, found);
        exec::for_each_block(policy, frame.count(), lines_per_block, search_time() * static_cast<float>(frame.planes),
                             [&](std::size_t begin, std::size_t) { find_block(frame, begin, incident, found); });
        found.lines = frame.count();
    }

  private:
    // In which the lines of one block are found.
    struct block_memory {
        crossing_lists sliced{};
        line_memory line{};
    };

    bool can_cut_ = false, sliced_ = false;
    scene_view scene_{};
    slice_finder slices_{};
    cut_normals normals_{};
    std::vector<block_memory> memory_{}; // of each block of lines
};

/// `find_layers`, again and again: keeps its memory.
class layer_search {
  public:
    /// @param max_depth  how far the lines are followed, metres
    /// @param incident   whether to compute how they meet surfaces
    /// @return           valid until the next call
    template <exec::policy Policy, transducer Probe>
    line_layers& operator()(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                            const acquisition& scan, float max_depth, bool incident) {
        probe_.assign(probe);
        find(policy, body, at, scan, max_depth, incident);
        return found_;
    }

  private:
    template <class Policy>
    void find(const Policy& policy, const scene& body, const pose& at, const acquisition& scan, float max_depth,
              bool incident);

    probe_lines probe_{};
    layer_finder finder_{};
    line_layers found_{};
};

template <class Policy>
void layer_search::find(const Policy& policy, const scene& body, const pose& at, const acquisition& scan,
                        float max_depth, bool incident) {
    frame_lines frame{
        .lines = probe_.lines(), .at = at, .depth = scan.depth, .max_depth = max_depth, .planes = scan.planes};
    const elevation_planes planes{make_beam(probe_.settings(), scan.depth), scan.planes, scan.depth,
                                  lines_follow_depth(probe_)};
    for (std::uint32_t i = 0; i < scan.planes; ++i) frame.plane[i] = planes[i];
    finder_.assign(probe_);
    finder_.prepare(policy, body, frame, line_search::best, incident);
    finder_.find(policy, frame, incident, found_);
}

} // namespace detail

/// What lies along the lines of a probe, in every elevation plane, down to `scan.depth` metres along them.
///
///     const line_layers found = find_layers(exec::par_unseq, body, probe, at, {.depth = 40_mm, .planes = 5});
///
/// The first stage of a frame: `trace` computes echoes from the same layers, and `label`, `ground_truth`,
/// `add_near_field` and `automatic_tgc` read them. `scan.samples` has no effect.
/// @param at  probe to world: x lateral, y elevation, z depth
/// @throws usage_error     for a scene that was not built, or settings out of range
/// @throws geometry_error  for a pose that is not rigid
template <exec::policy Policy, transducer Probe>
line_layers find_layers(const Policy& policy, const scene& body, const Probe& probe, const pose& at,
                        const acquisition& scan) {
    detail::check_lines(body, probe.frequency, at, scan.depth, "find_layers");
    detail::check_planes(scan.planes, "find_layers");
    return std::move(
        detail::layer_search{}(detail::any_policy<false>{policy}, body, probe, at, scan, scan.depth, true));
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
