#ifndef INSONIFY_TRACING_APERTURE_TURNED_CROSSINGS_HPP
#define INSONIFY_TRACING_APERTURE_TURNED_CROSSINGS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/line_fan.hpp>
#include <insonify/tracing/aperture/turned_line.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <insonify/tracing/find/slice_finder.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Points in the coordinates of a fan, one in each lane.
struct point_lanes {
    using floats = lanes<simd_width>;
    floats x, y;
};

/// The segments of one slice by the sum of the depths of their ends, which lie in flat arrays so that a register takes
/// several. Keeps its memory from frame to frame.
class slice_segments {
  public:
    static constexpr int width = simd_width;

    void clear() { order_.clear(); }
    void add(const cut_segment& one) { order_.push_back({one.from.y + one.to.y, &one}); }
    /// Sorts the segments, after the last was added.
    void sort() {
        std::sort(order_.begin(), order_.end(), [](const deep& a, const deep& b) { return a.depth < b.depth; });
        const std::size_t padded = (order_.size() + width - 1) / width * width;
        for (std::vector<float>& ends : ends_) ends.assign(padded, 0);
        for (std::size_t i = 0; i < order_.size(); ++i) {
            const cut_segment& one = *order_[i].segment;
            ends_[0][i] = one.from.x, ends_[1][i] = one.from.y, ends_[2][i] = one.to.x, ends_[3][i] = one.to.y;
        }
    }

    std::size_t size() const { return order_.size(); }
    const cut_segment& operator[](std::size_t i) const { return *order_[i].segment; }

    /// The ends of `width` segments from the i-th on; behind the last, 0.
    point_lanes from(std::size_t i) const { return {load<width>(&ends_[0][i]), load<width>(&ends_[1][i])}; }
    point_lanes to(std::size_t i) const { return {load<width>(&ends_[2][i]), load<width>(&ends_[3][i])}; }

  private:
    struct deep {
        float depth = 0;
        const cut_segment* segment = nullptr;
    };
    std::vector<deep> order_{};
    std::vector<float> ends_[4] = {};
};

/// The lines of a fan, all turned or shifted alike, and the segments of slices that they cross.
class turned_fan {
  public:
    void assign(const line_fan& fan, const line_turn& turn) {
        turn_ = turn;
        const std::uint32_t padded = fan.size() + simd_width;
        for (std::vector<float>& each : lines_) each.resize(padded);
        const vec2 shift = turn.shift * turn.face.across;
        for (std::uint32_t i = 0; i < padded; ++i) {
            const line_fan::line& line = fan[std::min(i, fan.size() - 1)];
            const vec2 turned{line.along.x * turn.cosine + line.along.y * turn.sine,
                              line.along.y * turn.cosine - line.along.x * turn.sine};
            const vec2 origin = line.origin + shift, along = turn.is_shift() ? line.along : turned;
            lines_[0][i] = origin.x, lines_[1][i] = origin.y, lines_[2][i] = along.x, lines_[3][i] = along.y;
        }
    }

    /// The lines from `first` on; the last line fills the lanes beyond it.
    line_fan::neighbours<simd_width> from(std::uint32_t first) const {
        const auto at = [&](int k) { return load<simd_width>(lines_[k].data() + first); };
        return {at(0), at(1), at(2), at(3)};
    }

    /// Calls visit(segment, first, last): the lines [first, last) cross the segment, in the order of the segments.
    template <class Visit>
    void for_each_crossed(const line_fan& straight, const slice_segments& segments, const Visit& visit) const {
        constexpr int width = simd_width;
        for (std::size_t begin = 0; begin < segments.size(); begin += width) {
            const point_lanes from = segments.from(begin), to = segments.to(begin);
            const point_lanes first = straightened(from), last = straightened(to);
            const auto places_first = straight.places_of<width>(first.x, first.y),
                       places_last = straight.places_of<width>(last.x, last.y);
            const std::uint32_t divided = divided_ones(from, to);
            float ends[4][width];
            store(first.x, ends[0]), store(first.y, ends[1]), store(last.x, ends[2]), store(last.y, ends[3]);
            const std::size_t end = std::min<std::size_t>(width, segments.size() - begin);
            for (std::uint32_t i = 0; i < end; ++i) {
                const cut_segment& one = segments[begin + i];
                const vec2 p{ends[0][i], ends[1][i]}, q{ends[2][i], ends[3][i]};
                const std::uint32_t gap_p = straight.gap(places_first, i), gap_q = straight.gap(places_last, i);
                const auto add = [&](std::uint32_t from_line, std::uint32_t to_line) {
                    visit(one, from_line, to_line);
                };
                if ((divided >> i & 1U) == 0) {
                    straight.for_each_crossed(p, gap_p, q, gap_q, add);
                    continue;
                }
                for_each_outer_part(one.from, one.to, [&](vec2 a, vec2 b) {
                    const vec2 a_moved = a == one.from ? p : straightened(a),
                               b_moved = b == one.to ? q : straightened(b);
                    straight.for_each_crossed(a_moved, a == one.from ? gap_p : straight.gap(a_moved), b_moved,
                                              b == one.to ? gap_q : straight.gap(b_moved), add);
                });
            }
        }
    }

