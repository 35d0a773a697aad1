// Calls the templates of doppler/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_doppler_slow_time
flow_sample call(const iq_ensemble& echoes) {
    const iq_ensemble moving = filter_walls(exec::par_unseq, echoes, {});
    return flow_of(autocorrelate(exec::par, filter_walls(exec::seq, moving, {.type = wall_filter::kind::fir}))(0, 0),
                   1);
}
#endif
#ifdef CALL_doppler_pulsed_doppler
doppler_spectrum call(const std::vector<vec2>& echoes) { return spectrum_of(exec::par, echoes, 4e3F, 1, 0, {}); }
#endif
#ifdef CALL_doppler_colour_doppler
colour_image call(const flow_lines& lines) {
    return colour_overlay(exec::par, doppler_picture(exec::seq, lines, pencil{}), lines, pencil{});
}
#endif
