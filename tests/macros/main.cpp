// Everything, after the macros of others: it compiles, draws a picture, and leaves the macros as they were.
#include "macros_of_others.hpp"
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>

#if !defined(near) || !defined(far) || !defined(small) || !defined(emit) || !defined(slots)
#error "a macro is lost"
#endif

namespace {

int not_of_unreal(int value) { return value + 1; }
[[maybe_unused]] int not_of_windows(int r, int g, int b) { return r | g << 8 | b << 16; }

} // namespace

bool works_before_windows_h(); // in windows.cpp

int main() {
    using namespace insonify;
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 20_mm}, 5_mm, 3), tissue::blood);
    body.build(exec::par);
    const linear_array probe{.lines = 32, .width = 30_mm};
    (probe.check)(); // in parentheses, as no function-like macro is expanded there
    const image picture = b_mode(exec::par_unseq, body, probe, pose{}, {.depth = 40_mm, .size = {64, 64}});
#if defined(_WIN32)
    if (!works_before_windows_h()) return 1;
#endif
    return picture.pixels.size() == 4096 && check(1) == 2 && RGB(1, 2, 3) == 0x030201 ? 0 : 1;
}
