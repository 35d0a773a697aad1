#ifndef INSONIFY_SIGNAL_KERNEL_SURFACE_STRIP_HPP
#define INSONIFY_SIGNAL_KERNEL_SURFACE_STRIP_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// The part of a surface that a line stands for, out of the slice: an arc of a circle, or a straight piece.
class surface_strip {
  public:
    /// @param slope      tangent of the angle of the surface's normal to the line, out of the slice
    /// @param curvature  second derivative of the surface's depth out of the slice, 1/m
    /// @param strip      lower and upper end, metres out of the slice from the line
    INSONIFY_FN surface_strip(float slope, float curvature, vec2 strip) : slope_{slope}, strip_{strip} {
        const float cosine = 1 / std::sqrt(1 + slope * slope);
        bend_ = curvature * cosine * cosine * cosine;
        nearest_ = 0.5F * (strip.x + strip.y);
        const float turned = std::fabs(bend_) * max(strip.y - strip.x, 1e-6F);
        if (turned > 1e-3F && is_finite(turned)) {
            constexpr float met = 0.95F; // of the radius; a surface is too steep beyond
            const float radius = 1 / std::fabs(bend_);
            nearest_ = slope * cosine / bend_;
            strip_ = {max(strip.x, min(nearest_ - met * radius, 0)), min(strip.y, max(nearest_ + met * radius, 0))};
            nearest_ = clamp(nearest_, strip_.x, strip_.y);
        } else {
            bend_ = 0;
        }
    }

    /// How much deeper than on the line, metres, at a part of the strip, 0 to 1.
    INSONIFY_FN float deeper(float part) const { return deeper_at(strip_.x + part * (strip_.y - strip_.x)); }
    /// How far it is from the least depth to that of either end, metres.
    INSONIFY_FN float range() const {
        const float middle = deeper_at(nearest_);
        return std::fabs(deeper_at(strip_.x) - middle) + std::fabs(deeper_at(strip_.y) - middle);
    }

  private:
    INSONIFY_FN float deeper_at(float height) const {
        if (bend_ == 0) return -slope_ * height;
        const float cosine = 1 / std::sqrt(1 + slope_ * slope_), sine = bend_ * height - slope_ * cosine;
        return (cosine - std::sqrt(max(1 - sine * sine, 0))) / bend_;
    }

    float slope_;
    vec2 strip_;
    float bend_ = 0;    // one over the radius, 1/m
    float nearest_ = 0; // where the surface is nearest to the probe, or the middle
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
