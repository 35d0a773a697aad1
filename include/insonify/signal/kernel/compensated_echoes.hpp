#ifndef INSONIFY_SIGNAL_KERNEL_COMPENSATED_ECHOES_HPP
#define INSONIFY_SIGNAL_KERNEL_COMPENSATED_ECHOES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/acoustics/medium.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>

/// The acoustic model computes physics only: it emits the echo that the probe receives. `convolve` then averages
/// neighbouring lines, and elevation planes are averaged too, which weakens echoes that differ from line to line. Here
/// echoes are raised beforehand by the same amount, so that their levels are those of the model. Planes are averaged
/// with the weights of coherent echoes; independent ones, which add by power, have weights of their own, and are
/// multiplied by the ratio.
namespace insonify::inline INSONIFY_ABI::detail {

/// The specular echo of a curved surface through a Gaussian kernel, in one direction across the line:
///
///     V = integral of G(x; sigma) exp(-i K (x - x0)^2 / (2 a)) dx
///       = (1 + i q)^(-1/2) exp(-(x0 / sigma)^2 i q / (1 + i q) / 2)
///     q = K sigma^2 / a
///
/// relative to a plane, where G has the integral 1, K is the phase per metre of displayed depth, a the radius of the
/// surface in metres, and x0 where the surface is nearest to the probe. |V| = (1 + q^2)^(-1/4) for x0 = 0.
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

    /// How much the surface counts as curved, 0 to 1: the law of plane surfaces is more accurate where it turns little
    /// within the kernel, or the nearest place is far away. Constants here and in `of_line`: by hand, within the limits
    /// of `tests/tracing/curved_surfaces.cpp`; +-30 %: below 0.3 dB rms in a picture of surfaces.
    INSONIFY_FN float strength() const {
        const float q = phase(), curved = q * q / (q * q + 0.4F * 0.4F);
        if (!(curved > 0.01F)) return 0;
        return curved * clamp(3.5F - std::fabs(sine_ / (bend_ * sigma_)), 0, 1);
    }

    /// What a line emits, at the depth of the nearest place, so that the sum over lines under the kernel is V. The
    /// surface is averaged under a Gaussian of half the line spacing, without which the sum has aliases; the ratio of V
    /// under the wider kernel makes up for that.
    INSONIFY_FN vec2 of_line(float spacing) const {
        const float width = 0.55F * spacing, a = phase_per_metre_ * bend_ * width * width;
        const float turns = phase_per_metre_ * sine_ * width, b = turns * turns / (1 + a * a);
        const float q = phase(), wider = q + a;
        const float ratio = std::sqrt(std::sqrt((1 + wider * wider) / ((1 + q * q) * (1 + a * a))));
        const float deeper = 0.5F * sine_ * sine_ / bend_; // than the nearest place, metres
        return polar(ratio * std::exp(-0.5F * b), 0.5F * (a * b - std::atan(a)) - phase_per_metre_ * deeper);
    }

