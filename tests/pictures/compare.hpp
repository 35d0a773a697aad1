#ifndef INSONIFY_TESTS_PICTURES_COMPARE_HPP
#define INSONIFY_TESTS_PICTURES_COMPARE_HPP

#include <insonify/image/image.hpp>
#include <cmath>

namespace pictures {

using namespace insonify;

/// How like two pictures of one size are.
struct likeness {
    double pixels = 0;     ///< share of them within 2/255
    double structural = 0; ///< SSIM
    bool enough() const { return pixels >= 0.9975 && structural >= 0.995; }
};

/// Mean structural similarity over windows of 8 x 8 pixels, every 4 pixels, for grey from 0 to 1.
/// Source: Wang, Bovik, Sheikh & Simoncelli 2004, eq. 13, with K1 = 0.01 and K2 = 0.03.
inline double structural_similarity(const image& a, const image& b) {
    constexpr std::uint32_t window = 8;
    constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03, n = window * window;
    double sum = 0;
    std::size_t windows = 0;
    for (std::uint32_t top = 0; top + window <= a.size.y; top += window / 2)
        for (std::uint32_t left = 0; left + window <= a.size.x; left += window / 2) {
            double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
            for (std::uint32_t y = top; y < top + window; ++y)
                for (std::uint32_t x = left; x < left + window; ++x) {
                    const std::size_t i = std::size_t{y} * a.size.x + x;
                    const double p = static_cast<double>(a.pixels[i]), q = static_cast<double>(b.pixels[i]);
                    mean_a += p / n, mean_b += q / n, aa += p * p / n, bb += q * q / n, ab += p * q / n;
                }
            const double covariance = ab - mean_a * mean_b;
            const double variances = aa - mean_a * mean_a + bb - mean_b * mean_b;
            sum += (2 * mean_a * mean_b + c1) * (2 * covariance + c2) /
                   ((mean_a * mean_a + mean_b * mean_b + c1) * (variances + c2));
            ++windows;
        }
    return sum / static_cast<double>(windows);
}

inline likeness compare(const image& a, const image& b) {
    if (a.size != b.size) return {};
    std::size_t close = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) close += std::fabs(a.pixels[i] - b.pixels[i]) <= 2.5F / 255;
    return {static_cast<double>(close) / static_cast<double>(a.pixels.size()), structural_similarity(a, b)};
}

/// Picture, reference, and eight times their difference around middle grey, side by side.
inline image side_by_side(const image& a, const image& b) {
    image both{{3 * a.size.x, a.size.y}};
    for (std::uint32_t y = 0; y < a.size.y; ++y)
        for (std::uint32_t x = 0; x < a.size.x; ++x) {
            const std::size_t i = std::size_t{y} * a.size.x + x, to = std::size_t{y} * both.size.x + x;
            both.pixels[to] = a.pixels[i];
            both.pixels[to + a.size.x] = b.pixels[i];
            both.pixels[to + 2 * std::size_t{a.size.x}] = 0.5F + 8 * (a.pixels[i] - b.pixels[i]);
        }
    return both;
}

} // namespace pictures
#endif
