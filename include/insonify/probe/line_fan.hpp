#ifndef INSONIFY_PROBE_LINE_FAN_HPP
#define INSONIFY_PROBE_LINE_FAN_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/probe/probe_lines.hpp>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The lines of a probe within its slice plane, either parallel or diverging from an apex.
///
///            across ->
///     along    0 | 1 | 2 | 3      Gaps separate neighbouring lines and are numbered from the left: a point in gap g
///       |        |   |   |        has g lines on its left. A segment from gap 1 to gap 3 crosses lines 1 and 2.
///       v      line 0   line 2
///
/// Coordinates: x across, y along the middle line. The origin is the apex or, for parallel lines, the origin of the
/// middle line. Points on a line count as left of it, as if every line were displaced to the right by an infinitesimal
/// step.
class line_fan {
  public:
    struct line {
        vec2 origin{0, 0};
        vec2 along{0, 1};

        /// Signed distance of a point from the line, positive to the right, metres.
        float right(vec2 p) const { return (p.x - origin.x) * along.y - (p.y - origin.y) * along.x; }
    };

    using floats = lanes<simd_width>;

    /// Neighbouring lines, one in each lane.
    struct neighbours {
        floats origin_x, origin_y, along_x, along_y;

        /// Distance along each line at which the segment from p to q crosses it, given that it does.
        INSONIFY_INLINE floats intersect(vec2 p, vec2 q) const {
            const floats zero(0.0F), one(1.0F);
            const floats px = floats(p.x) - origin_x, py = floats(p.y) - origin_y;
            const floats qx = floats(q.x) - origin_x, qy = floats(q.y) - origin_y;
            const floats right_of_p = px * along_y - py * along_x, right_of_q = qx * along_y - qy * along_x;
            const floats beyond = right_of_p - right_of_q;
            const auto parallel = beyond == zero;
            const floats fraction = select(parallel, floats(0.5F), right_of_p) / select(parallel, one, beyond);
            const floats down_p = px * along_x + py * along_y, down_q = qx * along_x + qy * along_y;
            return down_p + min(max(fraction, zero), one) * (down_q - down_p);
        }
    };

    /// Sets the lines, those of a probe. False where they are not a fan: then no other member may be called.
    ///
    /// A fan lies in the plane y = 0, is numbered from left to right, covers at most a full circle, and diverges.
    bool assign(const probe_lines& probe) {
        lines_.clear();
        for (const auto& [origin, direction, axis] : probe.lines()) {
            if (std::fabs(origin.y) > 1e-7F || std::fabs(direction.y) > 1e-6F) return false;
            lines_.push_back({{origin.x, origin.z}, {direction.x, direction.z}});
        }
        if (!find_apex()) return false;
        turn_upright();
        return number_gaps();
    }

    /// Takes over every `stride`-th line of another fan, from `first` on.
    void assign(const line_fan& other, std::uint32_t first, std::uint32_t stride) {
        *this = other;
        lines_.clear();
        for (std::size_t i = first; i < other.lines_.size(); i += stride) lines_.push_back(other.lines_[i]);
        number_gaps();
    }

    /// Adds up to `count` lines from the same point on either side, `angle` radians from line to line, within 89
    /// degrees of the middle line. @return how many on each side
    std::uint32_t extend(std::uint32_t count, float angle) {
        const line first = lines_.front(), last = lines_.back();
        const auto turned_by = [](line l, float by) { // to the right
            const float s = std::sin(by), c = std::cos(by);
            l.along = {l.along.x * c + l.along.y * s, l.along.y * c - l.along.x * s};
            return l;
        };
        const float room = std::acos(clamp(min(first.along.y, last.along.y), -1, 1));
        while (count > 0 && room + static_cast<float>(count) * angle > 89 * pi / 180) --count;
        const std::size_t own = lines_.size();
        lines_.resize(own + 2 * std::size_t{count});
        std::move_backward(lines_.begin(), lines_.begin() + static_cast<std::ptrdiff_t>(own),
                           lines_.begin() + static_cast<std::ptrdiff_t>(own + count));
        for (std::uint32_t i = 1; i <= count; ++i) {
            lines_[count - i] = turned_by(first, -static_cast<float>(i) * angle);
            lines_[own + count - 1 + i] = turned_by(last, static_cast<float>(i) * angle);
        }
        number_gaps();
        return count;
    }

    std::uint32_t size() const { return static_cast<std::uint32_t>(lines_.size()); }
    const line& operator[](std::size_t i) const { return lines_[i]; }
    view<const line> lines() const { return lines_; }

    bool parallel() const { return parallel_; }

    /// Bounding box of the origins, metres, and the largest cosine between a line and the middle line.
    struct bounds {
        vec2 min{FLT_MAX, FLT_MAX}, max{-FLT_MAX, -FLT_MAX};
        float max_cosine = -1;
    };
    const bounds& extent() const { return extent_; }

    /// From the coordinates of the fan to those of the probe: x and y here become x and z.
    pose upright() const {
        return {mat3{{axis_.y, 0, -axis_.x}, {0, 1, 0}, {axis_.x, 0, axis_.y}}, {apex_.x, 0, apex_.y}};
    }

    /// True for a fan of less than half a circle: no point to the left of its first line or to the right of its last
    /// line lies on a line.
    bool is_wedge() const { return parallel_ || (lines_.front().along.y > 1e-3F && lines_.back().along.y > 1e-3F); }

