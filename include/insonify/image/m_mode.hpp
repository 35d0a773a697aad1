#ifndef INSONIFY_IMAGE_M_MODE_HPP
#define INSONIFY_IMAGE_M_MODE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/memo.hpp>
#include <insonify/image/image.hpp>
#include <insonify/probe/line_grid.hpp>
#include <algorithm>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Size of an M-mode image.
struct m_mode_settings {
    std::uint32_t columns = 512; ///< moments that are shown
    std::uint32_t rows = 0;      ///< depths; 0: the samples of the lines
    float background = 0;        ///< brightness of moments before the first one
};

/// M-mode: one line against time.
///
///     m_mode sweep{{.columns = 400, .rows = 300}};
///     for (...) {
///         machine.scan(policy, body, at);
///         sweep.add(machine.lines(), 96);
///     }
///     write_png("m_mode.png", sweep.picture());
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
            throw usage_error{"m_mode: the line is " + std::to_string(line) + " of " + std::to_string(lines.count) +
                              ", counted from 0"};
        const std::uint32_t rows = settings_.rows != 0 ? settings_.rows : lines.samples;
        if (rows != rows_ || lines.depth != depth_) {
            detail::check_size({settings_.columns, rows}, "m_mode");
            columns_.assign(std::size_t{settings_.columns} * rows, settings_.background);
            rows_ = rows;
            depth_ = lines.depth;
            count_ = 0;
        }
        const float* const values = lines.values.data() + std::size_t{line} * lines.samples;
        float* const column = columns_.data() + std::size_t{next_ % settings_.columns} * rows;
        const auto last = static_cast<float>(lines.samples - 1);
        for (std::uint32_t row = 0; row < rows; ++row) {
            const float place =
                clamp((static_cast<float>(row) + 0.5F) / static_cast<float>(rows) * (last + 1) - 0.5F, 0, last);
            const float above = std::floor(place);
            const auto k = static_cast<std::size_t>(above);
            column[row] = values[k] + (place - above) * (values[k + (above < last ? 1 : 0)] - values[k]);
        }
        next_ = (next_ + 1) % settings_.columns;
        count_ = std::min(count_ + 1, settings_.columns);
    }

    /// Time from left to right: the newest column is the last one. Depth from 0 at the upper edge to `depth()`.
    image picture() const {
        image seen{{settings_.columns, rows_}, settings_.background};
        for (std::uint32_t x = settings_.columns - count_; x < settings_.columns; ++x)
            for (std::uint32_t y = 0; y < rows_; ++y)
                seen(x, y) = columns_[std::size_t{(next_ + x) % settings_.columns} * rows_ + y];
        return seen;
    }

    std::uint32_t count() const { return count_; } ///< columns that have been added, at most `columns`
    float depth() const { return depth_; }         ///< of the lower edge, metres

  private:
    m_mode_settings settings_{};
    std::vector<float> columns_{}; // a ring; column after column
    detail::cleared_by_move<std::uint32_t> rows_{};
    std::uint32_t next_ = 0;
    std::uint32_t count_ = 0;
    float depth_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
