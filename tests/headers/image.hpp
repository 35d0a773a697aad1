// Calls the templates of image/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_image_blur
image call(const image& picture, const scan_map& map) { return radial_blur(exec::par, picture, pencil{}, map); }
#endif
#ifdef CALL_image_grey_map
image call(image picture) { return map_grey(exec::par, std::move(picture), {.gamma = 0.5F}); }
#endif
#ifdef CALL_image_label_image
label_image call(const label_lines& labels, const scan_lines& lines, const scan_map& map) {
    if (scan_convert_nearest(exec::par, lines, map).pixels.empty()) return scan_convert(exec::seq, labels, map);
    return scan_convert(exec::seq, labels, pencil{});
}
#endif
#ifdef CALL_image_noise
image call(image picture) {
    const image noise = make_noise(exec::par, picture.size);
    return add_noise(exec::par, std::move(picture), noise);
}
#endif
#ifdef CALL_image_progressive
const image& call(progressive& mean, const image& frame) { return mean.add(exec::par, frame, pose{}); }
#endif
#ifdef CALL_image_scan_convert
image call(const scan_lines& lines, kept_scan_map<pencil>& kept) {
    const scan_map& map = kept(exec::par, pencil{}, {.depth = lines.depth, .samples = lines.samples}, {});
    return scan_convert(exec::seq, lines, map, scan_convert(exec::par, lines, pencil{}));
}
#endif
#ifdef CALL_image_doppler_picture
colour_image call(const flow_lines& lines) {
    return colour_overlay(exec::par, doppler_picture(exec::seq, lines, pencil{}), lines, pencil{});
}
#endif
