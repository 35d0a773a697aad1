#ifndef INSONIFY_SIGNAL_KERNEL_ELEVATION_HPP
#define INSONIFY_SIGNAL_KERNEL_ELEVATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Maximum number of elevation planes of a frame.
inline constexpr std::uint32_t max_elevation_planes = 7;

namespace detail {

/// A plane in the coordinates of a probe, y = offset + slope z: the slice plane, or one above or below it that is
/// tilted about the lateral axis.
struct elevation_plane {
    float offset = 0; ///< metres out of the slice plane at z = 0
    float slope = 0;  ///< metres out of the slice plane per metre of depth

    /// Metres out of the slice plane at a depth in metres.
    INSONIFY_FN float height(float depth) const { return offset + slope * depth; }
};

/// @throws usage_error  for a number of elevation planes other than 1, 3, 5 or 7
inline void check_planes(std::uint32_t count, const char* caller) {
    if (count % 2 == 0 || count > max_elevation_planes)
        throw usage_error{caller, ": `planes` is ", count,
                          "; it must be 1, 3, 5 or 7: the slice plane, and pairs to both sides of it"};
}

/// Whether the planes of a probe can follow its beam with the depth z: all lines within 60 degrees of z.
inline bool lines_follow_depth(const probe_lines& probe) {
    const view<const probe_line> lines = probe.lines();
    return std::all_of(lines.begin(), lines.end(), [](const probe_line& line) { return line.direction.z > 0.5F; });
}

/// The heights of a pair of planes: see `elevation_planes`.
struct elevation_pair {
    float delta = 0;
    float psi = 0; ///< radians
};

/// The pairs of 3, 5 or 7 planes; none for another count.
inline view<const elevation_pair> elevation_pairs(std::uint32_t count) {
    static constexpr elevation_pair pairs[][3] = {{{0.92F, 109_deg}},
                                                  {{1.104F, 115.4_deg}, {1.625F, 28.7_deg}},
                                                  {{0.93F, 182.5_deg}, {2.562F, 181.4_deg}, {1.361F, 96.8_deg}}};
    if (count < 3 || count > max_elevation_planes) return {};
    return {pairs[count / 2 - 1], count / 2};
}

/// Planes that sample the thickness of the slice: the slice plane, and pairs to both sides of it that follow the beam.
///
/// The variance of the beam is sigma_f^2 + g(z)^2, of diffraction and of the aperture's shadow g (see `beam_model`). A
/// pair lies at the heights
///
///     y = +- delta (sigma_f cos psi + g(z) sin psi)
///
/// which are linear in z: both are planes. With psi near 0 they sample the diffraction and hardly tilt; near 90 degrees
/// they follow the shadow and cross at the focus. Depth is measured along z: where lines diverge, along the middle one.
/// On a line at an angle t to z the heights change cos t times as fast with the depth along the line, which no plane
/// that serves all lines can avoid; the weights are those of the heights that the planes have there: see `along`.
/// Source: numerical searches for a small error in the echoes of half spaces that begin at any height. Of what was
/// found, the pairs of 5 and 7 planes fill an anechoic sphere of 3 mm at the elevation focus as the beam does within 2
/// dB; the last change, by less than a degree, was made by hand. `bench/studies/elevation_planes.cpp` prints their
/// errors beside the smallest that it finds.
class elevation_planes {
  public:
    /// @param count  1, 3, 5 or 7: the middle one, and pairs
    /// @param depth  of the image, metres
    /// @param tilted  whether planes follow the beam; else they are parallel, at the heights of half the depth
    /// @param pairs   (count - 1) / 2 of them; empty: those of `elevation_pairs`
    /// @throws usage_error  for another count
    elevation_planes(const beam_model& beam, std::uint32_t count, float depth, bool tilted,
                     view<const elevation_pair> pairs = {})
        : beam_{beam}, count_{count}, spacing_{depth / depths} {
        check_planes(count, "trace");
        if (pairs.empty()) pairs = elevation_pairs(count);
        for (std::uint32_t i = 1; i < count; ++i) {
            const elevation_pair& own = pairs[(i - 1) / 2];
            const float side = i % 2 == 0 ? own.delta : -own.delta;
            const float at_focus = side * std::cos(own.psi) * beam.elevation_diffraction();
            const auto height = [&](float z) { return at_focus + side * std::sin(own.psi) * beam.elevation_shadow(z); };
            planes_[i] = tilted ? elevation_plane{height(0), (height(depth) - height(0)) / depth}
                                : elevation_plane{height(0.5F * depth), 0};
        }
        make_table();
    }

    /// The same planes by the depth along a line, with the weights that belong to their heights there.
    /// @param begin   z of its origin, metres
    /// @param cosine  of its angle to z
    elevation_planes along(float begin, float cosine) const {
        elevation_planes line = *this;
        for (elevation_plane& one : line.planes_) one = {one.height(begin), one.slope * cosine};
        line.make_table();
        return line;
    }

