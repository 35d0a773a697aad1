#ifndef INSONIFY_TRACING_FIND_SLICE_CUT_HPP
#define INSONIFY_TRACING_FIND_SLICE_CUT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/for_each.hpp>
#include <insonify/scene/scene_view.hpp>
#include <insonify/tracing/find/cut_faces.hpp>
#include <insonify/tracing/find/mixed_faces.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI::detail {

/// The intersection of a slice with a face: the segment from one of its edges to another, and the lines that cross it.
struct cut_segment {
    vec2 from{0, 0}, to{0, 0}; ///< in the coordinates of the fan
    std::uint32_t first = 0;   ///< the lines that cross it are [first, last)
    std::uint32_t last = 0;
    bool again = false;          ///< the same segment as the one before, with other lines
    std::uint32_t slice = 0;     ///< its number
    std::uint32_t object = 0;    ///< rank of the object
    std::uint32_t primitive = 0; ///< face of the object's mesh
};

/// Lines beyond those of a fan: between the first and the last of a wider one, from the same point, shifted along the face by at
/// most a distance.
struct outer_lines {
    const line_fan* fan = nullptr; ///< null: none
    float shift = 0;               ///< metres
};

/// All segments in which the slices of a frame intersect a scene. Keeps its memory from frame to frame.
///
/// Trees that are up to date are traversed with the region that the lines cover. For the other objects two linear passes
/// compute the level of every vertex and compare levels in every group of faces, whatever the number of slices.
class slice_cut {
  public:
    /// @param chosen    for each object, whether it is to be cut
    /// @param probe_at  the frame in whose plane y = 0 the lines of the fan run
    /// @param planes    the slices
    /// @param max_depth  how far lines are followed, metres
    /// @param keep_all   also keep segments that cross no line
    /// @param beyond     lines that the segments are kept for, too
    template <exec::policy Policy>
    void cut(const Policy& policy, const scene_view& scene, view<const std::uint8_t> chosen, const line_fan& fan,
             const pose& probe_at, view<const detail::elevation_plane> planes, float max_depth, bool keep_all,
             const outer_lines& beyond) {
        keep_all_ = keep_all;
        plan(scene, chosen, fan, probe_at, planes, max_depth, beyond);
        exec::for_each_block(policy, vertex_parts_.size(), 1, 0.5F * block, [&](std::size_t i, std::size_t) {
            const part& own = vertex_parts_[i];
            const object_view& one = scene.objects[own.object];
            find_levels(own.region->frame.local(one.at),
                        {one.surface.positions.data() + own.begin, own.end - own.begin},
                        levels_.data() + own.levels + own.begin);
        });
        const float nanoseconds = 5 * static_cast<float>(work_) / static_cast<float>(face_parts_.size() + 1);
        exec::for_each_block(policy, face_parts_.size(), 1, nanoseconds,
                             [&](std::size_t i, std::size_t) { cut_part(scene, fan, face_parts_[i], found_[i]); });
    }

    /// Calls visit(segment) for each segment, in an order that depends on the arguments of `cut` alone.
    template <class Visit>
    void for_each_segment(Visit&& visit) const {
        for (std::size_t i = 0; i < face_parts_.size(); ++i)
            for (const cut_segment& segment : found_[i]) visit(segment);
    }

  private:
    static constexpr std::uint32_t block = 8192; // vertices or faces that one thread processes at a time
    static constexpr std::uint32_t groups_of_block = block / detail::face_groups_view::size;

    static constexpr std::size_t max_subtrees = 32; // that one object's tree is divided into, roughly

    // A work item: a subtree of an object, or a range of its vertices or groups of faces.
    struct part {
        const slice_region* region = nullptr;
        std::uint32_t object = 0;
        std::uint32_t begin = 0, end = 0; // the reference of the subtree in `begin`; or a range
        std::size_t levels = 0;           // offset of the object's vertex levels
    };

