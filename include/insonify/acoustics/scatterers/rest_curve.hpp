#ifndef INSONIFY_ACOUSTICS_SCATTERERS_REST_CURVE_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_REST_CURVE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/scatterers/scattering.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Part of a line as it was at rest, which is curved where tissue is deformed: points at equal steps, of which the last may be up
/// to half a step shorter or longer.
class rest_curve {
  public:
    /// @param line   with a displacement
    /// @param begin  metres along the line
    /// @param end    metres along the line; the curve ends before it where it would have too many points
    INSONIFY_FN rest_curve(const material_line& line, float begin, float end)
        : begin_{begin}, step_{line.displacement->straight_length / length(line.along)} {
        const float steps = (end - begin) / step_;
        last_ = static_cast<std::uint32_t>(clamp(steps + 0.5F, 1, max_steps));
        end_ = steps < static_cast<float>(max_steps) + 0.5F ? end : begin + static_cast<float>(max_steps) * step_;
        for (std::uint32_t i = 0; i <= last_; ++i) point_[i] = line.displacement->rest(line.at(distance(i)));
    }

    INSONIFY_FN std::uint32_t last() const { return last_; }
    /// Of a point, metres along the line.
    INSONIFY_FN float distance(std::uint32_t i) const {
        return i == last_ ? end_ : begin_ + static_cast<float>(i) * step_;
    }
    /// In tissue at rest.
    INSONIFY_FN vec3 point(std::uint32_t i) const { return point_[i]; }
    /// Metres of tissue at rest per metre of the line, from one point straight to another.
    INSONIFY_FN vec3 along(std::uint32_t from, std::uint32_t to) const {
        return (point_[to] - point_[from]) * (1 / (distance(to) - distance(from)));
    }

    /// The end of a straight piece from a point on: no point of the curve between is further from it than `tolerance`, metres.
    /// @param most  the last point that it may reach
    INSONIFY_FN std::uint32_t straight_until(std::uint32_t from, std::uint32_t most, float tolerance) const {
        std::uint32_t to = from + 1;
        while (to < most && is_straight(from, to + 1, tolerance)) ++to;
        return to;
    }

  private:
    static constexpr std::uint32_t max_steps = 32;

    INSONIFY_FN bool is_straight(std::uint32_t from, std::uint32_t to, float tolerance) const {
        const vec3 step = along(from, to);
        for (std::uint32_t i = from + 1; i < to; ++i) {
            const vec3 aside = point_[i] - point_[from] - (distance(i) - distance(from)) * step;
            if (dot(aside, aside) > tolerance * tolerance) return false;
        }
        return true;
    }

    float begin_, step_, end_ = 0; // metres along the line
    std::uint32_t last_ = 0;
    vec3 point_[max_steps + 1];
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
