#ifndef INSONIFY_GEOMETRY_CENTRE_LINE_HPP
#define INSONIFY_GEOMETRY_CENTRE_LINE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/geometry/pose.hpp>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// A point of the centre line of a tube, and the ellipse across it.
struct tube_section {
    vec3 centre{0, 0, 0};     ///< metres
    vec2 radii{1e-3F, 1e-3F}; ///< of the ellipse, along its two axes, metres
    float turn = 0;           ///< of its axes about the line, radians

    friend bool operator==(const tube_section&, const tube_section&) = default;
};

/// A tube at one place of its line: what a straight one would be there.
struct line_place {
    vec3 centre{0, 0, 0};      ///< on the line, metres
    vec3 along{0, 0, 1};       ///< direction of the line, of length 1
    vec3 first_axis{1, 0, 0};  ///< of the first of the radii, of length 1
    vec3 second_axis{0, 1, 0}; ///< of the second one
    vec2 radii{1e-3F, 1e-3F};  ///< of the ellipse across the line, metres

    /// The square of the distance of a point from the line over that of the wall in its direction: 1 on the wall.
    float squared(vec3 point) const {
        const vec2 away = vec2{dot(point - centre, first_axis), dot(point - centre, second_axis)} / radii;
        return dot(away, away);
    }
    float area() const { return pi * radii.x * radii.y; } ///< of the ellipse, m^2

