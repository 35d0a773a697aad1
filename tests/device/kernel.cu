#include <insonify/acoustics/law2011.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/bvh/traverse.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/straight_lines.hpp>
#include <insonify/tracing/trace_line.hpp>
#include <type_traits>

// Compiled, not run: what a device needs of the library is there, and without a warning.
using tree_view = insonify::bvh_view<insonify::mesh_view>;

using linear_frame = insonify::frame_view<insonify::linear_array>;

static_assert(std::is_trivially_copyable_v<tree_view> && std::is_trivially_copyable_v<insonify::traced_line>);
static_assert(std::is_trivially_copyable_v<linear_frame> && std::is_trivially_copyable_v<insonify::scene_view>);
static_assert(std::is_trivially_copyable_v<insonify::line_scratch>);

__global__ void nearest(tree_view tree, insonify::view<const insonify::ray> rays, insonify::view<insonify::hit> hits) {
    const unsigned int i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= rays.size()) return;
    hits[i] = tree.any(rays[i]) ? tree.closest(rays[i]) : insonify::hit{};
    tree.for_each_hit(rays[i], [&](const insonify::hit& found) { hits[i].distance += found.distance; });
}

__global__ void intensities(insonify::law2011 law, insonify::traced_line line, float spacing,
                            insonify::view<float> samples) {
    law(insonify::exec::sequenced_policy{}, line, spacing, samples);
    samples[0] = law.at(line, spacing / 2);
}

__global__ void echoes(insonify::physical<> model, insonify::traced_line line, float spacing,
                       insonify::view<insonify::vec2> samples) {
    model(insonify::exec::sequenced_policy{}, line, spacing, samples);
}

// A whole frame by one kernel: each thread traces a line, from crossings to samples, in scratch of its own. Lines that did
// not fit are marked, for the host to trace again.
__global__ void frame(linear_frame plan, insonify::scene_view scene, insonify::physical<> model,
                      insonify::view<insonify::line_scratch> scratch, insonify::view<insonify::vec2> plane_samples,
                      insonify::view<insonify::vec2> samples, insonify::view<bool> fits) {
    const unsigned int line = blockIdx.x * blockDim.x + threadIdx.x;
    if (line >= plan.probe.lines) return;
    const std::size_t first = std::size_t{line} * plan.samples;
    fits[line] = insonify::detail::trace_line(
        insonify::exec::sequenced_policy{}, plan, scene, insonify::straight_lines{}, model, line, scratch[line],
        {plane_samples.data() + first, plan.samples}, {samples.data() + first, plan.samples});
}

// The same by paths.
__global__ void bent_frame(linear_frame plan, insonify::scene_view scene, insonify::physical<> model,
                           insonify::paths how, insonify::view<insonify::line_scratch> scratch,
                           insonify::view<insonify::vec2> plane_samples, insonify::view<insonify::vec2> samples,
                           insonify::view<bool> fits) {
    const unsigned int line = blockIdx.x * blockDim.x + threadIdx.x;
    if (line >= plan.probe.lines) return;
    const std::size_t first = std::size_t{line} * plan.samples;
    fits[line] = insonify::detail::trace_line(insonify::exec::sequenced_policy{}, plan, scene, how, model, line,
                                              scratch[line], {plane_samples.data() + first, plan.samples},
                                              {samples.data() + first, plan.samples});
}
