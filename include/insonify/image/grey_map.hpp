#ifndef INSONIFY_IMAGE_GREY_MAP_HPP
#define INSONIFY_IMAGE_GREY_MAP_HPP

#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/image/image.hpp>
#include <insonify/probe/line_grid.hpp>
#include <cstddef>
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
    INSONIFY_FN float operator()(float grey) const {
        const float g = clamp(grey, 0, 1);
        float curved = g + contrast * (g * g * (3 - 2 * g) - g);
        if (reject != 0 || shoulder != 1) {
            const float black = bent(0), white = bent(1);
            curved = clamp((bent(curved) - black) / (white - black), 0, 1);
        }
        return gamma == 1 ? curved : std::pow(curved, gamma);
    }

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
    INSONIFY_FN float bend(float x) const { return 0.5F * (x + std::sqrt(x * x + 4 * softness * softness)); }
    INSONIFY_FN float bent(float g) const {
        return (reject == 0 ? g : bend(g - reject)) - (shoulder == 1 ? 0 : 0.5F * bend(g - shoulder));
    }
};

namespace detail {

/// Applies a tone curve to brightness, in place.
template <exec::policy Policy>
void map_values(const Policy& policy, std::vector<float>& values, const grey_map& map) {
    map.check();
    exec::for_each_block(policy, values.size(), 4096, 10, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) values[i] = map(values[i]);
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
#endif
