#include <insonify/insonify.hpp>

// A second file of the program, which leaves the OBJ reader and PNG writer to the first.
insonify::image picture(const insonify::scene& body) {
    using namespace insonify;
    return b_mode(exec::par_unseq, body, linear_array{}, pose{}, {.depth = 45_mm});
}