  private:
    // Moves points across the lines so that the turned line through each becomes the straight one: what a turned line
    // crosses is what the straight one crosses after points were moved.
    INSONIFY_INLINE point_lanes straightened(const point_lanes& p) const {
        using floats = point_lanes::floats;
        const face_shape& face = turn_.face;
        if (turn_.is_shift()) {
            const vec2 shift = turn_.shift * face.across;
            return {p.x - floats(shift.x), p.y - floats(shift.y)};
        }
        const floats sine(turn_.sine), cosine(turn_.cosine);
        if (face.form == face_form::plane) {
            const floats depth = p.y - floats(face.incline) * p.x;
            return {p.x - depth * (sine / floats(turn_.depth_per_metre())), p.y};
        }
        // By the angle of `line_turn::around`.
        const floats one(1.0F), distance = sqrt(p.x * p.x + p.y * p.y);
        const floats a = max(min(floats(face.radius * turn_.sine) / max(distance, floats(1e-9F)), one), -one),
                     b = sqrt(one - a * a);
        const floats by_x = sine * b - cosine * a, by_y = cosine * b + sine * a;
        return {p.x * by_y - p.y * by_x, p.x * by_x + p.y * by_y};
    }
    vec2 straightened(vec2 p) const {
        const point_lanes moved = straightened(point_lanes{point_lanes::floats(p.x), point_lanes::floats(p.y)});
        float x[simd_width], y[simd_width];
        store(moved.x, x);
        store(moved.y, y);
        return {x[0], y[0]};
    }

    // Of the circle around the apex that lines from a round face, prolonged backwards, touch: they run outside it.
    float inner_radius() const { return turn_.face.radius * std::fabs(turn_.sine); }

    // Calls visit(from, to) for the parts of a segment that `straightened` keeps in order: those outside that circle;
    // inside, a segment would pass the apex on the other side.
    template <class Visit>
    void for_each_outer_part(vec2 from, vec2 to, const Visit& visit) const {
        const float radius = inner_radius();
        const vec2 along = to - from;
        const float a = dot(along, along), b = dot(from, along), c = dot(from, from) - radius * radius;
        const float root = b * b - a * c;
        if (radius == 0 || !(root > 0)) return visit(from, to);
        const float half = std::sqrt(root), enters = (-b - half) / a, leaves = (-b + half) / a;
        if (enters >= 1 || leaves <= 0) return visit(from, to);
        if (enters > 0) visit(from, from + enters * along);
        if (leaves < 1) visit(from + leaves * along, to);
    }

    // Bit i: whether `for_each_outer_part` may divide segment i.
    INSONIFY_INLINE std::uint32_t divided_ones(const point_lanes& from, const point_lanes& to) const {
        using floats = point_lanes::floats;
        const float radius = inner_radius();
        if (radius == 0) return 0;
        const floats x = to.x - from.x, y = to.y - from.y, a = x * x + y * y, b = from.x * x + from.y * y,
                     c = from.x * from.x + from.y * from.y - floats(radius * radius);
        return bits_of(floats(0.0F) <= b * b - a * c);
    }

    line_turn turn_{};
    std::vector<float> lines_[4] = {}; // x, y of origins; x, y of directions; the last line is repeated at the end
};

/// The crossings of the turned lines of one direction with the segments of the slices, by plane and line, at metres
/// along the lines. Keeps its memory from frame to frame.
class turned_crossings {
  public:
    /// @param fan     before its lines are turned
    /// @param turns   of the lines in each plane
    /// @param slices  of each plane, sorted, so that the crossings of each line nearly are
    void find(const line_fan& fan, view<const line_turn> turns, view<const slice_segments> slices) {
        constexpr int width = simd_width;
        lines_ = fan.size();
        crossed_.clear();
        lists_.clear(turns.size() * lines_);
        for (std::uint32_t plane = 0; plane < turns.size(); ++plane) {
            fans_[plane].assign(fan, turns[plane]);
            const std::size_t first_list = std::size_t{plane} * lines_;
            fans_[plane].for_each_crossed(fan, slices[plane],
                                          [&](const cut_segment& one, std::uint32_t first, std::uint32_t last) {
                                              crossed_.push_back({&one, first, last});
                                              for (std::uint32_t line = first; line < last; ++line)
                                                  lists_.count(first_list + line);
                                          });
        }
        lists_.make_room();
        for (const crossed_segment& crossed : crossed_) {
            const cut_segment& one = *crossed.segment;
            const std::size_t first_list = std::size_t{one.slice} * lines_;
            for (std::uint32_t line = crossed.first; line < crossed.last; line += width) {
                float distance[width];
                store(fans_[one.slice].from(line).intersect(one.from, one.to), distance);
                for (std::uint32_t i = line; i < crossed.last && i < line + width; ++i)
                    lists_.add(first_list + i, {distance[i - line], one.object, one.primitive});
            }
        }
    }

    view<const crossing> of_line(std::uint32_t line, std::uint32_t plane) const {
        return lists_[std::size_t{plane} * lines_ + line];
    }

  private:
    // The lines [first, last) cross a segment.
    struct crossed_segment {
        const cut_segment* segment = nullptr;
        std::uint32_t first = 0, last = 0;
    };

    std::uint32_t lines_ = 0;
    turned_fan fans_[max_elevation_planes] = {};
    std::vector<crossed_segment> crossed_{};
    crossing_lists lists_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
