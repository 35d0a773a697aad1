#ifndef INSONIFY_IMAGE_GREY_MAP_HPP
#define INSONIFY_IMAGE_GREY_MAP_HPP

#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/image/image.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// Tone curve for display; the identity by default. Black and white are fixed points.
struct grey_map {
    float gamma = 1;    ///< exponent: below 1 brightens, above 1 darkens the midtones
    float contrast = 0; ///< strength of an S-curve, 0 to 1

    /// s(g)^gamma, where s(g) = g + contrast (3 g^2 - 2 g^3 - g); g is clamped to 0 to 1.
    INSONIFY_FN float operator()(float grey) const {
        const float g = clamp(grey, 0, 1);
        const float curved = g + contrast * (g * g * (3 - 2 * g) - g);
        return gamma == 1 ? curved : std::pow(curved, gamma);
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        if (!is_finite(gamma) || !(gamma > 0))
            throw usage_error{"grey_map: `gamma` must be finite and above 0; 1 changes nothing"};
        if (!(contrast >= 0 && contrast <= 1)) throw usage_error{"grey_map: `contrast` must be from 0 to 1"};
    }
};

/// Applies a tone curve to every pixel. In place: pass std::move(picture).
/// @throws usage_error  for a setting out of range
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