    std::uint32_t count() const { return count_; }
    /// The slice plane, then pairs.
    const elevation_plane& operator[](std::size_t plane) const { return planes_[plane]; }

    /// Height of the cells of the scatterer field out of the slice, metres, at all depths, so that speckle stays the
    /// same as tissue moves in depth. For several planes it has the correlation length of the beam twice as deep as its
    /// focus, sqrt(5) sigma; nearer to the focus, `phase_spread` shortens it. For a single plane that of the beam at
    /// 1.75 times the focus: a compromise, since phases are not spread. See `bench/studies/elevation_motion.cpp`.
    float scatterer_height() const { return (count_ > 1 ? 0.7F : 0.5F) * beam_.elevation_height; }

    /// How fast the phases of the scatterers of one place come apart as the probe moves out of the slice: rms, rad/m.
    ///
    /// The echoes of a Gaussian beam of standard deviation sigma have the correlation
    ///
    ///     rho(d) = integral of w(y) w(y + d) dy / integral of w(y)^2 dy = exp(-d^2 / (4 sigma^2))
    ///     w(y) = exp(-y^2 / (2 sigma^2))
    ///
    /// after a shift by d. Cells of height H, linear from one to the next, have exp(-2.5 d^2 / (2 H^2)); phases of rms
    /// s a metre have exp(-s^2 d^2 / 2). The product is rho where s^2 = 1 / (2 sigma^2) - 2.5 / H^2. A single plane has
    /// its cells alone.
    float phase_spread(float depth) const {
        if (count_ == 1) return 0;
        const float sigma = beam_.elevation_sigma(depth), height = scatterer_height();
        return std::sqrt(max(0.5F / (sigma * sigma) - 2.5F / (height * height), 0));
    }

    /// Half height s of the strip of the beam that each plane stands for at a depth, metres: its power exp(-y^2 / s^2)
    /// and the distances between the planes together have the variance of the beam's.
    float strip(float depth) const {
        const float sigma = beam_.elevation_sigma(depth);
        const weights parts = at(depth);
        float apart = 0;
        for (std::uint32_t i = 0; i < count_; ++i) {
            const float height = parts.random[i] * planes_[i].height(depth);
            apart += height * height;
        }
        return std::sqrt(max(sigma * sigma - 2 * apart, 0));
    }

    /// The fraction of an echo that each plane adds at one depth.
    struct weights {
        float coherent[max_elevation_planes] = {}; ///< echoes of surfaces add by amplitude; the sum is 1
        float random[max_elevation_planes] = {};   ///< independent echoes add by power; the sum of squares is 1
        /// The strip of tissue that each plane represents: its lower and upper end, metres from the height of the
        /// plane, with the mean and variance of the beam power that the plane represents. That of a single plane is
        /// empty.
        vec2 strip[max_elevation_planes] = {};
    };

    /// At a depth in metres: linear between the depths of a table.
    weights at(float depth) const {
        if (count_ == 1) return {.coherent = {1}, .random = {1}};
        const table_place place{depth / spacing_ - 0.5F, depths};
        const weights &a = table_[place.above], &b = table_[place.below];
        weights found;
        for (std::uint32_t i = 0; i < count_; ++i) {
            found.coherent[i] = a.coherent[i] + place.part * (b.coherent[i] - a.coherent[i]);
            found.random[i] = a.random[i] + place.part * (b.random[i] - a.random[i]);
            found.strip[i] = a.strip[i] + place.part * (b.strip[i] - a.strip[i]);
        }
        return found;
    }

  private:
    static constexpr std::uint32_t depths = 128; // parts of the depth of the image

    void make_table() {
        if (count_ == 1) return; // the same at every depth: see `at`
        for (std::uint32_t k = 0; k < depths; ++k) table_[k] = integrate((static_cast<float>(k) + 0.5F) * spacing_);
    }

