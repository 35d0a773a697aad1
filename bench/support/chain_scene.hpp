#ifndef INSONIFY_BENCH_SUPPORT_CHAIN_SCENE_HPP
#define INSONIFY_BENCH_SUPPORT_CHAIN_SCENE_HPP

#include <insonify/insonify.hpp>
#include "meshes.hpp"

/// The frame that the whole chain is measured on: an organ of 20,480 triangles in fat, 256 lines of 4096 samples to
/// 120 mm, a picture of 500 x 500.
namespace bench::chain {

using namespace insonify;

inline constexpr convex_array probe{.lines = 256, .frequency = 5_MHz};
inline constexpr acquisition scan{.depth = 120_mm, .samples = 4096};
inline constexpr scan_convert_settings picture{.size = {500, 500}};
inline const pose at{.translation = {0, 0, -60_mm}};

inline scene organ() {
    scene body{tissue::fat};
    body.add(make_organ(5), tissue::liver);
    return std::move(body).build(exec::par);
}

/// All stages, each in the memory of the frame before.
struct frame {
    line_tracer<> tracing{};
    convolver convolution{};
    kept_scan_map<convex_array> map{};
    iq_lines echoes{};
    scan_lines lines{};
    image seen{};

    template <class Policy>
    void trace_echoes(const Policy& policy, const scene& body) {
        echoes = tracing.trace(policy, body, probe, at, physical<>{}, scan, {}, std::move(echoes));
    }
    template <class Policy>
    void spread(const Policy& policy) {
        echoes = convolution.convolve(policy, std::move(echoes), pulse{}, probe);
    }
    template <class Policy>
    void detect(const Policy& policy) {
        lines = envelope(policy, echoes, std::move(lines));
    }
    template <class Policy>
    void compensate(const Policy& policy) {
        lines = tgc(policy, std::move(lines), probe.frequency);
    }
    template <class Policy>
    void compress(const Policy& policy) {
        lines = log_compress(policy, std::move(lines));
    }
    template <class Policy>
    void convert(const Policy& policy) {
        seen = scan_convert(policy, lines, map(policy, probe, scan, picture), std::move(seen));
    }
    template <class Policy>
    void draw(const Policy& policy, const scene& body) {
        trace_echoes(policy, body);
        spread(policy);
        detect(policy);
        compensate(policy);
        compress(policy);
        convert(policy);
    }
};

} // namespace bench::chain
#endif
