// Calls the templates of io/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_io_obj
void call(const scene& body) { write_debug_obj("a.obj", body, pencil{}, pose{}, 0.04F); }
#endif