    // Collects the work items, in the order in which `for_each_segment` visits their results.
    void plan(const scene_view& scene, view<const std::uint8_t> chosen, const line_fan& fan, const pose& probe_at,
              view<const detail::elevation_plane> planes, float max_depth, const outer_lines& beyond) {
        const float beside = beyond.shift;
        aabb face; // of the probe
        for (const detail::elevation_plane& plane : planes)
            for (const float x : {fan.extent().min.x - beside, fan.extent().max.x + beside})
                for (const float y : {fan.extent().min.y - beside, fan.extent().max.y + beside}) {
                    const vec3 corner = fan.upright().point({x, 0, y});
                    face = merged(face, probe_at.point({corner.x, plane.height(corner.z), corner.z}));
                }
        const vec3 rounding = 1e-6F * (abs(face.lower) + abs(face.upper));
        face = {face.lower - rounding, face.upper + rounding};
        const line_fan& widest = beyond.fan != nullptr ? *beyond.fan : fan;
        unbounded_ = {slice_frame{probe_at, planes, fan.upright()}, widest, beside};
        within_depth_ = unbounded_.within(max_depth + beside, fan);

        vertex_parts_.clear();
        face_parts_.clear();
        work_ = 0;
        std::size_t levels = 0;
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
            if (chosen[i] == 0) continue;
            const object_view& one = scene.objects[i];
            // Lines that start inside an object are followed until they leave it.
            const slice_region& region = overlaps(face, one.box) ? unbounded_ : within_depth_;
            if (!overlaps(region, one.box)) continue;
            const auto vertices = static_cast<std::uint32_t>(one.surface.positions.size());
            const auto faces = static_cast<std::uint32_t>(one.surface.faces.size());
            if (one.tree_is_current) {
                add_subtrees(one, i, region);
                work_ += 16 * static_cast<std::size_t>(std::sqrt(static_cast<float>(faces)));
                continue;
            }
            for (std::uint32_t begin = 0; begin < vertices; begin += block)
                vertex_parts_.push_back({&region, i, begin, std::min(begin + block, vertices), levels});
            const auto groups = static_cast<std::uint32_t>(one.groups.count());
            for (std::uint32_t begin = 0; begin < groups; begin += groups_of_block)
                face_parts_.push_back({&region, i, begin, std::min(begin + groups_of_block, groups), levels});
            levels += vertices;
            work_ += faces;
        }
        levels_.resize(levels);
        if (found_.size() < face_parts_.size()) found_.resize(face_parts_.size());
    }

    // Divides the tree of an object, level by level, into subtrees for several threads.
    void add_subtrees(const object_view& one, std::uint32_t index, const slice_region& region) {
        const bvh_view<mesh_view>& tree = one.tree;
        if (tree.nodes.empty()) return;
        const slice_region local = region.local(one.at);
        subtrees_.assign(1, 0);
        bool divisible = one.surface.faces.size() >= block;
        while (divisible && subtrees_.size() < max_subtrees / 2) {
            divisible = false;
            below_.clear();
            for (const std::uint32_t code : subtrees_) {
                if ((code & leaf_bit) != 0) {
                    below_.push_back(code);
                    continue;
                }
                divisible = true;
                for_each_child(tree, code, local, [&](std::uint32_t child) { below_.push_back(child); });
            }
            subtrees_.swap(below_);
        }
        for (const std::uint32_t code : subtrees_) face_parts_.push_back({&region, index, code});
    }

    void cut_part(const scene_view& scene, const line_fan& fan, const part& own,
                  std::vector<cut_segment>& found) const {
        const object_view& one = scene.objects[own.object];
        const slice_region region = own.region->local(one.at);
        found.clear();
        const auto cut = [&](const auto& faces) {
            using corner = slice_corner<simd_width>;
            const auto keep = [&](std::uint32_t slice, std::uint32_t cut_ones, const corner& from, const corner& to) {
                float ends[4][simd_width];
                const lanes<simd_width>* const of_ends[4] = {&from.across, &from.along, &to.across, &to.along};
                for (int i = 0; i < 4; ++i) store(*of_ends[i], ends[i]);
                const auto places_from = fan.places_of<simd_width>(from.across, from.along);
                const auto places_to = fan.places_of<simd_width>(to.across, to.along);
                for (; cut_ones != 0; cut_ones &= cut_ones - 1) {
                    const std::uint32_t i = detail::lowest_bit(cut_ones);
                    const vec2 p{ends[0][i], ends[1][i]}, q{ends[2][i], ends[3][i]};
                    cut_segment segment{
                        .from = p, .to = q, .slice = slice, .object = own.object, .primitive = faces.primitive[i]};
                    fan.for_each_crossed(p, fan.gap(places_from, i), q, fan.gap(places_to, i),
                                         [&](std::uint32_t first, std::uint32_t last) {
                                             segment.first = first;
                                             segment.last = last;
                                             found.push_back(segment);
                                             segment.again = true;
                                         });
                    if (keep_all_ && !segment.again) found.push_back(segment);
                }
            };
            cut_faces(region.frame, faces, keep);
        };
        if (one.tree_is_current) {
            for_each_leaf(one.tree, own.begin, region, cut);
        } else {
            const mesh_view& surface = one.surface;
            leaf<mesh_view, simd_width> faces;
            std::uint32_t slots[simd_width], held = 0;
            const auto cut_held = [&] {
                std::fill(slots + held, slots + simd_width, no_primitive);
                faces.fill(surface, slots);
                cut(faces);
                held = 0;
            };
            for_each_mixed(surface.faces, one.groups, own.begin, own.end, levels_.data() + own.levels,
                           [&](std::uint32_t primitive) {
                               slots[held++] = primitive;
                               if (held == simd_width) cut_held();
                           });
            if (held > 0) cut_held();
        }
    }

    bool keep_all_ = false;
    slice_region unbounded_{}, within_depth_{};
    std::vector<part> vertex_parts_, face_parts_;
    std::vector<std::uint32_t> subtrees_, below_;
    std::vector<std::uint8_t> levels_;
    std::vector<std::vector<cut_segment>> found_;
    std::size_t work_ = 0; // faces to be tested, roughly
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
