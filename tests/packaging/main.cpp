#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>

int main() {
    using namespace insonify;
    scene body{tissue::muscle};
    body.add(make_box({-10_mm, -10_mm, 12_mm}, {10_mm, 10_mm, 32_mm}), tissue::bone);
    body.build(exec::par);
    write_png("consumer.png", b_mode(exec::par_unseq, body, linear_array{}, pose{}, {.depth = 45_mm}));
}
