#ifndef INSONIFY_CHANNELS_ELEMENT_FIELD_HPP
#define INSONIFY_CHANNELS_ELEMENT_FIELD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

/// The field of one rectangular element with a lens.
///
///     P(f) = (j k / 2 pi)  integral over the face of  exp(j k lens) cos exp(-j k r) / r           soft baffle
///          = (j k / 2 pi)  w sinc(k w sin t / 2) cos t  E(r, y) exp(-j k r) / r                   w << r
///
/// Received, of the same element: Q = P 2 pi / (j k w h), so that a mirror in front of an infinite face returns 1. A
/// point of scattering length L returns L P_n Q_m, a surface the integral of r (j k / 4 pi) (cos_n + cos_m) P_n Q_m.
/// Source: Rayleigh's integral with a pressure-release baffle; Kirchhoff's approximation of the surface.
namespace insonify::inline INSONIFY_ABI::detail {

/// A complex amplitude at four frequencies around the carrier, equal steps apart, from the lowest on. Between them it
/// is taken as a polynomial of degree three.
struct spectral_value {
    static constexpr int nodes = 4;
    lanes<nodes> x{0.0F}, y{0.0F};

    /// Of a node from the carrier, in steps.
    static constexpr float steps(int node) { return static_cast<float>(node) - 1.5F; }
    static lanes<nodes> steps() {
        return each_lane<nodes>([](int node) { return steps(node); });
    }
    /// The step of frequency, hertz. Larger steps follow the ends of the band better, smaller ones the carrier:
    /// `tests/channels/trace_channels.cpp` prints how well this one does both.
    static constexpr float step(float sigma, float frequency) { return 0.6F * min(sigma, frequency); }
    /// Weight of one of some nodes in the middle at a frequency. @param x  from the carrier, in steps
    static float weight(int node, int of, float x) {
        float product = 1;
        for (int i = 0; i < of; ++i)
            if (i != node)
                product *=
                    (x - static_cast<float>(i) + 0.5F * static_cast<float>(of - 1)) / static_cast<float>(node - i);
        return product;
    }

    /// With value(node) at each.
    template <class Value>
    static spectral_value each(const Value& value) {
        float real[nodes], imaginary[nodes];
        for (int i = 0; i < nodes; ++i) {
            const vec2 own = value(i);
            real[i] = own.x;
            imaginary[i] = own.y;
        }
        return {load<nodes>(real), load<nodes>(imaginary)};
    }
    static spectral_value everywhere(vec2 value) { return {lanes<nodes>(value.x), lanes<nodes>(value.y)}; }

    vec2 at(int node) const {
        float real[nodes], imaginary[nodes];
        store(x, real);
        store(y, imaginary);
        return {real[node], imaginary[node]};
    }
    vec2 at_carrier() const {
        vec2 sum{0, 0};
        for (int node = 0; node < nodes; ++node) sum += weight(node, nodes, 0) * at(node);
        return sum;
    }
    /// Some nodes in the middle: real and imaginary part of each. @tparam Some  2, or all
    template <int Some>
    void store_middle(float* to) const {
        float real[nodes], imaginary[nodes];
        store(x, real);
        store(y, imaginary);
        for (std::size_t k = 0; k < Some; ++k) {
            to[2 * k] = real[(nodes - Some) / 2 + k];
            to[2 * k + 1] = imaginary[(nodes - Some) / 2 + k];
        }
    }

    friend spectral_value operator*(const spectral_value& a, const spectral_value& b) {
        return {a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x};
    }
    friend spectral_value operator*(const lanes<nodes>& factor, const spectral_value& value) {
        return {factor * value.x, factor * value.y};
    }
    friend spectral_value operator+(const spectral_value& a, const spectral_value& b) { return {a.x + b.x, a.y + b.y}; }
};

/// Between two values: a at part 0, b at 1.
inline spectral_value mixed(const spectral_value& a, const spectral_value& b, float part) {
    return lanes<spectral_value::nodes>(1 - part) * a + lanes<spectral_value::nodes>(part) * b;
}

/// The root whose real part is not negative.
inline vec2 square_root(vec2 of) {
    const float size = length(of), real = std::sqrt(0.5F * max(size + of.x, 0.0F)),
                imaginary = std::sqrt(0.5F * max(size - of.x, 0.0F));
    return {real, of.y < 0 ? -imaginary : imaginary};
}
/// The same at all frequencies, continuous over them.
inline spectral_value square_root(const spectral_value& of) {
    vec2 before{0, 0};
    return spectral_value::each([&](int node) {
        const vec2 root = square_root(of.at(node));
        return before = dot(root, before) < 0 ? -root : root;
    });
}

/// The part of the field out of the slice plane, of an element of height h with a lens focused at F, by the distance r
/// and the height y of a point.
///
///     E(r, y) = integral over y' of exp(j k (lens(y') + r - r')) (r / r')^2,   lens(y') = sqrt(F^2 + y'^2) - F
///
/// In metres: h at the focus.
class elevation_field {
  public:
    std::uint64_t bytes() const {
        return (points_.size() + surfaces_.size()) * sizeof(spectral_value) + tissue_.size() * sizeof(float);
    }

