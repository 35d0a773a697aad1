#ifndef INSONIFY_IMAGE_GREY_MAP_HPP
#define INSONIFY_IMAGE_GREY_MAP_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/image/image.hpp>
#include <insonify/probe/line_grid.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Tone curve for display; the identity by default. Black and white are fixed points.
struct grey_map {
    float gamma = 1;        ///< exponent: below 1 brightens, above 1 darkens the midtones
    float contrast = 0;     ///< strength of an S-curve, 0 to 1
    float reject = 0;       ///< brightness up to which the curve is nearly flat, 0 to below 1; 0: none
    float shoulder = 1;     ///< brightness from which the slope is halved, above 0 to 1; 1: none
    float softness = 0.05F; ///< half width of the bends of `reject` and `shoulder`, in brightness

    /// k(s(g))^gamma, where g is clamped to 0 to 1, s(g) = g + contrast (3 g^2 - 2 g^3 - g), and k has two bends:
    ///
    ///     k(s) = (b(s) - b(0)) / (b(1) - b(0)),   b(s) = h(s - reject) - h(s - shoulder) / 2
    ///     h(x) = (x + sqrt(x^2 + 4 softness^2)) / 2
    ///
    /// A term whose setting says "none" is left out, with h(s - reject) = s. h is 0 far below the bend and x far above.
    /// @{
    template <int N>
    INSONIFY_FN INSONIFY_INLINE lanes<N> of_lanes(const lanes<N>& grey) const {
        using floats = lanes<N>;
        const floats none(0.0F), full(1.0F), g = min(max(grey, none), full);
        floats curved = g + floats(contrast) * (g * g * (floats(3.0F) - floats(2.0F) * g) - g);
        if (reject != 0 || shoulder != 1) {
            const floats black = bent<N>(none), white = bent<N>(full);
            curved = min(max((bent<N>(curved) - black) / (white - black), none), full);
        }
        if (gamma == 1) return curved;
        return select(none < curved, power_of_two<N>(floats(gamma) * logarithm_of_two<N>(curved)), none);
    }
    INSONIFY_FN float operator()(float grey) const {
        float one = 0;
        store(of_lanes<1>(lanes<1>(grey)), &one);
        return one;
    }
    /// @}

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        if (!is_finite(gamma) || !(gamma > 0))
            throw usage_error{"grey_map: `gamma` must be finite and above 0; 1 changes nothing"};
        if (!(contrast >= 0 && contrast <= 1)) throw usage_error{"grey_map: `contrast` must be from 0 to 1"};
        if (!(reject >= 0 && reject < 1)) throw usage_error{"grey_map: `reject` must be at least 0 and below 1"};
        if (!(shoulder > 0 && shoulder <= 1))
            throw usage_error{"grey_map: `shoulder` must be above 0 and at most 1; 1 changes nothing"};
        if (!(softness > 0 && softness <= 1)) throw usage_error{"grey_map: `softness` must be above 0 and at most 1"};
    }

    friend bool operator==(const grey_map&, const grey_map&) = default;

  private:
    template <int N>
    INSONIFY_FN INSONIFY_INLINE lanes<N> bend(const lanes<N>& x) const {
        return lanes<N>(0.5F) * (x + sqrt(x * x + lanes<N>(4 * softness * softness)));
    }
    template <int N>
    INSONIFY_FN INSONIFY_INLINE lanes<N> bent(const lanes<N>& g) const {
        lanes<N> bent = reject == 0 ? g : bend<N>(g - lanes<N>(reject));
        if (shoulder != 1) bent = bent - lanes<N>(0.5F) * bend<N>(g - lanes<N>(shoulder));
        return bent;
    }
};

namespace detail {

/// Applies a tone curve to brightness, in place.
template <exec::policy Policy>
void map_values(const Policy& policy, std::vector<float>& values, const grey_map& map) {
    map.check();
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    exec::for_each_block(policy, values.size(), 16384, 1, [&](std::size_t begin, std::size_t end) {
        const grey_map own = map; // a local copy, which stores cannot alias, stays in registers
        float* const to = values.data();
        in_registers<width>(begin, end,
                            [&](std::size_t i, auto n) { store(own.of_lanes<n>(load<n>(to + i)), to + i); });
    });
}

} // namespace detail

/// Applies a tone curve to every pixel. In place: pass std::move(picture).
/// @throws usage_error  for a setting out of range
template <exec::policy Policy>
image map_grey(const Policy& policy, image picture, const grey_map& map) {
    detail::map_values(policy, picture.pixels, map);
    return picture;
}
/// Applies a tone curve to the brightness along lines, after `log_compress`. In place: pass std::move(lines).
/// @throws usage_error  for a setting out of range
template <exec::policy Policy>
scan_lines map_grey(const Policy& policy, scan_lines lines, const grey_map& map) {
    detail::map_values(policy, lines.values, map);
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
