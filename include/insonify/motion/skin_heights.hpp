#ifndef INSONIFY_MOTION_SKIN_HEIGHTS_HPP
#define INSONIFY_MOTION_SKIN_HEIGHTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/mesh.hpp>
#include <insonify/motion/pressed_face.hpp>
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Where lines along z through the points of a probe's face leave a body that consists of several surfaces. Keeps its memory.
class skin_heights {
  public:
    /// Begins a body. @param face  its pose, edges and heights
    void begin(const pressed_face& face) {
        face_ = face;
        intervals_.clear();
        std::fill(std::begin(depth_), std::end(depth_), 0.0F);
        std::fill(std::begin(gap_), std::end(gap_), FLT_MAX);
    }

    /// Adds a closed surface of the body. @param to_world  of its positions
    void add(std::span<const uvec3> faces, std::span<const vec3> positions, const pose& to_world) {
        const pose to_face = inverse(face_.at) * to_world;
        points_.clear();
        for (const vec3& p : positions) points_.push_back(to_face.point(p));
        crossings_.clear();
        for (const uvec3& corner : faces) find_crossings({points_[corner.x], points_[corner.y], points_[corner.z]});
        std::sort(crossings_.begin(), crossings_.end(), [](const crossing& a, const crossing& b) {
            return a.sample != b.sample ? a.sample < b.sample : a.behind < b.behind;
        });
        for (std::size_t i = 0; i < crossings_.size();) i = add_intervals(i);
    }

    /// Finishes the body: `depth` may be called.
    void finish() {
        std::sort(intervals_.begin(), intervals_.end(), [](const interval& a, const interval& b) {
            return a.sample != b.sample ? a.sample < b.sample : a.from < b.from;
        });
        constexpr float touching = 10e-6F; // layers that touch are one body
        for (const interval& one : intervals_) {
            float& depth = depth_[one.sample];
            if (one.from <= max(depth, 0) + touching) depth = max(depth, one.to);
        }
        for (std::size_t i = 0; i < samples; ++i)
            if (depth_[i] == 0) depth_[i] = -gap_[i];
    }

    /// How deep a point of the face is below the skin, metres; below 0: how far in front of the face the skin is.
    float depth(std::size_t row, std::size_t column) const { return depth_[row * pressed_face::columns + column]; }

  private:
    static constexpr std::size_t samples = pressed_face::rows * pressed_face::columns;
    struct crossing {
        std::size_t sample;
        float behind; // the face, metres; below 0: in front of it
    };
    struct interval { // inside of a surface, metres behind the face
        std::size_t sample;
        float from, to;
    };

    // The intervals of one sample, whose crossings begin here. @return  where those of the next one begin
    std::size_t add_intervals(std::size_t i) {
        const std::size_t sample = crossings_[i].sample;
        bool inside = false;
        float from = 0;
        for (; i < crossings_.size() && crossings_[i].sample == sample; ++i) {
            const float behind = crossings_[i].behind;
            if (behind < 0)
                gap_[sample] = min(gap_[sample], -behind);
            else if (inside)
                intervals_.push_back({sample, from, behind});
            inside = !inside;
            from = max(behind, 0);
        }
        return i;
    }

    void find_crossings(const triangle& t) {
        const vec3 lower = min(min(t.a, t.b), t.c), upper = max(max(t.a, t.b), t.c);
        const float half = 0.5F * face_.elevation;
        if (upper.x < face_.left || lower.x > face_.right || upper.y < -half || lower.y > half) return;
        const vec3 normal = cross(t.b - t.a, t.c - t.a);
        if (normal.z == 0) return;
        const span_of_points columns =
            points_between(lower.x, upper.x, face_.left, face_.right - face_.left, pressed_face::columns);
        const span_of_points rows = points_between(lower.y, upper.y, -half, face_.elevation, pressed_face::rows);
        for (std::size_t row = rows.first; row <= rows.last; ++row)
            for (std::size_t i = columns.first; i <= columns.last; ++i) {
                const float x =
                    face_.left + (face_.right - face_.left) * static_cast<float>(i) / (pressed_face::columns - 1);
                const float y = face_.elevation * (static_cast<float>(row) / (pressed_face::rows - 1) - 0.5F);
                if (!is_above(t, x, y)) continue;
                const float z = t.a.z + (normal.x * (t.a.x - x) + normal.y * (t.a.y - y)) / normal.z;
                crossings_.push_back({row * pressed_face::columns + i, face_.height[i] - z});
            }
    }

    // The points of the face, along one axis of it, that may lie between two coordinates.
    struct span_of_points {
        std::size_t first, last;
    };
    static span_of_points points_between(float low, float high, float from, float size, std::size_t count) {
        constexpr float rounding = 0.01F;
        const auto last = static_cast<float>(count - 1);
        if (!(size > 0)) return {0, count - 1};
        return {static_cast<std::size_t>(clamp(std::floor((low - from) / size * last - rounding), 0, last)),
                static_cast<std::size_t>(clamp(std::ceil((high - from) / size * last + rounding), 0, last))};
    }

    // Whether a line along z crosses a triangle. Edges are half-open: a line through an edge or a vertex crosses one face.
    static bool is_above(const triangle& t, float x, float y) {
        const vec3 corners[] = {t.a, t.b, t.c};
        bool odd = false;
        for (int i = 0; i < 3; ++i) {
            const vec3 &a = corners[i], &b = corners[(i + 1) % 3];
            if ((a.y > y) == (b.y > y)) continue;
            const vec3 &low = a.y < b.y ? a : b, &high = a.y < b.y ? b : a;
            if (x < low.x + (y - low.y) / (high.y - low.y) * (high.x - low.x)) odd = !odd;
        }
        return odd;
    }

    pressed_face face_{};
    std::vector<vec3> points_{};
    std::vector<crossing> crossings_{};
    std::vector<interval> intervals_{};
    float depth_[samples] = {};
    float gap_[samples] = {};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
