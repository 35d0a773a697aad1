#include <insonify/probe/line_grid.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace line_grid_test {

TEST_CASE("line_grid: values lie line after line, addressed by line and sample") {
    scan_lines lines{2, 3, 0.06F};
    CHECK(lines.count == 2);
    CHECK(lines.samples == 3);
    CHECK(lines.depth == 0.06F);
    CHECK(lines.values == std::vector<float>(6, 0.0F));
    lines(1, 0) = 5;
    CHECK(lines.values == std::vector<float>{0, 0, 0, 5, 0, 0});
    CHECK(lines(1, 0) == 5);
    CHECK(scan_lines{}.values.empty());
}

TEST_CASE("line_grid: grids are equal if shape, depth and all values are") {
    const scan_lines lines{2, 3, 0.06F};
    CHECK(lines == scan_lines{2, 3, 0.06F});
    CHECK(lines != scan_lines{3, 2, 0.06F});
    CHECK(lines != scan_lines{2, 3, 0.07F});
    scan_lines other = lines;
    other(0, 2) = 1;
    CHECK(lines != other);
}

} // namespace line_grid_test
