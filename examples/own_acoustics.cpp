// Your own acoustic model in place of law2011: it computes the samples of a line from its layers. Three
// members suffice.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <cstdio>

/// Shows bone only: its surface, by the angle of incidence, and its shadow.
struct bone_shadow {
    using sample_type = float;
    float hardness = 0.9F;

    std::uint32_t samples(float depth, float) const { return static_cast<std::uint32_t>(depth / 0.0001F); }

    void operator()(const auto& /* policy */, const insonify::traced_line& line, float spacing,
                    insonify::view<float> samples) const {
        float arriving = 0.2F;
        std::size_t k = 0;
        for (const insonify::layer& here : line.layers) {
            const bool bone = line.media[here.medium] == insonify::tissue::bone;
            const float surface_end = here.begin + 0.001F;
            if (bone) arriving *= 1 - hardness;
            for (; k < samples.size() && (static_cast<float>(k) + 0.5F) * spacing < here.end; ++k)
                samples[k] = bone && static_cast<float>(k) * spacing < surface_end
                                 ? hardness * here.cosine * here.cosine
                                 : arriving;
        }
    }
};
static_assert(insonify::acoustic_model<bone_shadow>);

int main() {
    using namespace insonify;
    scene body{tissue::water};
    body.add(make_sphere({0, 0, 40_mm}, 10_mm, 5), tissue::bone);
    body.build(exec::seq);

    const phased_array probe{.lines = 129, .width = 20_mm, .field_of_view = 90_deg, .frequency = 3.5_MHz};
    const scan_lines lines = trace(exec::par, body, probe, pose{}, bone_shadow{.hardness = 0.95F}, {.depth = 80_mm});
    write_png("own_acoustics.png", scan_convert(exec::par, lines, probe, {.size = {512, 0}}));

    // The middle line hits the sphere at normal incidence, at 30 mm, and leaves it at 50 mm.
    const float before = lines(64, 290), surface = lines(64, 302), shadow = lines(64, 600);
    std::printf("before %.3f, on the surface %.3f, in the shadow %.3f\n", before, surface, shadow);
    return std::fabs(before - 0.2F) < 1e-6F && std::fabs(surface - 0.95F) < 0.01F && std::fabs(shadow - 0.01F) < 1e-6F
               ? 0
               : 1;
}
