#include <insonify/insonify.hpp>

int main() {
    using namespace insonify;
    scene body{tissue::muscle};
    body.add(make_box({-10_mm, -10_mm, 12_mm}, {10_mm, 10_mm, 32_mm}), tissue::bone);
    const image seen = b_mode(exec::par, body.build(exec::par), linear_array{}, pose{}, {.depth = 45_mm});
    return seen.pixels.empty() ? 1 : 0;
}
