#include "frame_steps.hpp"

#include <insonify/insonify.hpp>
#include <cstdio>
#include <cstdlib>
#include <cuda_runtime.h>
#include <limits>
#include <memory>
#include <type_traits>

/// The hot code on a device, beside the same code on the host: the closest hits of rays, frames of both acoustic models and
/// both tracers, and the default frame with its shadows. A machine without a device compiles it, and stops there (exit status 77).
namespace device {
using namespace insonify;

using tree_view = bvh_view<mesh_view>;

static_assert(std::is_trivially_copyable_v<tree_view> && std::is_trivially_copyable_v<traced_line>);
static_assert(std::is_trivially_copyable_v<detail::frame_view> && std::is_trivially_copyable_v<scene_view>);
static_assert(std::is_trivially_copyable_v<line_scratch>);

void check(cudaError_t code) {
    if (code == cudaSuccess) return;
    std::printf("%s\n", cudaGetErrorString(code));
    std::exit(1);
}

__global__ void nearest(tree_view tree, view<const ray> rays, view<hit> hits) {
    const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < rays.size()) hits[i] = tree.any(rays[i]) ? tree.closest(rays[i]) : hit{};
}

// A whole frame by one kernel: each thread traces a line, from crossings to samples, in scratch of its own. Lines that did
// not fit are marked, for the host to trace again.
template <class Tracer, class Model>
__global__ void frame(detail::frame_view plan, scene_view scene, Model model, Tracer how, view<line_scratch> scratch,
                      view<typename Model::sample_type> plane_samples, view<typename Model::sample_type> samples,
                      view<bool> fits) {
    const std::uint32_t line = blockIdx.x * blockDim.x + threadIdx.x;
    if (line >= plan.count()) return;
    const std::size_t first = std::size_t{line} * plan.samples;
    const view<typename Model::sample_type> room{plane_samples.data() + first, plan.samples},
        out{samples.data() + first, plan.samples};
    fits[line] = true;
    detail::sum_planes(
        plan, line, 1, room, [&](std::size_t) { return out; },
        [&](std::uint32_t plane, view<typename Model::sample_type> of_plane) {
            fits[line] = fits[line] && how(exec::sequenced_policy{}, detail::task_of(plan, scene, line, plane), model,
                                           scratch[line], of_plane);
        });
}

// Milliseconds of a launch, the shortest of five.
template <class Launch>
float shortest_time(const Launch& launch) {
    cudaEvent_t begin{}, end{};
    check(cudaEventCreate(&begin));
    check(cudaEventCreate(&end));
    float shortest = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 5; ++i) {
        check(cudaEventRecord(begin));
        launch();
        check(cudaEventRecord(end));
        check(cudaEventSynchronize(end));
        float time = 0;
        check(cudaEventElapsedTime(&time, begin, end));
        shortest = std::min(shortest, time);
    }
    check(cudaGetLastError());
    return shortest;
}

bool same_hits() {
    const mesh ball = make_sphere({0, 0, 0}, 10_mm, 6); // 81,920 faces
    const bvh tree{exec::par, ball};
    std::vector<ray> rays(1 << 20);
    for (std::uint32_t i = 0; i < rays.size(); ++i)
        rays[i] = {
            .origin = 20_mm * (2.0F * vec3{hash_uniform(1, 6 * i), hash_uniform(1, 6 * i + 1), 0} - 1.0F),
            .direction = normalize(
                2.0F * vec3{hash_uniform(2, 3 * i), hash_uniform(2, 3 * i + 1), hash_uniform(2, 3 * i + 2)} - 1.0F)};
    std::vector<hit> hits(rays.size());
    const float time = shortest_time([&] { nearest<<<(rays.size() + 127) / 128, 128>>>(tree.view_of(), rays, hits); });
    std::size_t different = 0, met = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const hit expected = tree.closest(rays[i]);
        met += expected ? 1 : 0;
        if (bool(expected) != bool(hits[i]) || (expected && std::fabs(expected.distance - hits[i].distance) > 1e-7F))
            ++different;
    }
    std::printf("closest hits: %zu of %zu rays differ, of which %zu meet the ball; %.0f million rays/s\n", different,
                rays.size(), met, 1e-3 * static_cast<double>(rays.size()) / static_cast<double>(time));
    return different <= rays.size() / 100'000; // on edges, by rounding
}

float square(float value) { return value * value; }
float square(vec2 value) { return dot(value, value); }

