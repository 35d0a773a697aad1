#ifndef INSONIFY_EXAMPLES_PICTURE_STRIP_HPP
#define INSONIFY_EXAMPLES_PICTURE_STRIP_HPP

#include <insonify/image/image.hpp>
#include <insonify/probe/line_grid.hpp>
#include <algorithm>
#include <vector>

/// Images of one height side by side, with gaps between them, as one image.
class picture_strip {
  public:
    explicit picture_strip(std::uint32_t height) : height_{height} {}

    void add(const insonify::image& picture) { pictures_.push_back(picture); }

    /// Lines side by side, one column each; a pixel is the maximum of its samples.
    void add(const insonify::scan_lines& lines) {
        insonify::image columns{{lines.count, height_}};
        for (std::uint32_t line = 0; line < lines.count; ++line)
            for (std::uint32_t k = 0; k < lines.samples; ++k) {
                float& pixel = columns(line, k * height_ / lines.samples);
                pixel = std::max(pixel, lines(line, k));
            }
        add(columns);
    }

    insonify::image picture() const {
        constexpr std::uint32_t gap = 6;
        std::uint32_t width = 0;
        for (const insonify::image& each : pictures_) width += each.size.x + gap;
        insonify::image strip{{width - gap, height_}, 1.0F};
        std::uint32_t begin = 0;
        for (const insonify::image& each : pictures_) {
            for (std::uint32_t row = 0; row < std::min(height_, each.size.y); ++row)
                for (std::uint32_t column = 0; column < each.size.x; ++column)
                    strip(begin + column, row) = each(column, row);
            begin += each.size.x + gap;
        }
        return strip;
    }

  private:
    std::uint32_t height_;
    std::vector<insonify::image> pictures_{};
};

#endif