    friend bool operator==(const line_place&, const line_place&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

namespace insonify::inline INSONIFY_ABI::detail {

/// A unit vector orthogonal to a unit vector: the least parallel coordinate axis, orthogonalized.
inline vec3 unit_across(vec3 direction) {
    const vec3 size = abs(direction);
    const vec3 axis = size.x <= size.y && size.x <= size.z ? vec3{1, 0, 0}
                      : size.y <= size.z                   ? vec3{0, 1, 0}
                                                           : vec3{0, 0, 1};
    return normalize(axis - dot(axis, direction) * direction);
}

/// @throws geometry_error  for a point that is not finite or too far away
inline void check_shape_point(const std::string& shape, vec3 p) {
    if (!is_finite(p) || abs(p) != min(abs(p), vec3{max_translation}))
        throw geometry_error{shape, ": coordinates must be finite and within 1000 km of the origin"};
}

/// @throws geometry_error  for a length that is not above 0, or too large; `what` names it
inline void check_shape_length(const std::string& shape, const std::string& what, float value) {
    if (!is_finite(value) || !(value > 0) || value > max_translation)
        throw geometry_error{shape, ": the ", what, " must be above 0 and at most 1000 km"};
}

/// The places of all sections of a line. Their axes do not twist about it: they are carried along by parallel
/// transport, and turned by `turn`. Source: Wang et al. 2008, ACM Trans. Graph. 27, 2: double reflection.
/// @param across  first axis of the first section, as far as it is across; 0: any
/// @throws geometry_error  for a line that is not a tube's
inline std::vector<line_place> places_along(const std::vector<tube_section>& line, vec3 across,
                                            const std::string& caller) {
    const std::size_t count = line.size();
    if (count < 2 || count > (1U << 20U))
        throw geometry_error{caller, ": `line` has ", count, " points; give from 2 to 1048576"};
    if (!is_finite(across))
        throw geometry_error{caller, ": `across` is not finite; give a direction across the line, or 0"};
    for (std::size_t i = 0; i < count; ++i) {
        check_shape_point(caller, line[i].centre);
        check_shape_length(caller, "first of the `radii`", line[i].radii.x);
        check_shape_length(caller, "second of the `radii`", line[i].radii.y);
        if (!is_finite(line[i].turn)) throw geometry_error{caller, ": `turn` is not finite; give radians"};
        if (i > 0 && std::fabs(line[i].turn - line[i - 1].turn) > 0.5F * pi + 1e-4F)
            throw geometry_error{caller, ": `turn` changes by more than a quarter turn at point ", i,
                                 "; add points in between"};
        if (i > 0)
            check_shape_length(caller, "distance between two points", length(line[i].centre - line[i - 1].centre));
    }

    std::vector<line_place> places(count);
    for (std::size_t i = 0; i < count; ++i) {
        const vec3 before = i > 0 ? normalize(line[i].centre - line[i - 1].centre) : vec3{0, 0, 0};
        const vec3 after = i + 1 < count ? normalize(line[i + 1].centre - line[i].centre) : vec3{0, 0, 0};
        if (!(length(before + after) > 0.1F))
            throw geometry_error{caller, ": the line turns back at point ", i, "; add points that round the bend"};
        places[i].along = normalize(before + after);
    }
    const vec3 wanted = across - dot(across, places[0].along) * places[0].along;
    places[0].first_axis = length(wanted) > 1e-4F * length(across) ? normalize(wanted) : unit_across(places[0].along);
    const auto mirrored = [](vec3 v, vec3 plane) { return v - 2 * dot(v, plane) / dot(plane, plane) * plane; };
    for (std::size_t i = 1; i < count; ++i) {
        const vec3 step = line[i].centre - line[i - 1].centre, left = mirrored(places[i - 1].along, step);
        vec3 carried = mirrored(places[i - 1].first_axis, step);
        if (const vec3 rest = places[i].along - left; dot(rest, rest) > 0) carried = mirrored(carried, rest);
        places[i].first_axis = normalize(carried - dot(carried, places[i].along) * places[i].along);
    }
    for (std::size_t i = 0; i < count; ++i) {
        line_place& own = places[i];
        const vec3 first = own.first_axis, second = cross(own.along, first);
        const float c = std::cos(line[i].turn), s = std::sin(line[i].turn);
        own.first_axis = c * first + s * second;
        own.second_axis = c * second - s * first;
        own.centre = line[i].centre;
        own.radii = line[i].radii;
    }
    return places;
}

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

/// The course of a tube that bends: sections along a line, as `make_tube` takes them. Copies are cheap, and share the
/// sections.
///
/// Every point has a place along the line: that of the cross-section on which it lies. Between two sections these
/// planes turn from one to the other; so points that move within their plane keep their place. The first and the last
/// section go on beyond the ends, straight.
class centre_line {
  public:
    /// No line.
    centre_line() = default;
    /// @param sections  at least 2, each at a point different from the one before
    /// @param across    first axis of the first section, as far as it is across; 0: any
    /// @throws geometry_error  for a line that has fewer, or turns back
    centre_line(const std::vector<tube_section>& sections, vec3 across = {0, 0, 0}) // NOLINT(*-explicit-*)
        : nodes_{
              std::make_shared<const std::vector<line_place>>(detail::places_along(sections, across, "centre_line"))} {}

    /// Whether there is no line.
    bool empty() const { return !nodes_; }
    /// The first section. The line must not be empty.
    line_place first() const { return at(0, 0); }

    /// The place of a point, on the cross-section whose centre is nearest. The line must not be empty.
    line_place place(vec3 point) const {
        const std::vector<line_place>& nodes = *nodes_;
        line_place found = at(0, min(along_segment(0, point), 0.0F));
        float nearest = FLT_MAX;
        for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
            const float part = along_segment(i, point);
            const bool is_first = i == 0, is_last = i + 2 == nodes.size();
            if ((part < 0 && !is_first) || (part > 1 && !is_last)) continue;
            const line_place one = at(i, part);
            const vec3 away = point - one.centre;
            if (const float distance = dot(away, away); distance < nearest) {
                nearest = distance;
                found = one;
            }
        }
        return found;
    }

    friend bool operator==(const centre_line& a, const centre_line& b) {
        return a.nodes_ == b.nodes_ || (a.nodes_ && b.nodes_ && *a.nodes_ == *b.nodes_);
    }

  private:
    // Where a point is between two sections: 0 to 1; below 0 and above 1 before and behind them. Its plane is that of
    // the normals of both, mixed in this ratio.
    float along_segment(std::size_t i, vec3 point) const {
        const line_place &a = (*nodes_)[i], &b = (*nodes_)[i + 1];
        const float from = dot(point - a.centre, a.along), to = dot(point - b.centre, b.along);
        if (from < 0) return from / length(b.centre - a.centre);
        if (to > 0) return 1 + to / length(b.centre - a.centre);
        return from - to > 0 ? from / (from - to) : 0;
    }

    line_place at(std::size_t i, float part) const {
        const line_place &a = (*nodes_)[i], &b = (*nodes_)[i + 1];
        const vec3 step = b.centre - a.centre;
        if (part < 0 || part > 1) {
            line_place end = part < 0 ? a : b;
            end.centre += (part < 0 ? part : part - 1) * length(step) * end.along;
            return end;
        }
        line_place made;
        const vec3 normal = a.along + part * (b.along - a.along);
        made.along = normalize(normal);
        // The centre lies on the plane of `along_segment`, which meets the straight line between both centres there.
        const float off = part * (1 - part) * (dot(step, b.along) - dot(step, a.along));
        made.centre = a.centre + part * step + off / dot(normal, normal) * normal;
        const vec3 first = a.first_axis + part * (b.first_axis - a.first_axis);
        made.first_axis = normalize(first - dot(first, made.along) * made.along);
        made.second_axis = cross(made.along, made.first_axis);
        made.radii = a.radii + part * (b.radii - a.radii);
        return made;
    }

    std::shared_ptr<const std::vector<line_place>> nodes_{};
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
