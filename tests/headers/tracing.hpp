// Calls the public templates of tracing/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_tracing_trace
iq_lines call(const scene& body) { return trace(exec::par_unseq, body, pencil{}, pose{}, physical{}, {}); }
iq_lines call_slice(const scene& body) {
    return trace(exec::seq, body, pencil{}, pose{}, physical{}, {}, straight_lines{line_search::slices});
}
#endif
#ifdef CALL_tracing_find_find_layers
line_layers call(const scene& body) {
    return find_layers(exec::par, body, pencil{}, pose{}, {.depth = 0.04F, .planes = 3});
}
#endif
#ifdef CALL_tracing_read_automatic_tgc
float call(const scene& body) { return automatic_tgc(exec::par, body, pencil{}, pose{}, 0.04F); }
#endif
#ifdef CALL_tracing_read_label
label_lines call(const scene& body) { return label(exec::par, body, pencil{}, pose{}, {.depth = 0.04F}); }
#endif
#ifdef CALL_tracing_read_ground_truth
ground_truth_lines call(const scene& body) { return ground_truth(exec::par, body, pencil{}, pose{}, {.depth = 0.04F}); }
#endif
#ifdef CALL_tracing_read_reverberation
iq_lines call(iq_lines echoes, const line_layers& found) {
    return add_reverberation(exec::par, std::move(echoes), found, pencil{}, physical{});
}
#endif
#ifdef CALL_tracing_read_near_field
iq_lines call(iq_lines echoes, const scene& body) {
    return add_near_field(exec::par, std::move(echoes), body, pencil{}, pose{});
}
#endif
#ifdef CALL_tracing_paths
bool call(const line_task& task, line_scratch& scratch, view<vec2> out) {
    return paths{}(exec::seq, task, physical{}, scratch, out);
}
#endif
