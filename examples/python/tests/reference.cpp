// What the module must give bit for bit, as raw floats: reference <part> <file>.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "../../anatomy/regions.hpp"
#include <cstdio>
#include <cstring>
#include <variant>

using namespace insonify;

namespace {

constexpr b_mode_settings settings{.depth = 50_mm, .size = {160, 0}};

scene phantom() {
    scene body{tissue::muscle};
    body.add(make_sphere({6_mm, 0, 30_mm}, 8_mm, 4), tissue::bone);
    body.add(make_cylinder({-9_mm, -30_mm, 17_mm}, {-9_mm, 30_mm, 17_mm}, 4_mm, 64), tissue::blood);
    return body.build(exec::par);
}

class writer {
  public:
    explicit writer(const char* path) : file_{std::fopen(path, "wb")} {}
    writer(const writer&) = delete;
    writer& operator=(const writer&) = delete;
    ~writer() {
        if (file_ != nullptr) std::fclose(file_);
    }
    template <class Number>
    void operator()(const std::vector<Number>& numbers) {
        if (file_ != nullptr) std::fwrite(numbers.data(), sizeof(Number), numbers.size(), file_);
    }

  private:
    std::FILE* file_;
};

void draw_pictures(writer& write) {
    const scene body = phantom();
    const auto draw = [&](const auto& probe) { write(b_mode(exec::par_unseq, body, probe, pose{}, settings).pixels); };
    draw(linear_array{.lines = 96});
    draw(convex_array{.lines = 96});
    draw(phased_array{.lines = 96});
    draw(radial_array{.lines = 96, .frequency = 5_MHz});
}

void draw_paths(writer& write) {
    const scene body = phantom();
    const linear_array probe{.lines = 96};
    write(trace(exec::par_unseq, body, probe, pose{}, physical{}, {.depth = 50_mm}, paths{}).values);
    write(b_mode(exec::par_unseq, body, probe, pose{}, physical{}, settings, paths{}).pixels);
    const straight_lines rays{.search = line_search::rays, .directions = 1};
    write(b_mode(exec::par_unseq, body, radial_array{.lines = 96}, pose{}, physical{}, settings, rays).pixels);
}

void draw_clip(writer& write) {
    const scene body = phantom();
    scanner machine{linear_array{.lines = 96}, settings};
    machine.cine_length = 3;
    machine.settings.persistence = 0.5F;
    for (std::uint32_t frame = 0; frame < 3; ++frame) {
        machine.settings.frame = frame;
        write(machine.scan(exec::par_unseq, body, pose{}).pixels);
    }
    write(machine.lines().values);
    write(machine.echoes().values);
    machine.freeze();
    machine.settings.gain_db = 6;
    write(machine.show(exec::par_unseq, 2).pixels);
}

void list_layers(writer& write, const line_layers& found) {
    for (std::uint32_t line = 0; line < found.lines; ++line)
        for (std::uint32_t plane = 0; plane < found.planes; ++plane)
            for (const layer& one : found(line, plane)) {
                write(std::vector{one.begin, one.end, one.cosine, one.slope.x, one.slope.y, one.curvature.x,
                                  one.curvature.y, one.curvature.z, one.roughness});
                write(std::vector{one.medium, one.object});
            }
}

void list_layers(writer& write) {
    const scene body = phantom();
    const acquisition scan{.depth = 50_mm, .planes = 3};
    const pose at{.translation = {2_mm, 0, 1_mm}};
    list_layers(write, find_layers(exec::par_unseq, body, linear_array{.lines = 24}, at, scan));
    list_layers(write, find_layers(exec::par_unseq, body, radial_array{.lines = 24}, at, scan));
    scanner machine{linear_array{.lines = 96}, settings};
    machine.scan(exec::par_unseq, body, at);
    list_layers(write, machine.layers());
}

void draw_motion(writer& write) {
    scene body = phantom();
    const linear_array probe{.lines = 96};
    const auto draw = [&] { write(b_mode(exec::par_unseq, body, probe, pose{}, settings).pixels); };
    const pulsation artery{
        .from = {-9_mm, 0, 17_mm}, .to = {-9_mm, 1, 17_mm}, .radius = 4_mm, .amplitude = 0.5_mm, .time = 0.1F};
    body.deform(exec::par, compose(artery, breathing{.amplitude = 3_mm, .time = 1}));
    draw();
    body.deform(exec::par, indentation{.depth = 3_mm});
    draw();
    displacement_grid grid{.origin = {-30_mm, -30_mm, 0}, .spacing = vec3{20_mm}, .size = {4, 4, 4}};
    for (std::uint32_t i = 0; i < 64; ++i) grid.displacements.push_back({0, 0, static_cast<float>(i % 4) * 1_mm});
    body.deform(exec::par, grid);
    draw();
    tetrahedra whole{{{-90_mm, -90_mm, -90_mm}, {250_mm, 0, 0}, {0, 250_mm, 0}, {0, 0, 250_mm}}, {{0, 1, 2, 3}}};
    whole.nodes()[3].z = 255_mm;
    body.deform(exec::par, whole);
    draw();
    scene limb{tissue::air};
    limb.add(make_cylinder({0, -60_mm, 40_mm}, {0, 60_mm, 40_mm}, 40_mm, 256, 64), tissue::muscle);
    limb.build(exec::par);
    const pose at{.translation = {0, 0, 2_mm}};
    limb.deform(exec::par, press(limb, probe, at).deformation);
    write(b_mode(exec::par_unseq, limb, probe, at, settings).pixels);
}

void draw_flow(writer& write) {
    scene body{tissue::muscle};
    const vec3 from{-30_mm, 0, 5_mm}, to{30_mm, 0, 40_mm};
    const object_id artery = body.add(make_cylinder(from, to, 4_mm, 64), tissue::blood);
    body.build(exec::par);
    const poiseuille stream{.object = artery,
                            .from = from,
                            .to = to,
                            .radius = 4_mm,
                            .peak_velocity = 0.4_m_per_s,
                            .waveform = {.heart_rate = 1.2_Hz}};
    const linear_array probe{.lines = 48, .width = 38_mm, .frequency = 6_MHz};
    const flow_lines seen = colour_doppler(exec::par_unseq, body, probe, pose{}, stream,
                                           {.depth = 40_mm, .prf = 6_kHz, .ensemble = 6, .time = 0.125F});
    for (const auto number : {&flow_sample::velocity, &flow_sample::power, &flow_sample::variance})
        for (const flow_sample& one : seen.values) write(std::vector{one.*number});
    write(doppler_picture(exec::par, seen, probe).pixels);
    const radial_array catheter{.lines = 48, .frequency = 6_MHz};
    const flow_lines around = colour_doppler(exec::par_unseq, body, catheter, pose{}, stream,
                                             {.depth = 40_mm, .prf = 6_kHz, .ensemble = 6, .time = 0.125F});
    write(doppler_picture(exec::par, around, catheter).pixels);
    const image grey = b_mode(exec::par_unseq, body, probe, pose{}, {.depth = 40_mm, .size = {160, 0}});
    write(colour_overlay(exec::par, grey, seen, probe).pixels);
    write(pulsed_doppler(exec::par_unseq, body, probe, pose{}, stream,
                         {.line = 24, .gate = 22_mm, .prf = 6_kHz, .duration = 0.05F})
              .power);
    const iq_ensemble echoes =
        doppler_ensemble(exec::par_unseq, body, probe, pose{}, stream, {.depth = 40_mm, .pulses = 3});
    for (const iq_lines& pulse : echoes.pulses) write(pulse.values);
    scanner machine{probe, b_mode_settings{.depth = 30_mm, .size = {160, 0}}};
    machine.scan(exec::par_unseq, body, pose{});
    const flow_lines of_picture =
        machine.colour(exec::par_unseq, body, stream, {.prf = 6_kHz, .ensemble = 6, .time = 0.125F});
    write(doppler_picture(exec::par, of_picture, probe).pixels);
    write(machine.spectrum(exec::par_unseq, body, stream, {.line = 24, .gate = 22_mm, .prf = 6_kHz, .duration = 0.05F})
              .power);
}

void list_channels(writer& write) {
    const scene body = phantom();
    const element_array array{.elements = 24};
    const std::vector<point_scatterer> points{{{1_mm, 0, 12_mm}, 0.1_mm}};
    const channel_data received =
        trace_channels(exec::par_unseq, body, array, pose{}, physical{}, plane_waves(array, 3, 10_deg),
                       {.depth = 30_mm, .noise_level_db = -60, .points = points});
    write(received.values);
    write(demodulate(exec::par_unseq, received).values);
    const convex_element_array bent{.elements = 12};
    write(trace_channels(exec::par_unseq, body, bent, pose{}, physical{}, full_synthetic_aperture(bent),
                         {.depth = 30_mm, .wave_fronts = true})
              .values);
    write(beamform(exec::par_unseq, received, linear_array{.lines = 32}, {.depth = 28_mm},
                   {.fnumber = 1.5F, .window = aperture_window::hann})
              .values);
    const tissue_maps truth = map_tissue(exec::par_unseq, body, pose{}, {.spacing = 0.5_mm, .size = {40, 60}});
    write(truth.sound_speed);
    write(truth.labels);
}

/// The first view of each region, pressed.
void draw_regions(writer& write) {
    for (const anatomy::region& region : anatomy::regions()) {
        anatomy::values values = region.drawn(5);
        if (!region.parameters.empty()) values["resolution"] = 0.5F;
        anatomy::body made = region.make(values);
        made.anatomy.build(exec::par);
        anatomy::view& seen = made.views.front();
        seen.settings.size = {96, 0};
        seen.settings.planes = 1;
        std::visit(
            [&](auto& probe) {
                probe.lines = 64;
                const pose at = anatomy::press_probe(made.anatomy, seen);
                write(b_mode(exec::par_unseq, made.anatomy, probe, at, seen.settings).pixels);
            },
            seen.probe);
    }
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    writer write{argv[2]};
    const auto wanted = [&](const char* part) { return std::strcmp(argv[1], part) == 0; };
    if (wanted("pictures")) draw_pictures(write);
    if (wanted("paths")) draw_paths(write);
    if (wanted("clip")) draw_clip(write);
    if (wanted("layers")) list_layers(write);
    if (wanted("motion")) draw_motion(write);
    if (wanted("flow")) draw_flow(write);
    if (wanted("channels")) list_channels(write);
    if (wanted("regions")) draw_regions(write);
}
