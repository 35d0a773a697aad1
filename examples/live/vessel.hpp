#ifndef INSONIFY_EXAMPLES_LIVE_VESSEL_HPP
#define INSONIFY_EXAMPLES_LIVE_VESSEL_HPP

#include <insonify/insonify.hpp>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace live {

using namespace insonify;

/// The course of a vessel: an axis that may bend, with an elliptical cross-section, found from the vertices of its mesh.
class vessel {
  public:
    object_id object{};
    float radius = 0; ///< mean, metres; 0: there is no vessel

    friend bool operator==(const vessel&, const vessel&) = default;

    vessel() = default;
    /// @param points  its vertices
    vessel(object_id id, std::span<const vec3> points) : object{id} {
        along_ = longest_axis(points);
        right_ = normalize(cross(along_, std::fabs(along_.z) < 0.8F ? vec3{0, 0, 1} : vec3{1, 0, 0}));
        up_ = cross(right_, along_);
        float last = -1e30F;
        first_ = 1e30F;
        for (const vec3& point : points) {
            first_ = std::min(first_, dot(point, along_));
            last = std::max(last, dot(point, along_));
        }
        spacing_ = std::max((last - first_) / (nodes - 1), 1e-6F);

        std::array<float, nodes> count{};
        std::array<vec3, nodes> spread{};
        const auto node_of = [&](vec3 point) { return static_cast<std::size_t>(std::lround(place(point))); };
        for (const vec3& point : points) {
            centres_[node_of(point)] += across(point);
            ++count[node_of(point)];
        }
        for (std::size_t i = 0; i < nodes; ++i) centres_[i] /= std::max(count[i], 1.0F);
        for (const vec3& point : points) {
            const std::size_t i = node_of(point);
            const vec2 away = across(point) - centres_[i];
            spread[i] += vec3{away.x * away.x, away.x * away.y, away.y * away.y} / count[i];
        }
        float filled = 0;
        for (std::size_t i = 0; i < nodes; ++i) {
            const float area = spread[i].x * spread[i].z - spread[i].y * spread[i].y;
            if (!(count[i] > 2) || !(area > 0)) {
                count[i] = 0;
                continue;
            }
            shapes_[i] = vec3{spread[i].z, -spread[i].y, spread[i].x} / (2 * area); // an outline has twice its variance
            radius += std::sqrt(2 * std::sqrt(area));
            ++filled;
        }
        radius /= std::max(filled, 1.0F);
        fill_gaps(count);
    }

    /// Its overall direction.
    vec3 axis() const { return along_; }
    /// Across it, upright as far as that is possible.
    vec3 up() const { return up_; }
    /// The point of its middle beside a point, and the direction there.
    vec3 centre(vec3 point) const {
        const vec2 middle = mixed(centres_, place(point));
        return dot(point, along_) * along_ + middle.x * right_ + middle.y * up_;
    }
    vec3 direction(vec3 point) const {
        const auto i = std::min(static_cast<std::size_t>(place(point)), nodes - 2);
        const vec2 slope = (centres_[i + 1] - centres_[i]) / spacing_;
        return normalize(along_ + slope.x * right_ + slope.y * up_);
    }
    /// 1 on the axis, 0 at the wall and outside: the parabola of laminar flow.
    float profile(vec3 point) const {
        const float where = place(point);
        const vec2 away = across(point) - mixed(centres_, where);
        const vec3 shape = mixed(shapes_, where);
        return std::max(1 - (shape.x * away.x * away.x + 2 * shape.y * away.x * away.y + shape.z * away.y * away.y),
                        0.0F);
    }

  private:
    static constexpr std::size_t nodes = 13;

    vec2 across(vec3 point) const { return {dot(point, right_), dot(point, up_)}; }
    float place(vec3 point) const {
        return std::clamp((dot(point, along_) - first_) / spacing_, 0.0F, static_cast<float>(nodes - 1));
    }
    template <class Value>
    static Value mixed(const std::array<Value, nodes>& values, float place) {
        const auto i = std::min(static_cast<std::size_t>(place), nodes - 2);
        return values[i] + (place - static_cast<float>(i)) * (values[i + 1] - values[i]);
    }