    /// @param speed       of sound, m/s
    /// @param step        of frequency: see `spectral_value`, hertz
    /// @param max_range   metres
    /// @param max_height  of points above the middle of any element, metres; 0: all points lie in its slice
    template <exec::policy Policy>
    void assign(const Policy& policy, float frequency, float step, float height, float focus, float speed,
                float max_range, float max_height) {
        height_ = height;
        focus_ = focus;
        carrier_ = 2 * pi * frequency / speed;
        for (int i = 0; i < spectral_value::nodes; ++i)
            wave_number_[i] = 2 * pi * (frequency + spectral_value::steps(i) * step) / speed;
        // E changes over a wavelength times the range over h; most elements are higher than some wavelengths.
        row_ = max(height / 128, pi / (4 * carrier_));
        ranges_ = 2 + static_cast<std::size_t>(std::log(max(max_range, 2 * min_range) / min_range) * per_logarithm);
        heights_ = max_height > 0 ? 2 + static_cast<std::size_t>(max_height / row_) : 1;
        points_.resize(ranges_ * heights_);
        surfaces_.resize(ranges_);
        tissue_.resize(ranges_);
        exec::for_each_in_blocks(policy, ranges_, 4, 4e4F * static_cast<float>(heights_),
                                 [&](std::size_t i) { compute(i); });
    }

    /// Where ranges lie in the tables: for the next two. @param range  from the middle of the element, in space
    template <int N>
    lanes<N> position(const lanes<N>& range) const {
        const lanes<N> octaves = logarithm_of_two<N>(range * lanes<N>(1 / min_range));
        return min(max(octaves * lanes<N>(0.69314718F * per_logarithm), lanes<N>(0.0F)),
                   lanes<N>(static_cast<float>(ranges_ - 1)));
    }
    float position(float range) const { return sum(position<1>(lanes<1>(range))); }
    /// E of a point.
    spectral_value point(float position, float y) const {
        const place at = place_of(position);
        if (heights_ == 1) return interpolated(points_.data() + at.index, at.part);
        const float rows = std::fabs(y) / row_;
        const auto below = static_cast<std::size_t>(min(rows, static_cast<float>(heights_ - 2)));
        const float part = rows - static_cast<float>(below);
        if (part > 1) return {}; // beyond the highest point that was announced
        const spectral_value* const low = points_.data() + below * ranges_ + at.index;
        return mixed(interpolated(low, at.part), interpolated(low + ranges_, at.part), part);
    }
    /// The root of the integral over y of E^2: of each of two elements to a surface that is straight out of the slice.
    spectral_value surface(float position) const {
        const place at = place_of(position);
        return interpolated(surfaces_.data() + at.index, at.part);
    }
    /// What tissue returns from the height of the beam, over what a scatterer with `surface` of each element does: the
    /// integral over y of |P / P0|^4 over |integral of E^2|^2, where P0 is P in the slice with E = 1; 1/m. In the slice
    /// plane alone E changes fast with distance and frequency near the element, which scatterers at all heights do not.
    float tissue(float range) const {
        const place at = place_of(position(range));
        return (1 - at.part) * tissue_[at.index] + at.part * tissue_[at.index + 1];
    }

    /// The integral over y of E^2 on a surface that slopes and curves out of the slice plane, relative to that on a
    /// straight one. Its depth along the line from the element is s y + q y^2 / 2.
    ///
    /// With the two points of the element at a + b/2 and a - b/2, and paraxially, the integral over y is closed:
    ///
    ///     sqrt(pi r / (j k (1 + q r))) exp(-j k (b^2 / 4 r + a^2 / r - (a - s r)^2 / (r (1 + q r))))
    ///
    /// and those over a and b are sums.
    spectral_value bent_surface(float range, float slope, float curvature) const {
        if (std::fabs(slope) < 1e-4F && std::fabs(curvature) * range < 1e-3F) return spectral_value::everywhere({1, 0});
        return spectral_value::each([&](int i) {
            const vec2 bent = surface_integral(wave_number_[i], range, slope, curvature),
                       straight = surface_integral(wave_number_[i], range, 0, 0);
            return complex_product(bent, {straight.x, -straight.y}) / max(dot(straight, straight), 1e-30F);
        });
    }

  private:
    static constexpr float min_range = 1e-3F;                // metres
    static constexpr float per_logarithm = 48;               // ranges of a table are 2 % apart
    static constexpr int middle = spectral_value::nodes / 2; // a frequency near the carrier
    static constexpr int min_points = 48, max_points = 512;  // of an element, for sums over its height
    static constexpr int heights_of_tissue = 64;             // over which |E|^4 is summed

    struct place {
        std::size_t index;
        float part;
    };

    float range_at(std::size_t i) const { return min_range * std::exp(static_cast<float>(i) / per_logarithm); }
    // So many that the phase changes by less than one from one to the next.
    int points(float k, float range) const {
        return static_cast<int>(clamp(0.5F * k * height_ * height_ / range, min_points, max_points));
    }

