// An artery that pulsates beside a vein, by colour, power and pulsed Doppler: six frames of one heart beat.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

using namespace insonify;

namespace {

constexpr float heart_rate = 1.2_Hz, artery_radius = 3_mm, vein_radius = 3.6_mm;
constexpr std::uint32_t frames = 6;

/// A tube along an axis whose radius follows the pulse.
class vessel {
  public:
    vessel(scene& body, vec3 from, vec3 to, float radius, const char* name)
        : from_{from}, along_{normalize(to - from)}, id_{body.add(make_cylinder(from, to, radius, 64), tissue::blood,
                                                                  {.name = name})},
          at_rest_{body.positions(id_).begin(), body.positions(id_).end()} {}

    object_id id() const { return id_; }
    /// @param factor  on the radius
    void dilate(scene& body, float factor) const {
        const std::span<vec3> now = body.positions(id_);
        for (std::size_t i = 0; i < now.size(); ++i) {
            const vec3 on_axis = from_ + dot(at_rest_[i] - from_, along_) * along_;
            now[i] = on_axis + factor * (at_rest_[i] - on_axis);
        }
    }

  private:
    vec3 from_, along_;
    object_id id_;
    std::vector<vec3> at_rest_;
};

/// Fraction of the lumen that is coloured, and the mean velocity there, m/s.
struct filling {
    float coloured = 0, velocity = 0;
};
filling filling_of(const image& velocities, const scan_map& map, vec3 from, vec3 to, float radius) {
    const vec3 along = normalize(to - from);
    float inside = 0;
    filling found;
    for (std::uint32_t y = 0; y < map.size.y; ++y)
        for (std::uint32_t x = 0; x < map.size.x; ++x) {
            const vec2 point = map.point(x, y);
            const vec3 from_axis = vec3{point.x, 0, point.y} - from;
            if (length(from_axis - dot(from_axis, along) * along) > 0.8F * radius || std::fabs(point.x) > 8_mm)
                continue;
            ++inside;
            found.coloured += velocities(x, y) != 0 ? 1.0F : 0.0F;
            found.velocity += velocities(x, y);
        }
    found.velocity /= std::max(found.coloured, 1.0F);
    found.coloured /= inside;
    return found;
}

/// Copies a picture into a strip.
void paste(colour_image& strip, const colour_image& picture, uvec2 at) {
    for (std::uint32_t y = 0; y < picture.size.y; ++y)
        for (std::uint32_t x = 0; x < picture.size.x; ++x) strip(at.x + x, at.y + y) = picture(x, y);
}

/// A spectrum against time, in grey over 40 dB; fast flow towards the probe is at the top.
colour_image picture_of(const doppler_spectrum& spectrum) {
    float strongest = 0;
    for (const float power : spectrum.power) strongest = std::max(strongest, power);
    colour_image picture{{spectrum.windows, spectrum.bins}};
    for (std::uint32_t x = 0; x < spectrum.windows; ++x)
        for (std::uint32_t y = 0; y < spectrum.bins; ++y) {
            const float power = spectrum(x, spectrum.bins - 1 - y);
            picture(x, y) = vec3{clamp(1 + 10 * std::log10(power / strongest + 1e-9F) / 40, 0, 1)};
        }
    return picture;
}

} // namespace

