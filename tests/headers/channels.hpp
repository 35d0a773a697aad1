// Calls the templates of channels/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_channels_element_array
bool call() { return element_transducer<convex_element_array> && presets::l11_5v_elements.elements == 128; }
#endif
#ifdef CALL_channels_transmit
std::vector<transmit> call(const element_array& array) { return plane_waves(array, 3, 0.1F); }
#endif
#ifdef CALL_channels_channel_data
iq_channel_data call(const channel_data& received) { return demodulate(exec::par, received); }
#endif
#ifdef CALL_channels_beamform
iq_lines call(const channel_data& received) { return beamform(exec::par, received, pencil{}, {.depth = 0.04F}); }
#endif
#ifdef CALL_channels_tissue_maps
tissue_maps call(const scene& body) { return map_tissue(exec::par, body, pose{}, {}); }
#endif
#ifdef CALL_channels_trace_channels
channel_data call(const scene& body, const element_array& array) {
    return trace_channels(exec::par, body, array, pose{}, physical{}, plane_waves(array, 3, 0.1F), {.depth = 0.04F});
}
#endif