    /// The lines from `first` on; the last line fills the lanes beyond it.
    neighbours from(std::size_t first) const {
        const auto each = [&](auto value) {
            return each_lane<simd_width>(
                [&](int i) { return value(lines_[std::min(first + static_cast<std::size_t>(i), lines_.size() - 1)]); });
        };
        return {each([](const line& l) { return l.origin.x; }), each([](const line& l) { return l.origin.y; }),
                each([](const line& l) { return l.along.x; }), each([](const line& l) { return l.along.y; })};
    }

    /// Search keys of points for `gap`.
    struct places {
        float key[simd_width];
        std::uint32_t bin[simd_width];
    };
    INSONIFY_INLINE places places_of(const floats& x, const floats& y) const {
        places found;
        const floats keys = key_of(x, y);
        store(keys, found.key);
        // Monotonic in the key, whatever the rounding; NaN is in the first bin.
        const floats bin = max(floats(0.0F), (keys - floats(keys_[0])) * floats(bins_per_key_));
        store_bits<simd_width>(bits_of_whole<simd_width>(min(bin, floats(static_cast<float>(last_bin_)))), found.bin);
        return found;
    }

    /// The gap of point i, which must be finite: the number of lines on its left.
    INSONIFY_INLINE std::uint32_t gap(const places& of, std::uint32_t i) const {
        std::uint32_t left = first_in_bin_[std::min(of.bin[i], last_bin_)];
        left += keys_[left] < of.key[i]; // usually sufficient, and branchless
        while (keys_[left] < of.key[i]) ++left;
        return left;
    }
    std::uint32_t gap(vec2 p) const { return gap(places_of(floats(p.x), floats(p.y)), 0); }

    /// Calls visit(first, last) for each range of lines [first, last) that the segment from p to q crosses; at most
    /// two.
    ///
    /// The gap of a point depends on the point alone. So a closed polygon crosses each line an even number of times (an
    /// odd number if it encloses the apex), whatever the rounding.
    template <class Visit>
    void for_each_crossed(vec2 p, std::uint32_t gap_of_p, vec2 q, std::uint32_t gap_of_q, Visit&& visit) const {
        const std::uint32_t left = std::min(gap_of_p, gap_of_q), right = std::max(gap_of_p, gap_of_q);
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
    bool find_apex() {
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

    // Rotates all coordinates so that the middle line, or the bisector of the middle two, runs along y. So no line runs
    // along -y, where keys are discontinuous.
    void turn_upright() {
        const vec2 left = lines_[(lines_.size() - 1) / 2].along, right = lines_[lines_.size() / 2].along;
        const vec2 sum = left + right; // 0 for two opposite lines
        axis_ = dot(sum, sum) > 1e-6F ? normalize(sum) : vec2{left.y, -left.x};
        extent_ = {};
        for (line& l : lines_) {
            l = {turned(l.origin - apex_), turned(l.along)};
            for (int axis = 0; axis < 2; ++axis) {
                extent_.min[axis] = min(extent_.min[axis], l.origin[axis]);
                extent_.max[axis] = max(extent_.max[axis], l.origin[axis]);
            }
            extent_.max_cosine = max(extent_.max_cosine, l.along.y);
        }
    }
    vec2 turned(vec2 v) const { return {v.x * axis_.y - v.y * axis_.x, v.x * axis_.x + v.y * axis_.y}; }

    bool number_gaps() {
        const auto places_of_line = [&](std::size_t i) {
            const vec2 p = parallel_ ? lines_[i].origin : lines_[i].along;
            return places_of(floats(p.x), floats(p.y));
        };
        bins_per_key_ = 0;
        keys_.assign(lines_.size() + 1, FLT_MAX); // the last one ends every search
        for (std::size_t i = 0; i < lines_.size(); ++i) keys_[i] = places_of_line(i).key[0];
        if (!std::is_sorted(keys_.begin(), keys_.end())) return false;
        const std::size_t bins = 2 * lines_.size() + 1;
        const float extent = keys_[lines_.size() - 1] - keys_[0];
        last_bin_ = static_cast<std::uint32_t>(bins - 1);
        bins_per_key_ = extent > 0 ? static_cast<float>(bins - 1) / extent : 0.0F;
        first_in_bin_.assign(bins, size());
        for (std::size_t i = lines_.size(); i-- > 0;)
            first_in_bin_[places_of_line(i).bin[0]] = static_cast<std::uint32_t>(i);
        for (std::size_t bin = bins - 1; bin > 0; --bin)
            first_in_bin_[bin - 1] = std::min(first_in_bin_[bin - 1], first_in_bin_[bin]);
        return true;
    }

    // Increases from line to line: the position across or, for a fan, a diamond angle: -2 to 2 for -180 to 180 degrees.
    INSONIFY_INLINE floats key_of(const floats& x, const floats& y) const {
        if (parallel_) return x;
        const floats zero(0.0F), size = abs(x) + abs(y);
        const floats ratio = x / select(zero < size, size, floats(1.0F));
        const floats behind = select(zero <= x, floats(2.0F), floats(-2.0F)) - ratio;
        return select(zero <= y, ratio, behind);
    }

    // True where the segment from p to q crosses the half line from the apex along -y, where keys are discontinuous.
    bool passes_behind(vec2 p, vec2 q) const {
        if (parallel_ || (p.x < 0) == (q.x < 0) || (p.y >= 0 && q.y >= 0)) return false;
        return (cross_of(p, q) > 0) == (p.x < 0);
    }

    bool parallel_ = true;
    vec2 apex_{0, 0}, axis_{0, 1};
    std::vector<line> lines_;
    bounds extent_{};
    std::vector<float> keys_;
    std::vector<std::uint32_t> first_in_bin_;
    float bins_per_key_ = 0;
    std::uint32_t last_bin_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
