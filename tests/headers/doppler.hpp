// Calls the templates of doppler/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_doppler_slow_time
iq_ensemble call(const iq_ensemble& echoes) {
    return filter_walls(exec::seq, filter_walls(exec::par_unseq, echoes, {}), {.type = wall_filter::kind::fir});
}
#endif
#ifdef CALL_doppler_autocorrelation
flow_sample call(const iq_ensemble& echoes) { return flow_of(autocorrelate(exec::par, echoes)(0, 0), 1.0F); }
#endif
#ifdef CALL_doppler_doppler_spectrum
doppler_spectrum call(const std::vector<vec2>& echoes) { return spectrum_of(exec::par, echoes, 4e3F, 1, 0, {}); }
#endif
#ifdef CALL_doppler_doppler_picture
colour_image call(const flow_lines& lines) {
    return colour_overlay(exec::par, doppler_picture(exec::seq, lines, pencil{}), lines, pencil{});
}
#endif
