#ifndef INSONIFY_PROBE_LINE_FAN_HPP
#define INSONIFY_PROBE_LINE_FAN_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/probe/transducer.hpp>
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

        /// How far to the right of the line a point lies, metres.
        float right(vec2 p) const { return (p.x - origin.x) * along.y - (p.y - origin.y) * along.x; }
    };

    /// A few neighbouring lines, side by side.
    template <int N>
    struct neighbours {
        lanes<N> origin_x, origin_y, along_x, along_y;

        /// How far down each line the way from p to q crosses it, given that it does.
        INSONIFY_INLINE lanes<N> meet(vec2 p, vec2 q) const {
            const lanes<N> zero(0.0F), one(1.0F);
            const lanes<N> px = lanes<N>(p.x) - origin_x, py = lanes<N>(p.y) - origin_y;
            const lanes<N> qx = lanes<N>(q.x) - origin_x, qy = lanes<N>(q.y) - origin_y;
            const lanes<N> right_of_p = px * along_y - py * along_x, right_of_q = qx * along_y - qy * along_x;
            const lanes<N> beyond = right_of_p - right_of_q;
            const auto parallel = beyond == zero;
            const lanes<N> share = select(parallel, lanes<N>(0.5F), right_of_p) / select(parallel, one, beyond);
            const lanes<N> down_p = px * along_x + py * along_y, down_q = qx * along_x + qy * along_y;
            return down_p + lesser(greater(share, zero), one) * (down_q - down_p);
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

    /// How far the origins of lines reach, metres, and the most that a line gains along in a metre.
    struct bounds {
        vec2 least{FLT_MAX, FLT_MAX}, most{-FLT_MAX, -FLT_MAX};
        float straightest = -1;
    };
    const bounds& extent() const { return extent_; }

    /// Where the coordinates stand in the frame of the probe: x across and z along there are x and y here.
    INSONIFY_LAZY pose upright() const {
        return {mat3{{axis_.y, 0, -axis_.x}, {0, 1, 0}, {axis_.x, 0, axis_.y}}, {apex_.x, 0, apex_.y}};
    }

    /// True where the fan spans less than half a circle: then no point to the left of its first line or to the right of
    /// its last is on any of its lines.
    INSONIFY_LAZY bool is_wedge() const {
        return parallel_ || (lines_.front().along.y > 1e-3F && lines_.back().along.y > 1e-3F);
    }

    /// The lines from `first` on; after the last one, that one again.
    template <int N>
    neighbours<N> from(std::size_t first) const {
        const auto each = [&](auto value) {
            return each_lane<N>(
                [&](int i) { return value(lines_[std::min(first + static_cast<std::size_t>(i), lines_.size() - 1)]); });
        };
        return {each([](const line& l) { return l.origin.x; }), each([](const line& l) { return l.origin.y; }),
                each([](const line& l) { return l.along.x; }), each([](const line& l) { return l.along.y; })};
    }

    /// Where a few points lie among the lines, side by side: what `gap` asks for each.
    template <int N>
    struct places {
        float key[N];
        std::uint32_t bin[N];
    };
    template <int N>
    INSONIFY_INLINE places<N> places_of(const lanes<N>& x, const lanes<N>& y) const {
        places<N> found;
        const lanes<N> keys = key_of<N>(x, y);
        store(keys, found.key);
        store_bits<N>(bin_of<N>(keys), found.bin);
        return found;
    }

    /// How many lines have point i of them, which is finite, on their right.
    template <int N>
    INSONIFY_INLINE std::uint32_t gap(const places<N>& of, std::uint32_t i) const {
        std::uint32_t left = first_in_bin_[std::min(of.bin[i], last_bin_)];
        left += keys_[left] < of.key[i]; // mostly all there is: without a branch
        while (keys_[left] < of.key[i]) ++left;
        return left;
    }
    INSONIFY_LAZY std::uint32_t gap(vec2 p) const {
        return gap(places_of<simd_width>(lanes<simd_width>(p.x), lanes<simd_width>(p.y)), 0);
    }

    /// Calls visit(first, last) for the lines [first, last) that the straight way from p to q crosses, which lie in these
    /// gaps; at most twice.
    ///
    /// The gap of a point depends on nothing else: what is closed crosses each line an even number of times, or around
    /// the apex each an odd number, however coordinates were rounded.
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
        extent_ = {};
        for (line& l : lines_) {
            l = {turned(l.origin - apex_), turned(l.along)};
            for (int axis = 0; axis < 2; ++axis) {
                extent_.least[axis] = lesser(extent_.least[axis], l.origin[axis]);
                extent_.most[axis] = greater(extent_.most[axis], l.origin[axis]);
            }
            extent_.straightest = greater(extent_.straightest, l.along.y);
        }
        return true;
    }
    vec2 turned(vec2 v) const { return {v.x * axis_.y - v.y * axis_.x, v.x * axis_.x + v.y * axis_.y}; }

    INSONIFY_LAZY bool number_gaps() {
        constexpr std::size_t width = simd_width;
        keys_.resize(lines_.size() + width); // beyond the last line's it is where every search ends
        const auto place = [&](std::size_t i) { return parallel_ ? lines_[i].origin : lines_[i].along; };
        for (std::size_t i = 0; i < lines_.size(); i += width) {
            const auto each = [&](int axis) {
                return each_lane<width>([&](int lane) {
                    return place(std::min(i + static_cast<std::size_t>(lane), lines_.size() - 1))[axis];
                });
            };
            store(key_of<width>(each(0), each(1)), keys_.data() + i);
        }
        std::fill(keys_.begin() + size(), keys_.end(), FLT_MAX);
        if (!std::is_sorted(keys_.begin(), keys_.end())) return false;
        const std::size_t bins = 2 * lines_.size() + 1;
        const float extent = keys_[lines_.size() - 1] - keys_[0];
        last_bin_ = static_cast<std::uint32_t>(bins - 1);
        bins_per_key_ = extent > 0 ? static_cast<float>(bins - 1) / extent : 0.0F;
        first_in_bin_.assign(bins, size());
        for (std::size_t i = lines_.size(); i > 0;) {
            std::uint32_t bin[width];
            const std::size_t first = (i - 1) / width * width;
            store_bits<width>(bin_of<width>(load<width>(keys_.data() + first)), bin);
            for (; i > first; --i) first_in_bin_[bin[i - 1 - first]] = static_cast<std::uint32_t>(i - 1);
        }
        for (std::size_t bin = bins - 1; bin > 0; --bin)
            first_in_bin_[bin - 1] = std::min(first_in_bin_[bin - 1], first_in_bin_[bin]);
        return true;
    }

    // Rises with the key, however it rounds; NaN is in the first.
    template <int N>
    INSONIFY_INLINE bit_lanes<N> bin_of(const lanes<N>& key) const {
        const lanes<N> bin = greater(lanes<N>(0.0F), (key - lanes<N>(keys_[0])) * lanes<N>(bins_per_key_));
        return bits_of_whole<N>(lesser(bin, lanes<N>(static_cast<float>(last_bin_))));
    }

    // Rises from line to line: the place across, or something like the angle: -2 to 2 for -180 to 180 degrees.
    template <int N>
    INSONIFY_INLINE lanes<N> key_of(const lanes<N>& x, const lanes<N>& y) const {
        if (parallel_) return x;
        const lanes<N> zero(0.0F), size = absolute(x) + absolute(y);
        const lanes<N> share = x / select(zero < size, size, lanes<N>(1.0F));
        const lanes<N> behind = select(zero <= x, lanes<N>(2.0F), lanes<N>(-2.0F)) - share;
        return select(zero <= y, share, behind);
    }

    // Whether the way from p to q crosses the half line from the apex straight back, where keys jump.
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

} // namespace insonify::inline INSONIFY_ABI
#endif