    // Nodes without vertices lie between their neighbours.
    void fill_gaps(const std::array<float, nodes>& count) {
        for (std::size_t i = 0; i < nodes; ++i) {
            if (count[i] > 0) continue;
            std::size_t before = i, after = i;
            while (before > 0 && !(count[before] > 0)) --before;
            while (after + 1 < nodes && !(count[after] > 0)) ++after;
            if (!(count[before] > 0)) before = after;
            if (!(count[after] > 0)) after = before;
            const float part =
                after == before ? 0 : static_cast<float>(i - before) / static_cast<float>(after - before);
            centres_[i] = centres_[before] + part * (centres_[after] - centres_[before]);
            shapes_[i] = shapes_[before] + part * (shapes_[after] - shapes_[before]);
        }
    }

    // The direction of the largest variance, by power iteration.
    static vec3 longest_axis(std::span<const vec3> points) {
        vec3 mean{0, 0, 0}, axis{0.3F, 1, 0.2F};
        for (const vec3& point : points) mean += point / static_cast<float>(points.size());
        for (int i = 0; i < 24; ++i) {
            vec3 next{0, 0, 0};
            for (const vec3& point : points) next += dot(point - mean, axis) * (point - mean);
            if (!(length(next) > 0)) break;
            axis = normalize(next);
        }
        return axis.x + axis.y + axis.z < 0 ? -axis : axis;
    }

    vec3 along_{0, 1, 0}, right_{1, 0, 0}, up_{0, 0, 1};
    float first_ = 0, spacing_ = 1;
    std::array<vec2, nodes> centres_{};
    std::array<vec3, nodes> shapes_{}; // of the ellipse: x, xy, y; 1 on the wall
};

/// Blood in an artery, which pulses, and in a vein, which does not and runs back: a `velocity_field`. Deformed vessels keep its
/// volume flow; but a vein that closes lets less through.
struct blood_flow {
    vessel artery{}, vein{}; ///< at rest, in coordinates of the objects
    pulsatile beat{.heart_rate = 1.2F, .resistive_index = 0.75F};
    float artery_velocity = 0.6F; ///< on the axis in systole, m/s
    float vein_velocity = 0.12F;  ///< on the axis, m/s
    float vein_opening = 1;       ///< height of the vein over its width: see `collapse::opening`

    /// Laminar flow through an ellipse, of the pressure gradient that gives 1 through a circle of its width.
    static float through(float opening) { return 2 * opening * opening * opening / (1 + opening * opening); }

    vec3 operator()(object_id object, vec3 point, float time) const {
        if (artery.radius > 0 && object == artery.object)
            return artery_velocity * beat(time) * artery.profile(point) * artery.direction(point);
        if (vein.radius > 0 && object == vein.object)
            return -vein_velocity * through(vein_opening) * vein.profile(point) * vein.direction(point);
        return {0, 0, 0};
    }
};

/// How the tissue moves, from rest: the artery pulses, the vein collapses, the face of the probe presses, and the needle drags.
/// A map for `scene::deform`, which brings its inverse: none of the four folds over, whatever the events.
struct tissue_motion {
    vessel artery{}, vein{}; ///< at rest
    pulsation beat{.amplitude = 0};
    collapse vein_wall{}; ///< `outside`: the pressure of the face
    bool pressed = false, dragged = false;
    pressed_face face{};
    needle_drag drag{};

    vec3 operator()(vec3 rest) const {
        vec3 now = rest;
        if (pulses()) now = around(beat, artery, now)(now);
        if (collapses()) now = around(vein_wall, vein, now)(now);
        if (pressed) now = face(now);
        return dragged ? drag(now) : now;
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        vec3 rest = dragged ? drag.rest_of(now) : now;
        if (pressed) rest = face.rest_of(rest);
        if (collapses()) rest = around(vein_wall, vein, rest).rest_of(rest);
        return pulses() ? around(beat, artery, rest).rest_of(rest) : rest;
    }

    friend bool operator==(const tissue_motion&, const tissue_motion&) = default;

  private:
    bool pulses() const { return beat.amplitude > 0 && artery.radius > 0; }
    bool collapses() const { return vein_wall.opening() < 1 && vein.radius > 0; }

    // The map of a straight vessel, at the place of one that bends. Such maps move a point across the axis alone, so that it
    // has the same place along the vessel before and after.
    template <class Map>
    static Map around(Map map, const vessel& bent, vec3 point) {
        map.from = bent.centre(point);
        map.to = map.from + bent.axis();
        map.radius = bent.radius;
        if constexpr (std::is_same_v<Map, collapse>) map.direction = bent.up();
        return map;
    }
};

} // namespace live

#endif
