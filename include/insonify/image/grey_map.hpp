#ifndef INSONIFY_IMAGE_GREY_MAP_HPP
#define INSONIFY_IMAGE_GREY_MAP_HPP

#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/image/image.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// The last curve before the screen. As it stands it changes nothing; black and white stay what they are.
struct grey_map {
    float gamma = 1;    ///< exponent: below 1 lifts the dark greys, above 1 presses them down
    float contrast = 0; ///< share of an S-curve, 0 to 1: dark greys darker, bright ones brighter

    /// s(g)^gamma, where s(g) = g + contrast (3 g^2 - 2 g^3 - g); g is cut off at 0 and 1.
    INSONIFY_FN float operator()(float grey) const {
        const float g = clamped(grey, 0, 1);
        const float curved = g + contrast * (g * g * (3 - 2 * g) - g);
        return gamma == 1 ? curved : std::pow(curved, gamma);
    }

    /// @throws usage_error  naming the setting that makes no sense
    void check() const {
        if (!is_finite(gamma) || !(gamma > 0))
            throw usage_error{"grey_map: `gamma` must be a finite number above 0; 1 changes nothing"};
        if (!(contrast >= 0 && contrast <= 1)) throw usage_error{"grey_map: `contrast` must be from 0 to 1"};
    }
};

/// Applies a curve to every pixel, in place: pass std::move(picture).
/// @throws usage_error  where a setting makes no sense
template <exec::policy Policy>
image map_grey(const Policy& policy, image picture, const grey_map& map) {
    map.check();
    exec::for_each_block(policy, picture.pixels.size(), 4096, 10, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) picture.pixels[i] = map(picture.pixels[i]);
    });
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
