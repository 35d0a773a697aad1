#ifndef INSONIFY_DATASET_QUATERNION_HPP
#define INSONIFY_DATASET_QUATERNION_HPP

#include <insonify/core/math.hpp>
#include <algorithm>
#include <array>
#include <cmath>

namespace dataset {

using namespace insonify;

/// (w, x, y, z) of a rotation. Source: Shepperd 1978.
inline std::array<float, 4> quaternion(const mat3& rotation) {
    const auto m = [&](int row, int column) { return static_cast<double>(rotation[column][row]); };
    const double squares[4] = {1 + m(0, 0) + m(1, 1) + m(2, 2), 1 + m(0, 0) - m(1, 1) - m(2, 2),
                               1 - m(0, 0) + m(1, 1) - m(2, 2), 1 - m(0, 0) - m(1, 1) + m(2, 2)};
    const double table[4][4] = {{squares[0], m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)},
                                {m(2, 1) - m(1, 2), squares[1], m(0, 1) + m(1, 0), m(0, 2) + m(2, 0)},
                                {m(0, 2) - m(2, 0), m(0, 1) + m(1, 0), squares[2], m(1, 2) + m(2, 1)},
                                {m(1, 0) - m(0, 1), m(0, 2) + m(2, 0), m(1, 2) + m(2, 1), squares[3]}};
    const auto largest = std::max_element(squares, squares + 4) - squares;
    std::array<float, 4> made{};
    for (std::size_t i = 0; i < 4; ++i)
        made[i] = static_cast<float>(table[largest][i] / (2 * std::sqrt(squares[largest])));
    return made;
}

} // namespace dataset
#endif
