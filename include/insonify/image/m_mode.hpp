#ifndef INSONIFY_IMAGE_M_MODE_HPP
#define INSONIFY_IMAGE_M_MODE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/image/image.hpp>
#include <insonify/probe/line_grid.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Size of an M-mode image.
struct m_mode_settings {
    std::uint32_t columns = 512; ///< moments that are shown
    std::uint32_t rows = 0;      ///< depths; 0: the samples of the lines
    float background = 0;        ///< brightness of moments before the first one
};

/// M-mode: one line against time.
class m_mode {
  public:
    /// @throws usage_error  for a number of columns or rows out of range
    explicit m_mode(const m_mode_settings& settings = {}) : settings_{settings} {
        detail::check_size({settings.columns, std::max(settings.rows, 1U)}, "m_mode");
        if (!is_finite(settings.background)) throw usage_error{"m_mode: `background` must be finite"};
    }

    /// Adds a line as the newest column, and drops the oldest. Starts anew where the depth of the lines changes, or
    /// their number of samples while `rows` is 0. Rows lie between samples: brightness is interpolated linearly.
    /// @param lines  brightness, as `scanner::lines`
    /// @throws usage_error  for a line that does not exist
    void add(const scan_lines& lines, std::uint32_t line) {
        if (line >= lines.count || lines.samples == 0)
            throw usage_error{"m_mode: the line is ", line, " of ", lines.count, ", counted from 0"};
        const uvec2 size{settings_.columns, settings_.rows != 0 ? settings_.rows : lines.samples};
        if (picture_.pixels.empty() || picture_.size != size || lines.depth != depth_) {
            detail::check_size(size, "m_mode");
            picture_ = image{size, settings_.background};
            depth_ = lines.depth;
            count_ = 0;
        }
        const float* const values = lines.values.data() + std::size_t{line} * lines.samples;
        const auto rows = static_cast<float>(size.y), samples = static_cast<float>(lines.samples);
        for (std::uint32_t row = 0; row < size.y; ++row) {
            float* const oldest = &picture_(0, row);
            std::copy(oldest + 1, oldest + size.x, oldest);
            const detail::table_place at{(static_cast<float>(row) + 0.5F) / rows * samples - 0.5F, lines.samples};
            picture_(size.x - 1, row) = values[at.above] + at.part * (values[at.below] - values[at.above]);
        }
        count_ = std::min(count_ + 1, size.x);
    }

    /// Time from left to right: the newest column is the last one. Depth from 0 at the upper edge to `depth()`. Empty
    /// before the first column.
    image picture() const { return picture_; }

    std::uint32_t count() const { return count_; } ///< columns that have been added, at most `columns`
    float depth() const { return depth_; }         ///< of the lower edge, metres

  private:
    m_mode_settings settings_{};
    image picture_{};
    std::uint32_t count_ = 0;
    float depth_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
