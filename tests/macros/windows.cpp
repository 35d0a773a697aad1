// On Windows: windows.h after the library, and a header that needs the macros of windows.h.
#include <insonify/insonify.hpp>
#include <windows.h>

#include <shlobj.h>

bool works_before_windows_h();

bool works_before_windows_h() {
    using namespace insonify;
    const linear_array probe{.lines = 32, .width = 30_mm};
    probe.check();
    const RECT shown{0, 0, 64, 48};
    return validate(make_sphere({0, 0, 20_mm}, 5_mm, 3)).closed() && max(vec3{0, 0, 0}, vec3{1, 1, 1}).x == 1 &&
           image{{static_cast<std::uint32_t>(shown.right), static_cast<std::uint32_t>(shown.bottom)}}.pixels.size() ==
               3072;
}
