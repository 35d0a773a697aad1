#ifndef INSONIFY_PROBE_LINE_FAN_HPP
#define INSONIFY_PROBE_LINE_FAN_HPP

#include <insonify/geometry/pose.hpp>
#include <insonify/probe/transducer.hpp>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// The lines of a probe as one family within its slice plane: parallel, or all from one point, the apex.
///
///            across ->
///     along    0 | 1 | 2 | 3      Between two neighbouring lines lies a gap, numbered from the left: a point in gap g
///       |        |   |   |        has g lines on its left. What leads from gap 1 to gap 3 crosses lines 1 and 2.
///       v      line 0   line 2
///
/// Coordinates of a fan: x across, y along its middle line, from the apex; of parallel lines, from the middle line's
/// origin. Points on a line count as left of it, as if every line stood an infinitesimal step to the right.
class line_fan {
  public:
    struct line {
        vec2 origin{0, 0};
        vec2 along{0, 1};

        /// How far to the right of the line a point lies, and how far down it, metres.
        float right(vec2 p) const { return (p.x - origin.x) * along.y - (p.y - origin.y) * along.x; }
        float down(vec2 p) const { return (p.x - origin.x) * along.x + (p.y - origin.y) * along.y; }

        /// How far down the line the way from p to q crosses it, given that it does.
        float meet(vec2 p, vec2 q) const {
            const float before = right(p), beyond = before - right(q);
            const float share = beyond != 0 ? clamped(before / beyond, 0, 1) : 0.5F;
            const float at_p = down(p);
            return at_p + share * (down(q) - at_p);
        }
    };

    /// Takes the lines of a probe over, if they are such a family: straight, in the plane y = 0, numbered from left to
    /// right, at most once around, leaving the apex (none runs towards it). False where they are not: then no member
    /// may be called.
    template <transducer Probe>
    bool assign(const Probe& probe) {
        lines_.resize(probe.lines);
        for (std::uint32_t i = 0; i < probe.lines; ++i) {
            const ray beam = probe.beam(static_cast<float>(i));
            if (std::fabs(beam.origin.y) > 1e-7F || std::fabs(beam.direction.y) > 1e-6F) return false;
            lines_[i] = {{beam.origin.x, beam.origin.z}, {beam.direction.x, beam.direction.z}};
        }
        return find_apex() && turn_upright() && number_gaps();
    }

    INSONIFY_LAZY std::uint32_t size() const { return static_cast<std::uint32_t>(lines_.size()); }
    INSONIFY_LAZY const line& operator[](std::size_t i) const { return lines_[i]; }

    bool parallel() const { return parallel_; }

    /// Where the coordinates stand in the frame of the probe: x across and z along there are x and y here.
    INSONIFY_LAZY pose upright() const {
        return {mat3{{axis_.y, 0, -axis_.x}, {0, 1, 0}, {axis_.x, 0, axis_.y}}, {apex_.x, 0, apex_.y}};
    }

    /// True where the fan spans less than half a circle: then no point to the left of its first line or to the right of
    /// its last is on any of its lines.
    INSONIFY_LAZY bool is_wedge() const {
        return parallel_ || (lines_.front().along.y > 1e-3F && lines_.back().along.y > 1e-3F);
    }

    /// How many lines have the point on their right.
    INSONIFY_LAZY std::uint32_t gap(vec2 p) const {
        const float key = key_of(p);
        std::uint32_t i = first_in_bin_[bin_of(key)];
        while (i < keys_.size() && keys_[i] < key) ++i;
        return i;
    }

    /// Calls visit(first, last) for the lines [first, last) that the straight way from p to q crosses; at most twice.
    ///
    /// The gap of a point depends on nothing else: what is closed crosses each line an even number of times, or around
    /// the apex each an odd number, however coordinates were rounded.
    template <class Visit>
    void for_each_crossed(vec2 p, vec2 q, Visit&& visit) const {
        const std::uint32_t a = gap(p), b = gap(q);
        const std::uint32_t left = std::min(a, b), right = std::max(a, b);
        if (passes_behind(p, q)) {
            if (left > 0) visit(std::uint32_t{0}, left);
            if (right < size()) visit(right, size());
        } else if (left < right) {
            visit(left, right);
        }
    }