template <class Tracer, class Model>
bool same_frame(const char* title, const scene& body, const Model& model, const Tracer& how, std::uint32_t planes) {
    using sample_type = typename Model::sample_type;
    const linear_array probe{.lines = 256, .width = 40_mm, .frequency = 7.5_MHz};
    const acquisition scan{.depth = 40_mm, .samples = 2048, .planes = planes};
    const auto expected = trace(exec::par, body, probe, pose{}, model, scan, how);
    detail::frame_plan<Model> plan;
    const detail::probe_lines lines{probe};
    const auto view_of_plan = plan.view_of(exec::par, lines, pose{}, model, scan, scan.samples, body.media());
    const scene_view seen = body.view_for_rays(exec::par);
    std::vector<detail::scratch_memory> memory(probe.lines);
    std::vector<line_scratch> scratch;
    for (detail::scratch_memory& of_line : memory) {
        of_line.grow();
        scratch.push_back(of_line.scratch());
    }
    std::vector<sample_type> plane_samples(expected.values.size()), samples(expected.values.size());
    const auto fits = std::make_unique<bool[]>(probe.lines);
    const float time = shortest_time([&] {
        frame<<<(probe.lines + 31) / 32, 32>>>(view_of_plan, seen, model, how, view<line_scratch>{scratch},
                                               view<sample_type>{plane_samples}, view<sample_type>{samples},
                                               view<bool>{fits.get(), probe.lines});
    });
    double difference = 0, power = 1e-300;
    std::uint32_t too_long = 0;
    for (std::uint32_t line = 0; line < probe.lines; ++line) {
        if (!fits[line]) {
            ++too_long;
            continue;
        }
        for (std::uint32_t k = 0; k < scan.samples; ++k) {
            difference += static_cast<double>(square(samples[line * scan.samples + k] - expected(line, k)));
            power += static_cast<double>(square(expected(line, k)));
        }
    }
    const double level = 10 * std::log10(difference / power + 1e-30);
    std::printf("%s, %u plane(s): difference %.0f dB, %u lines do not fit; %.2f ms\n", title, planes, level, too_long,
                static_cast<double>(time));
    return level < -85 && too_long == 0;
}

// One step of a default frame, for all of its indices.
template <class Steps>
__global__ void run_step(Steps all, frame_step one) {
    const std::size_t i = std::size_t{blockIdx.x} * blockDim.x + threadIdx.x;
    if (i < all.count(one)) all.run(one, i);
}

bool same_default_frame(const scene& body, std::uint32_t planes) {
    using steps = frame_steps<physical<>>;
    static_assert(std::is_trivially_copyable_v<steps>);
    const linear_array probe{.lines = 256, .width = 40_mm, .frequency = 7.5_MHz};
    const acquisition scan{.depth = 40_mm, .samples = 2048, .planes = planes};
    const iq_lines expected =
        trace(exec::par, body, probe, pose{}, physical{}, scan, straight_lines{.search = line_search::rays});
    frame_memory<physical<>> memory;
    const steps all = memory.prepare(body, probe, physical{}, scan);
    const float time = shortest_time([&] {
        for (const frame_step one : all_frame_steps)
            run_step<<<static_cast<unsigned>((all.count(one) + 63) / 64), 64>>>(all, one);
    });
    std::size_t too_small = 0;
    for (const std::uint32_t one : all.too_small) too_small += one;
    double difference = 0, power = 1e-300;
    for (std::size_t i = 0; i < expected.values.size(); ++i) {
        difference += static_cast<double>(square(all.samples[i] - expected.values[i]));
        power += static_cast<double>(square(expected.values[i]));
    }
    const double level = 10 * std::log10(difference / power + 1e-30);
    std::printf("default frame, %u plane(s): difference %.0f dB, %zu lines do not fit; %.2f ms\n", planes, level,
                too_small, static_cast<double>(time));
    return level < -85 && too_small == 0;
}

int run() {
    int count = 0;
    if (cudaGetDeviceCount(&count) != cudaSuccess || count == 0) {
        std::puts("no device");
        return 77;
    }
    scene body{tissue::muscle};
    body.add(make_box({-30_mm, -20_mm, -1_mm}, {30_mm, 20_mm, 6_mm}, 2), tissue::fat);
    body.add(make_cylinder({-8_mm, -20_mm, 17_mm}, {-8_mm, 20_mm, 17_mm}, 4_mm, 64, 8), tissue::blood);
    body.add(make_cylinder({8_mm, -20_mm, 14_mm}, {8_mm, 20_mm, 16_mm}, 3_mm, 64, 8), tissue::nerve);
    body.add(make_sphere({5_mm, 0, 34_mm}, 9_mm, 5), tissue::bone);
    body.build(exec::par);
    const straight_lines by_rays{.search = line_search::rays, .directions = 1};
    bool same = same_hits();
    same = same_frame("law2011", body, law2011{}, by_rays, 1) && same;
    for (const std::uint32_t planes : {1U, 5U}) {
        same = same_frame("physical, straight lines", body, physical{}, by_rays, planes) && same;
        same = same_frame("physical, paths", body, physical{}, paths{}, planes) && same;
        same = same_default_frame(body, planes) && same;
    }
    return same ? 0 : 1;
}

} // namespace device

int main() { return device::run(); }
