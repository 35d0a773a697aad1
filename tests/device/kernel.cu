#include <insonify/acoustics/law2011.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/bvh/traverse.hpp>
#include <insonify/geometry/mesh.hpp>
#include <type_traits>

// Compiled, not run: what a device needs of the library is there, and without a warning.
using tree_view = insonify::bvh_view<insonify::mesh_view>;

static_assert(std::is_trivially_copyable_v<tree_view> && std::is_trivially_copyable_v<insonify::traced_line>);

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