  private:
    static double cross_of(vec2 a, vec2 b) {
        return static_cast<double>(a.x) * static_cast<double>(b.y) -
               static_cast<double>(a.y) * static_cast<double>(b.x);
    }

    // Sets `parallel_` and `apex_`.
    INSONIFY_LAZY bool find_apex() {
        const line first = lines_.front();
        std::size_t other = 0;
        double widest = 0;
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            const double turn = std::fabs(cross_of(first.along, lines_[i].along));
            if (turn > widest) widest = turn, other = i;
        }
        parallel_ = widest < 1e-6;
        if (parallel_) {
            apex_ = lines_[lines_.size() / 2].origin;
            return std::all_of(lines_.begin(), lines_.end(),
                               [&](const line& l) { return dot(l.along, first.along) > 0; });
        }
        const line second = lines_[other];
        const double down = cross_of(second.origin - first.origin, second.along) / cross_of(first.along, second.along);
        apex_ = first.origin + static_cast<float>(down) * first.along;
        return std::all_of(lines_.begin(), lines_.end(), [&](const line& l) {
            const vec2 from_apex = l.origin - apex_;
            const float rounding = 3e-6F * length(from_apex) + 1e-9F;
            return std::fabs(cross_of(from_apex, l.along)) <= static_cast<double>(rounding) &&
                   dot(from_apex, l.along) >= -rounding;
        });
    }

    // Turns all coordinates so that the middle line, or the middle between two lines, runs along y: so no line runs straight
    // back, where keys jump.
    INSONIFY_LAZY bool turn_upright() {
        const vec2 left = lines_[(lines_.size() - 1) / 2].along, right = lines_[lines_.size() / 2].along;
        const vec2 sum = left + right; // 0 for two lines that part in opposite directions
        axis_ = dot(sum, sum) > 1e-6F ? normalize(sum) : vec2{left.y, -left.x};
        for (line& l : lines_) l = {turned(l.origin - apex_), turned(l.along)};
        return true;
    }
    vec2 turned(vec2 v) const { return {v.x * axis_.y - v.y * axis_.x, v.x * axis_.x + v.y * axis_.y}; }

    INSONIFY_LAZY bool number_gaps() {
        keys_.resize(lines_.size());
        for (std::size_t i = 0; i < keys_.size(); ++i)
            keys_[i] = key_of(parallel_ ? lines_[i].origin : lines_[i].along);
        if (!std::is_sorted(keys_.begin(), keys_.end())) return false;
        const std::size_t bins = 2 * keys_.size() + 1;
        const float extent = keys_.back() - keys_.front();
        bins_per_key_ = extent > 0 ? static_cast<float>(bins - 1) / extent : 0.0F;
        first_in_bin_.assign(bins, 0);
        for (std::size_t bin = 0, i = 0; bin < bins; ++bin) {
            while (i < keys_.size() && bin_of(keys_[i]) < bin) ++i;
            first_in_bin_[bin] = static_cast<std::uint32_t>(i);
        }
        return true;
    }
    INSONIFY_LAZY std::size_t bin_of(float key) const { // rises with the key, however it rounds; NaN is in the first
        const float bin = greater(0.0F, (key - keys_.front()) * bins_per_key_);
        return static_cast<std::size_t>(lesser(static_cast<float>(first_in_bin_.size() - 1), bin));
    }

    // Rises from line to line: the place across, or something like the angle: -2 to 2 for -180 to 180 degrees.
    float key_of(vec2 p) const {
        if (parallel_) return p.x;
        const float size = std::fabs(p.x) + std::fabs(p.y);
        const float share = size > 0 ? p.x / size : 0.0F;
        return p.y >= 0 ? share : p.x >= 0 ? 2 - share : -2 - share;
    }

    // Whether the way from p to q crosses the half line from the apex straight back, where keys jump.
    bool passes_behind(vec2 p, vec2 q) const {
        if (parallel_ || (p.x < 0) == (q.x < 0) || (p.y >= 0 && q.y >= 0)) return false;
        return (cross_of(p, q) > 0) == (p.x < 0);
    }

    bool parallel_ = true;
    vec2 apex_{0, 0}, axis_{0, 1};
    std::vector<line> lines_;
    std::vector<float> keys_;
    std::vector<std::uint32_t> first_in_bin_;
    float bins_per_key_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