    // Each plane represents the strip of the beam that is nearest to it: by the integral of the two-way amplitude
    // exp(-y^2 / 2 sigma^2) over it, or of its square. Borders are soft, so that the weights of planes that cross are
    // continuous.
    weights integrate(float depth) const {
        constexpr float step = 0.25F, softness = 0.25F; // standard deviations
        constexpr int steps = 16;
        const float sigma = beam_.elevation_sigma(depth);
        float height[max_elevation_planes];
        for (std::uint32_t i = 0; i < count_; ++i) height[i] = planes_[i].height(depth) / sigma;
        weights found;
        float coherent = 0, power = 0;
        vec2 moment[max_elevation_planes] = {}; // first and second, of the power
        for (int k = 0; k < steps; ++k) {       // below the slice is the mirror image
            const float y = (static_cast<float>(k) + 0.5F) * step;
            float nearness[max_elevation_planes], nearest = FLT_MAX, total = 0;
            for (std::uint32_t i = 0; i < count_; ++i) {
                nearness[i] = (y - height[i]) * (y - height[i]);
                nearest = min(nearest, nearness[i]);
            }
            for (std::uint32_t i = 0; i < count_; ++i)
                total += nearness[i] = std::exp((nearest - nearness[i]) / (2 * softness * softness));
            const float amplitude = std::exp(-0.5F * y * y);
            for (std::uint32_t i = 0; i < count_; ++i) {
                found.coherent[i] += amplitude * nearness[i] / total;
                const float part = amplitude * amplitude * nearness[i] / total;
                found.random[i] += part;
                moment[i] += part * vec2{y, y * y};
            }
            coherent += amplitude;
            power += amplitude * amplitude;
        }
        for (std::uint32_t i = 0; i < count_; i += i == 0 ? 1 : 2) {
            for (float* const each : {found.coherent, found.random})
                if (i > 0) each[i] = each[i + 1] = 0.5F * (each[i] + each[i + 1]);
            if (i == 0) moment[0].x = 0;
            if (i > 0) moment[i] = 0.5F * vec2{moment[i].x - moment[i + 1].x, moment[i].y + moment[i + 1].y};
            if (i > 0) moment[i + 1] = {-moment[i].x, moment[i].y};
        }
        limit_variance(found.coherent, height, 1);
        limit_variance(found.random, height, 0.5F);
        for (std::uint32_t i = 0; i < count_; ++i) {
            const vec2 mean = moment[i] / max(found.random[i], 1e-12F);
            const float half = count_ == 1 ? 0 : std::sqrt(3 * max(mean.y - mean.x * mean.x, 0));
            found.strip[i] = sigma * (vec2{mean.x - half, mean.x + half} - height[i]);
            found.coherent[i] /= coherent;
            found.random[i] = std::sqrt(found.random[i] / power);
        }
        return found;
    }

    // Where the planes spread further than the beam, those far out lose weight to those near the middle, as by a
    // narrower Gaussian: each times exp(-g h^2), with the least g >= 0 by Newton's method. Their sum stays.
    // @param height, variance  in standard deviations of the beam
    void limit_variance(float (&weight)[max_elevation_planes], const float (&height)[max_elevation_planes],
                        float variance) const {
        float narrower = 0;
        for (int round = 0; round < 6; ++round) {
            float all = 0, kept = 0, second = 0, fourth = 0;
            for (std::uint32_t i = 0; i < count_; ++i) {
                const float squared = height[i] * height[i], part = weight[i] * std::exp(-narrower * squared);
                all += weight[i];
                kept += part;
                second += part * squared;
                fourth += part * squared * squared;
            }
            second /= kept;
            const float steepness = fourth / kept - second * second;
            if (round == 5 || !(second > 1.0001F * variance) || !(steepness > 0)) {
                for (std::uint32_t i = 0; i < count_; ++i)
                    weight[i] *= std::exp(-narrower * height[i] * height[i]) * all / kept;
                return;
            }
            narrower += (second - variance) / steepness;
        }
    }

    beam_model beam_;
    std::uint32_t count_;
    float spacing_;
    elevation_plane planes_[max_elevation_planes] = {};
    weights table_[depths] = {};
};

/// The elevation planes along each line of a probe. Lines at nearly the same angle share them. Keeps its memory.
class planes_of_lines {
  public:
    template <class Policy>
    void assign(const Policy& policy, const probe_lines& probe, const elevation_planes& planes) {
        set_of_line_.assign(probe.size(), 0);
        first_lines_.clear();
        const bool tilted = lines_follow_depth(probe) && planes.count() > 1;
        const auto angle = [&](std::uint32_t line) {
            return tilted ? static_cast<int>(std::lround(200 * (1 - probe[line].direction.z))) : 0;
        };
        for (std::uint32_t i = 0; i < probe.size(); ++i) {
            std::size_t set = 0;
            while (set < first_lines_.size() && angle(first_lines_[set]) != angle(i)) ++set;
            set_of_line_[i] = static_cast<std::uint32_t>(set);
            if (set == first_lines_.size()) first_lines_.push_back(i);
        }
        sets_.assign(first_lines_.size(), planes);
        if (tilted)
            for_each_index(policy, sets_.size(), [&](std::size_t set) {
                const probe_line& line = probe[first_lines_[set]];
                sets_[set] = planes.along(line.origin.z, line.direction.z);
            });
    }

    const std::vector<std::uint32_t>& set_of_line() const { return set_of_line_; }
    std::size_t sets() const { return sets_.size(); }
    const elevation_planes& operator[](std::size_t set) const { return sets_[set]; }

  private:
    std::vector<std::uint32_t> set_of_line_{};
    std::vector<elevation_planes> sets_{};
    std::vector<std::uint32_t> first_lines_{}; // of the sets
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
