#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>

insonify::image picture(const insonify::scene& body);

int main() {
    using namespace insonify;
    scene body{tissue::muscle};
    body.add(make_box({-10_mm, -10_mm, 12_mm}, {10_mm, 10_mm, 32_mm}), tissue::bone);
    body.build(exec::par);
    write_png("consumer.png", picture(body));
}
