#ifndef INSONIFY_TRACING_APERTURE_APERTURE_MEAN_HPP
#define INSONIFY_TRACING_APERTURE_APERTURE_MEAN_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/tracing/aperture/turned_lines.hpp>
#include <cfloat>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Interpolates linearly between two values, either of which may be unusable.
struct blend_of_two {
    bool first = true, second = true;
    float fraction = 0;

    bool any() const { return first || second; }
    template <class Value>
    Value operator()(const Value& a, const Value& b) const {
        return first && second ? a + fraction * (b - a) : first ? a : b;
    }
};

/// What arrives at a point through the whole aperture.
struct aperture_mean {
    float surfaces = 0; ///< square of the mean amplitude, one way
    float speckle = 0;  ///< rms of the amplitude's convolution with itself, over that of 1
    float shown = 0;    ///< displayed depth, metres
    bool any = false;   ///< some line arrives
};

/// Combines what arrives along the turned lines at all points of one step of one plane. Keeps its memory.
class aperture_average {
  public:
    static constexpr std::uint32_t max_directions = 64;

    /// @param row      number of the step in all planes
    /// @param place    place(point): what the point lies in; only sound that arrives in the same counts
    /// @param means    one for each point
    template <class Place>
    void compute(const shading_points& points, view<const turned_lines> directions, std::size_t row, const Place& place,
                 view<aperture_mean> means) {
        const std::size_t count = directions.size();
        const std::size_t padded = (std::size_t{points.size()} + simd_width - 1) / simd_width * simd_width;
        // What arrives along each direction, then the share of the last, then what arrives times its displayed depth.
        weighted_.assign((2 * count + 1) * padded, 0);
        float *const shares = weighted_.data() + count * padded, *const depths = shares + count * padded;
        for (std::size_t k = 0; k < count; ++k)
            weigh(points, directions[k], row, place, weighted_.data() + k * padded, shares + k * padded, depths);
        for (std::uint32_t first = 0; first < points.size(); first += simd_width) {
            const received sound = receive(weighted_.data() + first, padded, count),
                           all = receive(shares + first, padded, count);
            const floats least(FLT_MIN); // divides where there is no line at all
            float mean[simd_width], rms[simd_width], depth[simd_width], whole[simd_width];
            store(load<simd_width>(depths + first) / max(sound.sum, least), depth);
            store(sound.sum / max(all.sum, least), mean);
            store(sqrt(sound.power / max(all.power, least)), rms);
            store(all.sum, whole);
            for (std::uint32_t i = 0; i < simd_width && first + i < points.size(); ++i)
                means[first + i] = {mean[i] * mean[i], rms[i], depth[i], whole[i] > 0};
        }
    }

  private:
    using floats = lanes<simd_width>;

    // What arrives along one direction at each point, times the share of the direction. The line that ends in a point lies
    // between those of two points, neither of which is used where it has left the fan: slices end there.
    template <class Place>
    static void weigh(const shading_points& points, const turned_lines& one, std::size_t row, const Place& place,
                      float* weighted, float* shares, float* depths) {
        const float share = one.share(row);
        if (!(share > 0)) return;
        const auto count = static_cast<std::int64_t>(points.size()), beyond = static_cast<std::int64_t>(points.beyond);
        const sound_at_depth* const sound = one.sound(row);
        const bool alike = points.shape.form != face_shape::form::point; // all cross as many lines
        float back = -one.lines_crossed(row, 0);
        for (std::int64_t point = 0; point < count; ++point) {
            if (!alike) back = -one.lines_crossed(row, static_cast<std::uint32_t>(point + beyond));
            const float whole = std::floor(back), fraction = back - whole;
            std::int64_t from = point + beyond + static_cast<std::int64_t>(whole), next = from + 1;
            bool from_within = true, next_within = true;
            if (points.shape.full_circle) {
                from = (from % count + count) % count;
                next = (from + 1) % count;
            } else {
                const std::int64_t all = count + 2 * beyond;
                from_within = from >= 0 && from < all && (!alike || point > 0 || fraction == 0);
                next_within = next >= 0 && next < all && (!alike || point + 1 < count);
                if (!from_within) from = next;
                if (!next_within) next = from;
                if (!from_within && !next_within) continue;
            }
            const std::uint32_t here = place(static_cast<std::uint32_t>(point));
            const blend_of_two between{from_within && sound[from].place == here,
                                       next_within && sound[next].place == here, fraction};
            if (!between.any()) continue;
            weighted[point] = share * between(sound[from].amplitude, sound[next].amplitude);
            shares[point] = share;
            depths[point] += weighted[point] * between(sound[from].shown, sound[next].shown);
        }
    }

    // Sum over the directions, and the sum of the squares of their convolution with themselves.
    struct received {
        floats sum{0.0F}, power{0.0F};
    };
    static received receive(const float* of_first, std::size_t padded, std::size_t count) {
        floats of[max_directions];
        received all;
        for (std::size_t k = 0; k < count; ++k) {
            of[k] = load<simd_width>(of_first + k * padded);
            all.sum = all.sum + of[k];
        }
        for (std::size_t both = 0; both + 1 < 2 * count; ++both) {
            floats together(0.0F);
            std::size_t i = both < count ? 0 : both - count + 1, j = both - i;
            for (; i < j; ++i, --j) together = multiply_add(of[i], of[j], together);
            together = together + together;
            if (i == j) together = multiply_add(of[i], of[i], together);
            all.power = multiply_add(together, together, all.power);
        }
        return all;
    }

    std::vector<float> weighted_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
