// A tracer of one's own: sound through a volume of labelled voxels, as a segmented CT gives it, without any mesh. `trace`
// and `b_mode` take it in place of straight lines through surfaces; everything after it stays as it is.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <cmath>
#include <cstdio>

using namespace insonify;

// Voxels with a label each; label i stands for media[i].
struct label_volume {
    uvec3 size{};
    float voxel = 0; // edge, metres
    vec3 corner{};   // of the first voxel, in the world
    std::vector<std::uint8_t> labels{};
    std::vector<medium> media{};
};

// Marches each line through the voxels: where the label changes, a layer ends.
struct voxel_tracer {
    view<const std::uint8_t> labels{};
    view<const medium> media{};
    uvec3 size{};
    float voxel = 0;
    vec3 corner{};

    explicit voxel_tracer(const label_volume& v)
        : labels{v.labels}, media{v.media}, size{v.size}, voxel{v.voxel}, corner{v.corner} {}

    // The label at a point in voxels; 0 outside.
    INSONIFY_FN std::uint8_t at(vec3 p) const {
        if (!(p.x >= 0 && p.y >= 0 && p.z >= 0)) return 0;
        const uvec3 i{p};
        if (i.x >= size.x || i.y >= size.y || i.z >= size.z) return 0;
        return labels[(std::size_t{i.z} * size.y + i.y) * size.x + i.x];
    }

    // How much of the surroundings of a point has a label, and where it lies: smoothed, so that the surface between two
    // labels has no steps.
    struct surroundings {
        float fraction = 0;
        vec3 towards{0, 0, 0};
    };
    INSONIFY_FN surroundings around(vec3 p, std::uint8_t label) const {
        surroundings found;
        float all = 0;
        for (int x = -4; x <= 4; ++x)
            for (int y = -4; y <= 4; ++y)
                for (int z = -4; z <= 4; ++z) {
                    const vec3 apart = glm::floor(p) + vec3{x, y, z} + 0.5F - p;
                    const float weight = std::exp(-dot(apart, apart) / (2 * 1.5F * 1.5F)); // 1.5 voxels
                    all += weight;
                    if (at(p + apart) != label) continue;
                    found.fraction += weight;
                    found.towards += weight * apart;
                }
        found.fraction /= all;
        return found;
    }

    template <class Policy, acoustic_model Model>
    INSONIFY_FN bool operator()(const Policy& policy, line_task task, const Model& model, line_scratch& scratch,
                                view<typename Model::sample_type> out) const {
        const line_frame& frame = task.line.frame;
        const vec3 start = (frame.origin - corner) / voxel, path = frame.path(); // which may tilt in elevation
        task.line.media = media;                                                 // instead of the scene's
        std::size_t count = 0;
        layer here{.medium = at(start)};
        const float step = 0.25F; // voxels
        for (float depth = step; depth * voxel < task.max_depth; depth += step) {
            const std::uint8_t label = at(start + depth * path);
            if (label == here.medium) continue;
            float above = depth - 3, below = depth + 3; // the surface is where half of the surroundings has the label
            for (int i = 0; i < 10; ++i) {
                const float middle = 0.5F * (above + below);
                (around(start + middle * path, label).fraction < 0.5F ? above : below) = middle;
            }
            if (count + 2 > scratch.layers.size()) return false;
            here.end = max(here.begin, below * voxel);
            scratch.layers[count++] = here;
            const vec3 towards = around(start + below * path, label).towards;
            const vec3 normal = length(towards) > 0 ? -normalize(towards) : -frame.along;
            const float facing = max(std::fabs(dot(normal, frame.along)), 1e-4F);
            const vec3 lateral = cross(frame.elevation, frame.along);
            here = {.begin = here.end,
                    .medium = label,
                    .object = label,
                    .cosine = min(facing, 1.0F),
                    .slope = {dot(normal, lateral) / facing, dot(normal, frame.elevation) / facing}};
        }
        if (count == scratch.layers.size()) return false;
        here.end = task.max_depth;
        scratch.layers[count++] = here;
        task.apply(policy, model, {scratch.layers.data(), count}, out);
        return true;
    }
};
static_assert(tracer<voxel_tracer>);

