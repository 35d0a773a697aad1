// Calls the templates of probe/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_probe_line_fan
std::uint32_t call(detail::line_fan& fan) {
    if (!fan.assign(pencil{})) return 0;
    fan.for_each_crossed({-1, 0}, fan.gap({-1, 0}), {1, 0}, fan.gap({1, 0}), [](std::uint32_t, std::uint32_t) {});
    float along[simd_width];
    store(fan.from(0).intersect({-1, 0}, {1, 0}), along);
    return fan.size();
}
#endif
#ifdef CALL_probe_line_grid
bool call(scan_lines& lines, iq_lines& echoes, label_lines& labels) {
    lines.reshape(1, 2, 3);
    return lines == scan_lines{1, 2, 3} && echoes(0, 0).x == lines(0, 1) && labels(0, 0) == background_label;
}
#endif
#ifdef CALL_probe_presets
float call(const linear_array& probe) { return presets::in_use(probe).bandwidth; }
#endif
#ifdef CALL_probe_probe_lines
bool call(const pencil& probe) {
    const detail::probe_lines lines{probe};
    return lines == detail::probe_lines{probe} && lines.settings().spacing(1) > lines.settings().advance();
}
#endif
#ifdef CALL_probe_transducer
bool call(const pencil& probe) { return is_full_circle(probe) && line_at_fraction(aperture_fraction(0, 1), 1) == 0; }
vec2 call(const refined<pencil>& probe) {
    probe.check();
    return probe == refined<pencil>{probe} ? probe.locate({0, probe.beam(0).at(1).z}) : vec2{};
}
vec2 call(const steered<pencil>& probe) {
    probe.check();
    return probe == steered<pencil>{probe} ? probe.locate({0, probe.scatterer_axis(0).z}) : vec2{};
}
#endif