    /// |V| at its middle.
    INSONIFY_FN float at_middle() const { return 1 / std::sqrt(std::sqrt(1 + phase() * phase())); }
    /// V. @param offset  x0, metres
    INSONIFY_FN vec2 whole(float offset) const {
        const float q = phase(), x = offset / sigma_;
        return polar(std::exp(-0.5F * x * x * q * q / (1 + q * q)) * at_middle(), -0.5F * std::atan(q));
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

/// What keeps the level of one kind of echoes at one depth of a line.
struct kernel_level {
    float gain = 1;    ///< keeps their rms
    vec2 spread{0, 0}; ///< m^2: mean square distance between correlated echoes, across lines and planes
    float loss = 0;    ///< m^4: the next term of the loss on a slope; see `compensated_echoes::scatterers`
};

/// What the lateral kernel and the elevation planes do to echoes at one depth of a line.
struct kernel_sample {
    float lateral_sigma = 0;     ///< of the Gaussian that `convolve` applies across the lines, metres; 0: none
    float elevation_sigma = 0;   ///< of the beam out of the slice plane, metres; 0: unknown
    float line_spacing = 0;      ///< metres to the next line
    float divergence = 0;        ///< of neighbouring lines: angle over distance, 1/m
    kernel_level speckle{};      ///< of speckle
    kernel_level surface{};      ///< of the diffuse echoes of surfaces
    float uncorrelated_gain = 1; ///< keeps the rms of echoes that are independent from line to line
};

/// What one elevation plane stands for at one depth.
struct plane_sample {
    float height = 0;        ///< metres out of the slice plane
    float weight = 0;        ///< of coherent echoes; the sum over the planes is 1
    float random_weight = 1; ///< of independent echoes, over `weight`
    vec2 strip{0, 0};        ///< see `elevation_planes::weights::strip`
};

/// The kernels along one line, by displayed depth.
struct line_kernels {
    view<const kernel_sample> samples{};  ///< for equal parts of the displayed depth, from the face on
    view<const plane_sample> of_planes{}; ///< for each part those of all planes
    float spacing = 1;                    ///< metres of displayed depth to each part
    std::uint32_t planes = 1;             ///< elevation planes
    std::uint32_t plane = 0;              ///< of the line
    float speckle_length = 0;             ///< correlation length of speckle across the lines, metres
    float surface_length = 0;             ///< the same of the echoes of rough surfaces

    /// The part that a displayed depth lies in, metres.
    INSONIFY_FN std::size_t index(float depth) const {
        return static_cast<std::size_t>(clamp(depth / spacing, 0, static_cast<float>(samples.size() - 1)));
    }
    /// All planes at a displayed depth, metres; none where there are no kernels.
    INSONIFY_FN view<const plane_sample> planes_at(float depth) const {
        if (samples.empty()) return {};
        return {of_planes.data() + index(depth) * planes, planes};
    }
    /// Of independent echoes, at a displayed depth, metres: linear between the parts, as `elevation_planes::at`.
    INSONIFY_FN float random_weight(float depth) const {
        if (samples.empty()) return 1;
        const table_place place{depth / spacing - 0.5F, samples.size()};
        const float a = of_planes[place.above * planes + plane].random_weight,
                    b = of_planes[place.below * planes + plane].random_weight;
        return a + place.part * (b - a);
    }
    /// The kernels at a displayed depth, metres; without effect where there are none.
    INSONIFY_FN kernel_sample at(float depth) const {
        return samples.empty() ? kernel_sample{} : samples[index(depth)];
    }
};

/// How far apart those paths are that stand for neighbouring lines: curved mirrors spread or gather them.
struct path_spread {
    float spacing = 0;   ///< at the displayed depth `from`, metres; 0: that of the lines, at any depth
    float per_metre = 0; ///< how it grows
    float from = 0;      ///< metres
    float parts = 1;     ///< paths that each line is divided into, among which random echoes are divided
    float coherent = 1;  ///< factor on coherent echoes, which are those of the whole: `parts` on the middle one, else 0
};

/// An `echo_line` that compensates for the kernels before it writes.
class compensated_echoes {
  public:
    /// @param pulse_sigma  standard deviation of the pulse envelope, metres of displayed depth
    INSONIFY_FN compensated_echoes(const echo_line& echoes, const line_kernels& kernels, float frequency,
                                   float pulse_sigma)
        : echoes_{echoes}, kernels_{kernels}, frequency_{frequency}, sigma_{pulse_sigma},
          phase_per_metre_{4 * pi * frequency / display_speed} {}

    INSONIFY_FN float depth() const { return echoes_.depth(); }
    /// Of what is written from now on.
    INSONIFY_FN void set_spread(const path_spread& spread) { spread_ = spread; }
    /// As `echo_line::add`: an echo without compensation.
    INSONIFY_FN void add(float depth, vec2 amplitude) const { echoes_.add(depth, amplitude); }

    /// The specular law contains the loss of a tilted surface; what the kernels would take again is divided out.
    INSONIFY_FN void surface(float depth, float amplitude, vec2 slope) const {
        if (spread_.coherent == 0) return;
        amplitude *= spread_.coherent;
        echoes_.surface(depth, amplitude / (lateral_transfer(depth, slope.x) * elevation_transfer(depth, slope.y)),
                        slope);
    }

    /// The echo of a surface that turns from line to line, or from plane to plane, with its repetitions. Every plane
    /// that meets it emits the echo of the whole, where the surface is nearest to the probe.
    INSONIFY_FN void curved_surface(curved_echo one) const {
        if (spread_.coherent == 0) return;
        one.amplitude *= spread_.coherent;
        const kernel_sample here = kernels_.at(one.depth);
        // Depth is measured along the lines: their divergence adds to the curvature that is seen from line to line, but
        // does not weaken the echo.
        const curved_kernel own{phase_per_metre_, one.slope.x, one.curvature.x, here.lateral_sigma},
            across{phase_per_metre_, one.slope.x, one.curvature.x + here.divergence, here.lateral_sigma},
            out_of_slice{phase_per_metre_, one.slope.y, one.curvature.y, here.elevation_sigma};
        const float in_lines = across.strength(), in_planes = out_of_slice.strength();
        const auto repeat = [&](float first, vec2 amplitude) {
            one.for_each_repetition(
                depth() - first, [&](float deeper, float factor) { echoes_.add(first + deeper, factor * amplitude); });
        };
        const auto add = [&](float first, vec2 of_line) {
            if (in_planes < 1)
                repeat(first, ((1 - in_planes) * raised(one.collected.y, elevation_transfer(one.depth, one.slope.y))) *
                                  of_line);
            if (in_planes > 0) {
                const vec2 nearest = out_of_slice.to_nearest();
                repeat(first + nearest.y,
                       in_planes * complex_product(of_line, of_planes(one.depth, out_of_slice, nearest.x)));
            }
        };
        if (in_lines < 1)
            add(one.depth,
                {one.amplitude * (1 - in_lines) * raised(one.collected.x, lateral_transfer(one.depth, one.slope.x)),
                 0});
        if (in_lines > 0)
            add(one.depth + across.to_nearest().y,
                (one.amplitude * in_lines * own.at_middle() / across.at_middle()) * across.of_line(here.line_spacing));
    }

    /// The rms of speckle is kept. On a slope s the echoes of neighbouring lines differ in phase, q a metre: two lines
    /// d apart by q d; what they have in common counts by the cosine. So the power is
    ///
    ///     exp(-(spread q^2 / 2 + loss q^4)),   q = 4 pi f0 s / c0
    INSONIFY_FN void scatterers(scatterer_echoes run) const {
        const auto gain = [&](float depth) {
            const kernel_sample here = kernels_.at(depth);
            const vec2 q_squared = square(phase_per_metre_) * run.slope * run.slope,
                       lost = 0.5F * q_squared * here.speckle.spread;
            return spread_gain(here, here.speckle.gain, kernels_.speckle_length, depth) *
                   kernels_.random_weight(depth) *
                   std::exp(0.5F * min(lost.x + lost.y + here.speckle.loss * q_squared.x * q_squared.x, 2));
        };
        constexpr float max_level = 1e20F; // keeps sums finite
        run.first_level = min(run.first_level * gain(run.depth), max_level);
        run.last_level = min(run.last_level * gain(run.depth + run.step * static_cast<float>(run.count)), max_level);
        echoes_.scatterers(run);
    }

    /// A sloping rough surface covers a range of depths within the width of the line and the strip of its plane: it is
    /// divided into independent parts over that range, of the same total power: no stairs.
    ///
    /// On neighbouring lines the surface is s d deeper, with other values of its field. Their correlation falls by
    /// exp(-(s d)^2 (1 / l^2 + k^2) / 2), where l = 0.632 grains is the correlation length of the field and k
    /// the phase a metre; far apart they are independent.
    template <class Value>
    INSONIFY_FN void rough_surface(float depth, float amplitude, vec2 slope, vec3 curvature, const Value& value) const {
        const kernel_sample here = kernels_.at(depth);
        const float per_metre = 1 / square(0.632F * surface_grain(frequency_)) + square(phase_per_metre_);
        const vec2 decorrelation = vec2{1, 1} + slope * slope * here.surface.spread * per_metre;
        const view<const plane_sample> planes = kernels_.planes_at(depth);
        const surface_strip strip{slope.y, curvature.y, planes.empty() ? vec2{0, 0} : planes[kernels_.plane].strip};
        const float range = min(path_spacing(here, depth) * std::fabs(slope.x) + strip.range(), 3e-3F);
        constexpr float flat = 0.01F; // of a part: a plate that is parallel to the face only by rounding is one part
        const float part = max(0.5F * sigma_, 1e-6F), steps = std::ceil(range / part - flat);
        const float gain = min(spread_gain(here, here.surface.gain, kernels_.surface_length, depth) *
                                   std::sqrt(std::sqrt(decorrelation.x * decorrelation.y)),
                               here.uncorrelated_gain * std::sqrt(spread_.parts));
        const float level = amplitude * gain / std::sqrt(steps + 1);
        const float along_strip = strip.deeper(1) > strip.deeper(0) ? 1.0F : -1.0F,
                    across = along_strip * max(steps * part - strip.range(), 0);
        for (int i = 0; i <= static_cast<int>(steps); ++i) {
            const float place = steps > 0 ? static_cast<float>(i) / steps : 0.5F;
            const float deeper = strip.deeper(place) + (place - 0.5F) * across;
            echoes_.add(depth + deeper, value(deeper) * (level * kernels_.random_weight(depth + deeper)));
        }
    }

  private:
    // Limits the gain: the echo of a small or curved surface is weakened less than that of a plane. Convention; +-30 %:
    // 0.2 dB rms in a picture of surfaces.
    static constexpr float min_transfer = 0.15F;

    // The part of an echo that the aperture collects, over what the kernels keep of it. At most twice the echo: the
    // lines and planes that meet the edge of a steep surface have half of the kernel's weight.
    INSONIFY_FN static float raised(float collected, float transfer) { return min(collected / transfer, 2); }

    // Metres from one path to the next.
    INSONIFY_FN float path_spacing(const kernel_sample& here, float depth) const {
        if (spread_.spacing == 0) return here.line_spacing;
        return std::fabs(spread_.spacing + spread_.per_metre * (depth - spread_.from)) / spread_.parts;
    }
    // The gain that keeps the rms of random echoes on paths that are not as far apart as the lines. The kernels average
    // over paths of which a number within the correlation length, at least 1, is as one, instead of over lines of which
    // another number is.
    INSONIFY_FN float spread_gain(const kernel_sample& here, float of_lines, float correlation_length,
                                  float depth) const {
        if (spread_.spacing == 0) return of_lines;
        const float spacing = path_spacing(here, depth);
        const float as_one = max(correlation_length / max(spacing, 1e-9F), 1),
                    lines_as_one = max(correlation_length / max(here.line_spacing, 1e-9F), 1);
        return max(of_lines * std::sqrt(spread_.parts * lines_as_one / as_one), 1);
    }

    // Fraction of a sloping surface's echo that `convolve` keeps. The Gaussian across the lines, narrowed to where the
    // pulse still overlaps, 1 / sigma'^2 = 1 / sigma_x^2 + s^2 / sigma_z^2, and its spectrum at the phase gradient
    // 4 pi f0 s / c0 and at the nearest aliases of the line spacing.
    INSONIFY_FN float lateral_transfer(float depth, float slope) const {
        const kernel_sample here = kernels_.at(depth);
        if (!(here.lateral_sigma > 0) || !(here.line_spacing > 0)) return 1;
        const float narrowed = 1 / std::sqrt(1 + square(here.lateral_sigma * slope / sigma_));
        const float phase = phase_per_metre_ * slope, alias = 2 * pi / here.line_spacing;
        const float nearest = phase - alias * std::floor(phase / alias + 0.5F);
        float kept = 0, all = 0;
        for (int i = -1; i <= 1; ++i) {
            const float shift = static_cast<float>(i) * alias;
            kept += std::exp(-0.5F * square(narrowed * here.lateral_sigma * (nearest + shift)));
            all += std::exp(-0.5F * square(here.lateral_sigma * shift));
        }
        return max(narrowed * kept / all, min_transfer);
    }

    // The same for the planes of the slice, by how much deeper the surface is in each.
    INSONIFY_FN float elevation_transfer(float depth, float slope) const {
        const view<const plane_sample> planes = kernels_.planes_at(depth);
        if (planes.empty() || slope == 0) return 1;
        float sum = 0;
        for (const plane_sample& one : planes) {
            const float deeper = slope * one.height, sigmas = deeper / sigma_;
            sum += one.weight * std::exp(-0.5F * sigmas * sigmas) * std::cos(phase_per_metre_ * deeper);
        }
        return max(std::fabs(sum), min_transfer);
    }

    // What a plane that meets a curved surface emits: the whole, over the weight of all planes that do. Those that meet
    // it obliquely, where its radius is uncertain, are used where there are no others.
    INSONIFY_FN vec2 of_planes(float depth, const curved_kernel& surface, float to_nearest) const {
        const view<const plane_sample> planes = kernels_.planes_at(depth);
        if (planes.empty()) return surface.whole(to_nearest);
        const float middle = planes[kernels_.plane].height + to_nearest, radius = surface.radius();
        constexpr float oblique = 0.85F;
        const bool is_oblique = std::fabs(to_nearest) > oblique * radius;
        float well = 0, obliquely = 0; // met
        for (std::uint32_t i = 0; i < kernels_.planes; ++i) {
            const float apart = std::fabs(planes[i].height - middle), weight = planes[i].weight;
            if (i == kernels_.plane ? !is_oblique : apart <= oblique * radius)
                well += weight;
            else if (i == kernels_.plane || apart < radius)
                obliquely += weight;
        }
        if (is_oblique && well > 0) return {0, 0};
        return surface.whole(middle) / max(is_oblique ? obliquely : well, 1e-3F);
    }

    INSONIFY_FN static float square(float x) { return x * x; }
    echo_line echoes_;
    line_kernels kernels_;
    path_spread spread_{};
    float frequency_;
    float sigma_;
    float phase_per_metre_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
