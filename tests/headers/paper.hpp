// Calls the templates of paper/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_paper_pixels
scan_lines call(const scene& body) { return trace_pixels(exec::par, body, pencil{}, pose{}, law2011{}, {}); }
#endif
#ifdef CALL_paper_picture
image call(const image& picture, const scan_map& map) { return radial_blur(exec::par, picture, pencil{}, map); }
image call(image picture) {
    const image noise = make_noise(exec::par, picture.size);
    return add_noise(exec::par, std::move(picture), noise);
}
const image& call(progressive& mean, const image& frame) { return mean.add(exec::par, frame, pose{}); }
#endif
