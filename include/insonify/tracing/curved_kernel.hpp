#ifndef INSONIFY_TRACING_CURVED_KERNEL_HPP
#define INSONIFY_TRACING_CURVED_KERNEL_HPP

#include <insonify/core/math.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// The specular echo of a curved surface through a Gaussian kernel, in one direction across the line:
///
///     V = integral of G(x; sigma) exp(-i K H (x - x0)^2 / 2) dx = (1 + i q)^(-1/2) exp(-(x0 / sigma)^2 i q / (1 + i q) / 2)
///     q = K H sigma^2
///
/// relative to a plane, where G has the integral 1, K is the phase per metre of displayed depth, H the second derivative of the
/// surface's displayed depth in 1/m, and x0 where the surface is nearest to the probe. For a wire of radius a, 1 / H = a, so
/// |V| = (1 + (2 k sigma^2 / a)^2)^(-1/4) at its middle. Source: the Gaussian integral; Kirchhoff's approximation.
struct curved_kernel {
    float phase_per_metre = 0; ///< K
    float slope = 0;           ///< of the surface here: tangent of the angle of its normal to the line
    float curvature = 0;       ///< H
    float sigma = 0;           ///< standard deviation of the kernel, metres

    /// q
    INSONIFY_FN float phase() const { return phase_per_metre * curvature * sigma * sigma; }

    /// How much the surface counts as curved, 0 to 1. One that turns little within the kernel is a plane of its own slope
    /// on every line: then the law of plane surfaces is more accurate.
    INSONIFY_FN float strength() const {
        const float q = phase(), curved = q * q / (q * q + 1.5F * 1.5F);
        return curved > 0.01F ? curved : 0.0F;
    }

    /// What a line emits so that the sum over lines under the kernel is V, wherever the surface lies between them.
    ///
    /// The surface is averaged under a Gaussian of half the line spacing about the line, without which the sum has aliases. It
    /// widens the kernel; the ratio of V under both makes up for that.
    INSONIFY_FN vec2 of_line(float spacing) const {
        const float width = 0.5F * spacing, a = phase_per_metre * curvature * width * width;
        const float turns = phase_per_metre * slope * width, b = turns * turns / (1 + a * a);
        const float q = phase(), wider = q + a;
        const float ratio = std::sqrt(std::sqrt((1 + wider * wider) / ((1 + q * q) * (1 + a * a))));
        return polar(ratio * std::exp(-0.5F * b), 0.5F * (a * b - std::atan(a)));
    }

    /// V. @param offset  x0, metres
    INSONIFY_FN vec2 whole(float offset) const {
        const float q = phase(), x = offset / sigma;
        const float size = std::exp(-0.5F * x * x * q * q / (1 + q * q)) / std::sqrt(std::sqrt(1 + q * q));
        return polar(size, -0.5F * std::atan(q));
    }

    /// From this place to where the surface, as a circle, is nearest to the probe: metres across the line, and deeper.
    INSONIFY_FN vec2 to_nearest() const {
        const float s = 1 + slope * slope;
        return {slope * s / curvature, s * (1 - std::sqrt(s)) / curvature};
    }
    /// Radius of that circle, metres.
    INSONIFY_FN float radius() const {
        const float s = 1 + slope * slope;
        return s * std::sqrt(s) / std::fabs(curvature);
    }

  private:
    INSONIFY_FN static vec2 polar(float size, float phase) { return {size * std::cos(phase), size * std::sin(phase)}; }
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
