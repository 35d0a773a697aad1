#ifndef INSONIFY_SIGNAL_KERNEL_CURVED_KERNEL_HPP
#define INSONIFY_SIGNAL_KERNEL_CURVED_KERNEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// The specular echo of a curved surface through a Gaussian kernel, in one direction across the line:
///
///     V = integral of G(x; sigma) exp(-i K (x - x0)^2 / (2 a)) dx = (1 + i q)^(-1/2) exp(-(x0 / sigma)^2 i q / (1 + i q) / 2)
///     q = K sigma^2 / a
///
/// relative to a plane, where G has the integral 1, K is the phase per metre of displayed depth, a the radius of the surface in
/// metres, and x0 where the surface is nearest to the probe. At its middle |V| = (1 + (2 k sigma^2 / a)^2)^(-1/4).
/// Source: Kirchhoff's approximation; the Gaussian integral, with the parabola in place of the circle.
class curved_kernel {
  public:
    /// @param phase_per_metre  K
    /// @param slope            tangent of the angle of the surface's normal to the line
    /// @param curvature        second derivative of the surface's depth, 1/m
    /// @param sigma            standard deviation of the kernel, metres
    INSONIFY_FN curved_kernel(float phase_per_metre, float slope, float curvature, float sigma)
        : phase_per_metre_{phase_per_metre}, cosine_{1 / std::sqrt(1 + slope * slope)}, sine_{slope * cosine_},
          bend_{curvature * cosine_ * cosine_ * cosine_}, sigma_{sigma} {}

    /// How much the surface counts as curved, 0 to 1. One that turns little within the kernel is a plane of its own slope on
    /// every line: then the law of plane surfaces is more accurate. So it is where the nearest place is far away, beyond what
    /// slope and curvature at this place can tell.
    INSONIFY_FN float strength() const {
        const float q = phase(), curved = q * q / (q * q + 0.4F * 0.4F);
        if (!(curved > 0.01F)) return 0;
        return curved * clamp(3.5F - std::fabs(sine_ / (bend_ * sigma_)), 0, 1);
    }

    /// What a line emits, at the depth of the nearest place, so that the sum over lines under the kernel is V, wherever that
    /// place lies between them.
    ///
    /// The surface is averaged under a Gaussian of half the line spacing about the line, without which the sum has aliases. It
    /// widens the kernel; the ratio of V under both makes up for that.
    INSONIFY_FN vec2 of_line(float spacing) const {
        const float width = 0.55F * spacing, a = phase_per_metre_ * bend_ * width * width;
        const float turns = phase_per_metre_ * sine_ * width, b = turns * turns / (1 + a * a);
        const float q = phase(), wider = q + a;
        const float ratio = std::sqrt(std::sqrt((1 + wider * wider) / ((1 + q * q) * (1 + a * a))));
        const float deeper = 0.5F * sine_ * sine_ / bend_; // than the nearest place, metres
        return polar(ratio * std::exp(-0.5F * b), 0.5F * (a * b - std::atan(a)) - phase_per_metre_ * deeper);
    }

    /// |V| at its middle.
    INSONIFY_FN float at_middle() const {
        const float q = phase();
        return 1 / std::sqrt(std::sqrt(1 + q * q));
    }
    /// V. @param offset  x0, metres
    INSONIFY_FN vec2 whole(float offset) const {
        const float q = phase(), x = offset / sigma_;
        const float size = std::exp(-0.5F * x * x * q * q / (1 + q * q)) / std::sqrt(std::sqrt(1 + q * q));
        return polar(size, -0.5F * std::atan(q));
    }

    /// From this place to where the surface is nearest to the probe: metres across the line, and deeper.
    INSONIFY_FN vec2 to_nearest() const { return {sine_ / bend_, (cosine_ - 1) / bend_}; }
    /// a, metres.
    INSONIFY_FN float radius() const { return 1 / std::fabs(bend_); }

  private:
    INSONIFY_FN float phase() const { return phase_per_metre_ * bend_ * sigma_ * sigma_; } // q
    INSONIFY_FN static vec2 polar(float size, float phase) { return {size * std::cos(phase), size * std::sin(phase)}; }

    float phase_per_metre_, cosine_, sine_;
    float bend_; // one over the radius, positive where the surface recedes to both sides, 1/m
    float sigma_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