// A forearm in voxels of 0.25 mm: skin, fat, muscle, an artery, and bone.
static label_volume forearm() {
    label_volume v{.size = {200, 80, 180}, .voxel = 0.25_mm, .corner = {-25_mm, -10_mm, 0}};
    v.media = {tissue::gel, tissue::skin, tissue::fat, tissue::muscle, tissue::blood, tissue::bone};
    v.labels.resize(std::size_t{v.size.x} * v.size.y * v.size.z);
    std::size_t i = 0;
    for (std::uint32_t z = 0; z < v.size.z; ++z)
        for (std::uint32_t y = 0; y < v.size.y; ++y)
            for (std::uint32_t x = 0; x < v.size.x; ++x, ++i) {
                const vec3 p = v.corner + v.voxel * (vec3{x, y, z} + 0.5F);
                const float under_skin = p.z - 0.02F * p.x * p.x / 25_mm;
                const float artery = length(vec2{p.x - 6_mm - 0.3F * p.y, p.z - 15_mm});
                const float radius = length(vec2{p.x + 7_mm, p.z - 28_mm});
                v.labels[i] = under_skin < 1_mm     ? 0
                              : under_skin < 2.4_mm ? 1
                              : under_skin < 6_mm   ? 2
                              : artery < 2.2_mm     ? 4
                              : radius < 6_mm       ? 5
                                                    : 3;
            }
    return v;
}

int main() {
    const label_volume arm = forearm();
    const scene nothing = scene{tissue::gel}.build(exec::par);
    const linear_array probe{.lines = 192, .width = 38_mm, .frequency = 7.5_MHz};
    const pose at = look_at({0, 0, 0}, {0, 0, 1}, {1, 0, 0}); // from, towards, lateral
    const b_mode_settings settings{.depth = 40_mm, .size = {512, 0}};
    write_png("own_tracer.png", b_mode(exec::par_unseq, nothing, probe, at, physical{}, settings, voxel_tracer{arm}));

    // A ball of voxels against a mesh of the same ball: the same depths along every line.
    label_volume ball{.size = {160, 160, 160}, .voxel = 0.25_mm, .corner = {-20_mm, -20_mm, 0}};
    ball.media = {tissue::muscle, tissue::liver};
    for (std::uint32_t i = 0; i < 160 * 160 * 160; ++i) {
        const vec3 p = ball.corner + ball.voxel * (vec3{i % 160, i / 160 % 160, i / 25600} + 0.5F);
        ball.labels.push_back(length(p - vec3{0, 0, 20_mm}) < 10_mm ? 1 : 0);
    }
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 20_mm}, 10_mm, 5), tissue::liver);
    body.build(exec::par);
    const acquisition scan{.depth = 35_mm, .samples = 3500};
    const law2011 law{.reflection_length = 20_um};
    const scan_lines voxels = trace(exec::par, nothing, probe, at, law, scan, voxel_tracer{ball});
    const scan_lines mesh = trace(exec::par, body, probe, at, law, scan);
    int apart = 0;
    for (std::uint32_t line = 60; line < 132; ++line) {
        const auto first_echo = [&](const scan_lines& lines) {
            std::uint32_t k = 1;
            while (k + 1 < lines.samples && lines(line, k) <= lines(line, k - 1)) ++k;
            return static_cast<int>(k);
        };
        apart = std::max(apart, std::abs(first_echo(voxels) - first_echo(mesh)));
    }
    std::printf("the ball's surface in voxels and as a mesh: at most %.2f mm apart\n", 0.01 * apart);
    return apart <= 30 ? 0 : 1; // a voxel, and the facets of the mesh
}
