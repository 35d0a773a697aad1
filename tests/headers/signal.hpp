// Calls the templates of signal/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_signal_kernel_convolve
void call(detail::axial_kernel& kernel, vec2* line) {
    kernel.lay_out(line, line);
    kernel.apply<1>(line, line);
}
iq_lines call(iq_lines echoes, convolver& own) {
    echoes = convolve(exec::seq, std::move(echoes), pulse{}, pencil{});
    return own.convolve(exec::par_unseq, std::move(echoes), pulse{}, pencil{}, {.decimation = 2});
}
void call(detail::lateral_slab& slab, vec2* lines) {
    slab.weigh(0, 1);
    slab.copy(lines, 1, 1);
    slab.apply<1>(lines, 1, 1);
}
void call(const detail::tap& one, vec2* samples) { detail::sum_taps<1>({&one, 1}, samples, samples, 1); }
#endif
#ifdef CALL_signal_kernel_kernel_table
float call() {
    const detail::lateral_kernel kernel = detail::make_lateral_kernel(pencil{}, {.depth = 40_mm, .samples = 64});
    std::vector<float> amplitudes;
    const std::vector<float> covariance{1.0F};
    return detail::weights_at(kernel, 0).power<1>(
        0, view<const float>{covariance}, [](std::uint32_t) { return 1.0F; }, amplitudes);
}
#endif
#ifdef CALL_signal_fourier
void call(const detail::fourier& transform, std::vector<detail::complex_block>& values) {
    auto room = values;
    transform.forward(values, room);
    transform.inverse(values, room);
}
void call(const std::vector<float>& signals, std::vector<vec2>& to) {
    detail::for_each_analytic(exec::par_unseq, signals, 64,
                              [&](std::size_t, std::size_t k, vec2 value) { to[k] = value; });
}
#endif
#ifdef CALL_signal_compound
scan_lines call(compounding<pencil>& looks) {
    looks.reset();
    return looks(exec::seq, pencil{}, {.samples = 64}, {.angles = 3},
                 [](std::uint32_t, const steered<pencil>& look, const acquisition& scan, scan_lines) {
                     return scan_lines{look.lines, scan.samples, scan.depth};
                 });
}
#endif
#ifdef CALL_signal_electronic_noise
iq_lines call(iq_lines lines) { return add_electronic_noise(exec::par, std::move(lines)); }
#endif
#ifdef CALL_signal_envelope
scan_lines call(const iq_lines& lines, const scan_lines& rf) {
    return lines.count > 0 ? envelope(exec::par_unseq, lines) : envelope(exec::seq, rf);
}
scan_lines call(const iq_lines& lines) { return to_rf(exec::par, lines, 5e6F); }
#endif
#ifdef CALL_signal_gain
scan_lines call(scan_lines lines, iq_lines echoes) {
    echoes = tgc(exec::seq, std::move(echoes), 5e6F);
    return log_compress(exec::par_unseq, tgc(exec::par, std::move(lines), 5e6F));
}
#endif
#ifdef CALL_signal_persistence
const scan_lines& call(persistence& fading, scan_lines frame) {
    fading.reset();
    fading.add(exec::seq, frame, pose{});
    return fading.add(exec::par_unseq, std::move(frame), pose{});
}
#endif
#ifdef CALL_signal_pulse
pulse_envelope call() { return nominal_pulse(pencil{}).envelope(5e6F); }
float call(int) { return beam_of(pencil{}, 40_mm).lateral_sigma(20_mm) + line_spacing(pencil{}, 20_mm); }
#endif
#ifdef CALL_signal_resample_lines
iq_lines call(const iq_lines& lines) { return resample_lines(exec::par, lines, pencil{}, pencil{}); }
#endif
