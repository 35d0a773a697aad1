// Calls the templates of motion/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_motion_press
contact call(const scene& body) { return press(body, pencil{}, pose{}); }
composed<vec3 (*)(vec3), vec3 (*)(vec3)> call(vec3 (*first)(vec3), vec3 (*then)(vec3)) { return compose(first, then); }
#endif
