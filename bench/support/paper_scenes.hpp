#ifndef INSONIFY_BENCH_SUPPORT_PAPER_SCENES_HPP
#define INSONIFY_BENCH_SUPPORT_PAPER_SCENES_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/trace.hpp>
#include <vector>

/// The scenes of the paper's performance tests: cubes of bone in muscle, seen in a frame of 512 x 384 pixels of 0.1 mm.
namespace bench::paper {

using namespace insonify;

inline constexpr linear_array probe{.lines = 512, .width = 51.2_mm, .frequency = 5_MHz};
inline constexpr acquisition frame{.depth = 38.4_mm, .samples = 384};
inline constexpr law2011 model{};
/// A little out of the middle of the cubes, so that no frame runs along a row of their vertices.
inline const pose at{.translation = {0.013_mm, 0.017_mm, 0}};

/// The paper's camera: over the slice, a pixel for each sample of each line.
inline orthographic_camera over_the_slice() {
    return {.at = look_at(at.point({0, 100_mm, frame.depth / 2}), at.point({0, 0, frame.depth / 2}), {1, 0, 0}),
            .extent = {probe.width, frame.depth},
            .size = {probe.lines, frame.samples}};
}

/// Tests 1 and 2: one cube of 12 * 4^subdivisions triangles in the middle of the picture.
inline std::vector<mesh> one_cube(std::uint32_t subdivisions) {
    return {make_box({-10_mm, -10_mm, 9.2137_mm}, {10_mm, 10_mm, 29.2137_mm}, subdivisions)};
}

/// Test 3: cubes behind one another, as one object.
inline std::vector<mesh> behind_one_another(std::uint32_t count) {
    mesh all;
    const float pitch = 36_mm / static_cast<float>(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const float begin = 1.2137_mm + static_cast<float>(i) * pitch; // between two rows of pixels
        const mesh one = make_box({-20_mm, -20_mm, begin}, {20_mm, 20_mm, begin + 0.5F * pitch});
        const auto first = static_cast<std::uint32_t>(all.positions.size());
        all.positions.insert(all.positions.end(), one.positions.begin(), one.positions.end());
        for (const uvec3& face : one.faces) all.faces.push_back(face + first);
    }
    return {all};
}

/// Test 4: cubes beside one another, each an object of its own; a line meets at most one.
inline std::vector<mesh> beside_one_another(std::uint32_t count) {
    std::vector<mesh> all;
    const float pitch = 50_mm / static_cast<float>(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const float begin = -25_mm + static_cast<float>(i) * pitch;
        all.push_back(make_box({begin, -10_mm, 9.2137_mm}, {begin + 0.7F * pitch, 10_mm, 29.2137_mm}));
    }
    return all;
}

inline scene scene_of(const std::vector<mesh>& objects) {
    scene body{tissue::muscle};
    for (const mesh& one : objects) body.add(one, tissue::bone);
    body.build(exec::par);
    return body;
}

/// Finds all crossings and does nothing with them: the tests without intensities.
struct crossings_only {
    using sample_type = float;
    static constexpr bool normal_incidence = true;
    std::uint32_t samples(float, float) const { return frame.samples; }
    void operator()(const auto&, const traced_line&, float, view<float>) const {}
};

inline constexpr straight_lines best{}, rays{line_search::rays}, slices{line_search::slices};

/// Frames one after the other, each in the memory of the one before.
template <class Model = law2011>
struct frames {
    line_tracer<Model> own{};
    scan_lines lines{};

    void operator()(straight_lines how, const scene& body) {
        lines = own.trace(exec::par_unseq, body, probe, at, Model{}, frame, how, std::move(lines));
    }
};

/// Every vertex somewhere else than in the frame before, and still a cube.
inline void deform(std::span<vec3> positions, const std::vector<vec3>& rest, std::uint32_t frame_number) {
    const float phase = 0.1F * static_cast<float>(frame_number);
    for (std::size_t i = 0; i < rest.size(); ++i)
        positions[i] = rest[i] + vec3{0.5_mm * std::sin(phase + 100 * rest[i].z), 0, 0.3_mm * std::cos(phase)};
}

} // namespace bench::paper
#endif
