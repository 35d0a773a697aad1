#ifndef INSONIFY_DATASET_STATISTICS_HPP
#define INSONIFY_DATASET_STATISTICS_HPP

#include "layout.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace dataset {

/// What samples that are stored have in common, and how hard their labels are to guess.
class statistics {
  public:
    /// @param size    columns and rows of the images
    /// @param labels  number of them
    statistics(std::uint32_t size, std::size_t labels)
        : size_{size}, side_{std::min(size, 256U)}, labels_{labels}, at_pixel_(std::size_t{side_} * side_ * labels) {}

    void add(const stored_sample& one) {
        numbers_.push_back(one.numbers);
        if (one.label.size() != std::size_t{size_} * size_) return; // it could not be read
        std::array<bool, 256> seen{};
        for (const std::uint8_t label : one.label) {
            ++pixels_[label];
            seen[label] = true;
        }
        for (std::size_t label = 0; label < 256; ++label) images_[label] += seen[label] ? 1 : 0;
        for (std::size_t y = 0; y < side_; ++y)
            for (std::size_t x = 0; x < side_; ++x) {
                const std::uint8_t label = one.label[y * size_ / side_ * size_ + x * size_ / side_];
                if (label < labels_) ++at_pixel_[(y * side_ + x) * labels_ + label];
            }
    }

    std::size_t samples() const { return numbers_.size(); }
    /// A number of each sample: index into `layout::scalars`.
    std::vector<float> values(std::size_t number) const {
        std::vector<float> found;
        for (const std::vector<float>& one : numbers_) found.push_back(one[number]);
        return found;
    }
    std::size_t images_with(std::size_t label) const { return images_[label]; }
    /// Fraction of the pixels in the field of view that have a label.
    double fraction_of(std::size_t label) const {
        double inside = 0;
        for (std::size_t i = 0; i < labels_; ++i) inside += static_cast<double>(pixels_[i]);
        return inside > 0 ? static_cast<double>(pixels_[label]) / inside : 0;
    }
    /// Fraction of the pixels in the field of view whose label is the one that is most frequent at their place, of at most
    /// 256 x 256 places: what a predictor scores that knows the samples, but sees no image.
    double most_frequent_fraction() const {
        double right = 0, all = 0;
        for (std::size_t place = 0; place < at_pixel_.size(); place += labels_) {
            const auto* begin = &at_pixel_[place];
            right += *std::max_element(begin, begin + labels_);
            for (std::size_t label = 0; label < labels_; ++label) all += begin[label];
        }
        return all > 0 ? right / all : 0;
    }

  private:
    std::uint32_t size_, side_;
    std::size_t labels_;
    std::vector<std::uint16_t> at_pixel_; ///< side x side x labels: number of samples; `summary` counts fewer than 2^16
    std::array<std::size_t, 256> pixels_{}, images_{};
    std::vector<std::vector<float>> numbers_{};
};

} // namespace dataset
#endif
