// Calls the templates of image/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_image_grey_map
image call(image picture) { return map_grey(exec::par, std::move(picture), {.gamma = 0.5F}); }
#endif
#ifdef CALL_image_image
bool call(const image& picture) { return picture == image{picture.size, picture(0, 0)}; }
#endif
#ifdef CALL_image_scan_convert
label_image call(const label_lines& labels, const scan_lines& lines, const scan_map& map) {
    if (scan_convert_nearest(exec::par, lines, map).pixels.empty()) return scan_convert(exec::seq, labels, map);
    return scan_convert(exec::seq, labels, pencil{});
}
image call(const scan_lines& lines, kept_scan_map<pencil>& kept) {
    const scan_map& map = kept(exec::par, pencil{}, {.depth = lines.depth, .samples = lines.samples}, {});
    return scan_convert(exec::seq, lines, map, scan_convert(exec::par, lines, pencil{}));
}
#endif