int main() {
    medium muscle = tissue::muscle;
    muscle.structure = {};
    scene body{muscle};
    const vec3 artery_from{-40_mm, 0, 0_mm}, artery_to{40_mm, 0, 28_mm}, // down to the right: away from the probe
        vein_from{40_mm, 0, 38_mm}, vein_to{-40_mm, 0, 10_mm};           // back, deeper
    const vessel artery{body, artery_from, artery_to, artery_radius, "artery"},
        vein{body, vein_from, vein_to, vein_radius, "vein"};
    body.build(exec::par);

    const pulsatile beat{.heart_rate = heart_rate, .resistive_index = 0.85F};
    const poiseuille in_artery{.object = artery.id(),
                               .from = artery_from,
                               .to = artery_to,
                               .radius = artery_radius,
                               .peak_velocity = 0.7_m_per_s,
                               .waveform = beat},
        in_vein{.object = vein.id(),
                .from = vein_from,
                .to = vein_to,
                .radius = vein_radius,
                .peak_velocity = 0.25_m_per_s};
    const auto flow = [&](object_id object, vec3 point, float time) {
        return object == artery.id() ? in_artery(object, point, time) : in_vein(object, point, time);
    };

    const linear_array probe{.lines = 128, .width = 38_mm, .frequency = 6_MHz, .focus = 18_mm};
    b_mode_settings grey = presets::settings_for(probe);
    grey.depth = 36_mm;
    grey.size = {190, 0};
    doppler_settings colour{.prf = 5_kHz, .ensemble = 10, .wall = {.order = 1}};
    const scan_map map = make_scan_map(exec::par, probe, {.depth = grey.depth}, {.size = grey.size});
    colour_image strip{{frames * (map.size.x + 6), 2 * (map.size.y + 6)}};
    scanner<linear_array> machine{probe};
    float fullest = 0, emptiest = 1, fastest = 0, slowest = 10, vein_filling = 0;
    for (std::uint32_t frame = 0; frame < frames; ++frame) {
        const float time = (static_cast<float>(frame) + 0.2F) / (frames * heart_rate);
        artery.dilate(body, 1 + 0.06F * (beat(time) - beat.mean()));
        body.update(exec::par);
        grey.frame = frame;
        colour.time = time;
        machine.settings = grey;
        const image tissue_picture = machine.scan(exec::par_unseq, body, pose{});
        const flow_lines seen = machine.colour(exec::par_unseq, body, flow, colour);
        const colour_image shown = colour_overlay(exec::par, tissue_picture, seen, probe,
                                                  {.max_velocity = 0.2_m_per_s, .min_velocity = 0.03_m_per_s});
        write_png("colour_doppler_" + std::to_string(frame) + ".png", shown);
        paste(strip, shown, {frame * (map.size.x + 6), 0});
        paste(strip,
              colour_overlay(exec::par, tissue_picture, seen, probe,
                             {.map = doppler_map::power, .min_velocity = 0.03_m_per_s}),
              {frame * (map.size.x + 6), map.size.y + 6});

        const image velocities =
            doppler_picture(exec::par, seen, probe, {.size = map.size, .min_velocity = 0.03_m_per_s});
        const filling of_artery = filling_of(velocities, map, artery_from, artery_to, artery_radius),
                      of_vein = filling_of(velocities, map, vein_from, vein_to, vein_radius);
        std::printf("%3.0f ms: artery %3.0f %% coloured, %+.2f m/s; vein %3.0f %%, %+.2f m/s\n", 1e3F * time,
                    100 * of_artery.coloured, of_artery.velocity, 100 * of_vein.coloured, of_vein.velocity);
        fullest = std::max(fullest, of_artery.coloured);
        emptiest = std::min(emptiest, of_artery.coloured);
        fastest = std::max(fastest, -of_artery.velocity);
        slowest = std::min(slowest, -of_artery.velocity);
        vein_filling = std::max(vein_filling, of_vein.velocity);
    }
    write_png("colour_doppler.png", strip);

    const float angle = std::acos((artery_to - artery_from).z / length(artery_to - artery_from));
    const doppler_spectrum spectrum =
        pulsed_doppler(exec::par_unseq, body, probe, pose{}, flow,
                       {.line = 64,
                        .gate = 14_mm,
                        .prf = 5_kHz,
                        .duration = 1.7F,
                        .spectrum = {.overlap = 0.9F, .baseline = -0.25F, .angle = angle}});
    write_png("pulsed_doppler.png", picture_of(spectrum));

    std::printf("the artery is %.0f to %.0f %% coloured\n", 100 * emptiest, 100 * fullest);
    return fullest > 0.9F && fastest > 2 * slowest && vein_filling > 0.02F ? 0 : 1;
}