    place place_of(float position) const {
        const auto index = static_cast<std::size_t>(min(position, static_cast<float>(ranges_ - 2)));
        return {index, position - static_cast<float>(index)};
    }
    static spectral_value interpolated(const spectral_value* from, float part) { return mixed(from[0], from[1], part); }

    float lens(float y) const { return y * y / (std::sqrt(focus_ * focus_ + y * y) + focus_); }

    vec2 field(float k, float range, float y) const {
        vec2 sum{0, 0};
        const int count = points(k, range);
        for (int i = 0; i < count; ++i) {
            const float from = height_ * ((static_cast<float>(i) + 0.5F) / static_cast<float>(count) - 0.5F),
                        beside = from * (from - 2 * y);
            const float there = std::sqrt(max(range * range + beside, 1e-12F));
            const float phase = k * (lens(from) - beside / (there + range)), weight = range * range / (there * there);
            sum += weight * vec2{std::cos(phase), std::sin(phase)};
        }
        return height_ / static_cast<float>(count) * sum;
    }

    void compute(std::size_t i) {
        const float range = range_at(i);
        for (std::size_t h = 0; h < heights_; ++h) {
            const float y = min(static_cast<float>(h) * row_, 0.95F * range);
            points_[h * ranges_ + i] =
                spectral_value::each([&](int node) { return field(wave_number_[node], range, y); });
        }
        const auto both = spectral_value::each([&](int node) {
            return std::sqrt(pi * range / wave_number_[node]) *
                   complex_product(surface_integral(wave_number_[node], range, 0, 0),
                                   {0.70710678F, -0.70710678F}); // 1 / sqrt(j)
        });
        // The root is continuous in the range: it has the phase of E, within a quarter turn.
        const spectral_value root = square_root(both);
        const float sign = dot(root.at(middle), points_[i].at(middle)) < 0 ? -1.0F : 1.0F;
        surfaces_[i] = lanes<spectral_value::nodes>(sign) * root;
        // Beyond the shadow of the element the field is weak, and beyond two diffraction widths as well.
        const float reach = height_ * (0.5F + std::fabs(1 - range / focus_)) + 4 * pi * range / (carrier_ * height_);
        const vec2 at_carrier = both.at_carrier();
        float sum = 0;
        for (int h = 0; h < heights_of_tissue; ++h) {
            const float y = reach * (static_cast<float>(h) + 0.5F) / heights_of_tissue;
            const float there = std::sqrt(range * range + y * y);
            const vec2 at = range / there * field(carrier_, there, y);
            sum += dot(at, at) * dot(at, at);
        }
        tissue_[i] = 2 * reach / heights_of_tissue * sum / max(dot(at_carrier, at_carrier), 1e-30F);
    }

    // Over a, then over b: see `bent_surface`, without its factor sqrt(pi r / j k).
    vec2 surface_integral(float k, float range, float slope, float curvature) const {
        float open = 1 + curvature * range; // how fast the reflected wave diverges out of the slice
        if (std::fabs(open) < 0.05F) open = open < 0 ? -0.05F : 0.05F;
        const int count = points(k, range), rows_of_a = 2 * count; // of b on each side of 0; a is twice as fine
        vec2 sums[2 * max_points + 1];
        sums[0] = {0, 0};
        const float step = height_ / static_cast<float>(2 * count);
        for (int i = 0; i < rows_of_a; ++i) {
            const float a = (static_cast<float>(i - count) + 0.5F) * step, beside = a - slope * range;
            const float phase = k * (a * a / focus_ - a * a / range + beside * beside / (range * open));
            sums[i + 1] = sums[i] + vec2{std::cos(phase), std::sin(phase)};
        }
        vec2 sum{0, 0};
        for (int i = 0; i < count; ++i) { // |b| = (i + 1/2) h / count leaves |a| <= (h - |b|) / 2
            const float b = 2 * (static_cast<float>(i) + 0.5F) * step;
            const float phase = 0.25F * k * b * b * (1 / focus_ - 1 / range);
            const auto end = [&](float rows) { // of the sum up to a fraction of a row
                const auto below = static_cast<int>(rows);
                const float part = rows - static_cast<float>(below);
                return below >= rows_of_a ? sums[rows_of_a] : (1 - part) * sums[below] + part * sums[below + 1];
            };
            const float half = 0.5F * (height_ - b) / step;
            sum += complex_product(end(static_cast<float>(count) + half) - end(static_cast<float>(count) - half),
                                   {std::cos(phase), std::sin(phase)});
        }
        const float root = 4 * step * step / std::sqrt(std::fabs(open)); // of both signs of b
        return open > 0 ? root * sum : root * vec2{-sum.y, sum.x};
    }

    float height_ = 0, focus_ = 0, row_ = 0, carrier_ = 0, wave_number_[spectral_value::nodes] = {};
    std::size_t ranges_ = 0, heights_ = 0;
    std::vector<spectral_value> points_{}; // by height, then by range
    std::vector<spectral_value> surfaces_{};
    std::vector<float> tissue_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
