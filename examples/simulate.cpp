// Ultrasound images of an OBJ file, of a region of the body by code, or of the phantom of a nerve block: the terms of the
// paper's eq. 1, as in its figure 3, and a B-mode image. `simulate --help` lists the options.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "nerve_block_phantom.hpp"
#include "progress.hpp"
#include "simulate_options.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <variant>

using namespace insonify;

/// `law2011` with media other than the scene's, which isolates one term of the paper's eq. 1.
struct one_term {
    using sample_type = float;

    law2011 law{};
    std::vector<medium> media{}; ///< one for each of scene.media()

    std::uint32_t samples(float depth, float frequency) const { return law.samples(depth, frequency); }

    template <class Policy>
    void operator()(const Policy& policy, traced_line line, float spacing, view<float> samples) const {
        line.media = media;
        law(policy, line, spacing, samples);
    }
};
static_assert(acoustic_model<one_term>);

/// I_t: no attenuation and no reflected bands.
one_term intensity(law2011 law, std::vector<medium> media) {
    law.reflection_length = 0;
    for (medium& each : media) each.attenuation = 0;
    return {law, std::move(media)};
}

/// I_a: all media have the same impedance, so that no interface reflects.
one_term absorption(const law2011& law, std::vector<medium> media) {
    for (medium& each : media) each.density = each.sound_speed = 1000;
    return {law, std::move(media)};
}

/// I_r: the field I_a I_t is replaced by backscatter of level 0.
one_term reflection_alone(law2011 law, std::vector<medium> media) {
    law.incident = law2011::incident::backscattered;
    law.texture = 0;
    return {law, std::move(media)};
}

law2011 law_named(const std::string& name) {
    if (name == "attenuated") return {.reflection = law2011::reflection::attenuated};
    if (name == "echo")
        return {.travel = law2011::travel::two_way,
                .reflection = law2011::reflection::attenuated,
                .band = law2011::band::after,
                .spectrum = law2011::spectrum::power_law};
    return {};
}

using any_array = std::variant<linear_array, convex_array, phased_array>;

/// What is drawn, and as the command line leaves it: from where, with what.
struct subject {
    std::string title{}; ///< what it is
    scene body{};
    pose at{};
    any_array probe{};
    b_mode_settings settings{};
};

subject load(const simulate_options& chosen) {
    if (!chosen.anatomy.empty()) {
        region_in_view made = load_region(chosen);
        return {made.title, std::move(made.body), made.at, made.seen.probe, made.seen.settings};
    }
    if (chosen.file.empty())
        return {"The built-in phantom of a nerve block", nerve_block_phantom().build(exec::par),
                pose_of(chosen, pose{}), nerve_block::probe, nerve_block::settings};
    body_of_file made = load_file(chosen);
    subject one{made.description, std::move(made.body), pose{}, presets::abdomen.probe, presets::abdomen.settings};
    one.body.build(exec::par);
    one.at = pose_of(chosen, one.body.box());
    one.settings.depth = 80_mm;
    one.settings.tgc = 0;
    return one;
}

/// The structure of the background, by default as below skin that the probe stands on.
void place_background(const simulate_options& chosen, const pose& at, scene& body) {
    const auto direction = [](const std::array<float, 3>& of) { return vec3{of[0], of[1], of[2]}; };
    const vec3 array = at.direction({1, 0, 0}), inwards = at.direction({0, 0, 1});
    // Along a direction that was given, the other cannot be.
    const auto unless_parallel = [](vec3 usual, vec3 given, vec3 instead) {
        return std::fabs(dot(usual, given)) < 0.99F * length(given) ? usual : instead;
    };
    const vec3 layers = chosen.layers   ? direction(*chosen.layers)
                        : chosen.fibres ? unless_parallel(inwards, direction(*chosen.fibres), array)
                                        : inwards;
    const vec3 fibres = chosen.fibres ? direction(*chosen.fibres) : unless_parallel(array, layers, inwards);
    body.set_background_fibres(fibres, layers);
}

std::size_t count_triangles(const scene& body) {
    std::size_t triangles = 0;
    for (const object& one : body.objects()) triangles += one.surface.faces.size();
    return triangles;
}

/// Creates the folder and a file in it, so that a path that cannot be written is reported before the work starts. The file's
/// name is another one for each process: several may write to one folder.
void check_output_folder(const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed) throw io_error{"--output: cannot create the folder '" + folder.string() + "': " + failed.message()};
    const std::filesystem::path trial = folder / ("simulate" + std::to_string(std::random_device{}()) + ".tmp");
    if (!std::ofstream{trial})
        throw io_error{"--output: cannot write to the folder '" + folder.string() + "'; choose another one"};
    std::filesystem::remove(trial);
}

/// The probe of the command line; without --probe, that of the subject.
any_array probe_of(const simulate_options& chosen, const any_array& usual) {
    const auto with_settings = [&](auto array) {
        const auto refuse = [](const char* name) {
            throw usage_error{std::string{name} + ": this kind of probe has no such setting"};
        };
        array.lines = chosen.lines.value_or(array.lines);
        if (chosen.frequency) array.frequency = *chosen.frequency * 1_MHz;
        if constexpr (requires { array.width; })
            array.width = chosen.width ? *chosen.width * 1_mm : array.width;
        else if (chosen.width)
            refuse("--width");
        if constexpr (requires { array.radius; })
            array.radius = chosen.radius ? *chosen.radius * 1_mm : array.radius;
        else if (chosen.radius)
            refuse("--radius");
        if constexpr (requires { array.field_of_view; })
            array.field_of_view = chosen.field_of_view ? *chosen.field_of_view * 1_deg : array.field_of_view;
        else if (chosen.field_of_view)
            refuse("--field-of-view");
        if (std::is_same_v<decltype(array), phased_array> && chosen.field_of_view > 180)
            throw usage_error{
                "--field-of-view: of a phased array it must be at most 180; a convex one takes up to 360"};
        array.check();
        return any_array{array};
    };
    if (chosen.probe == "linear") return with_settings(nerve_block::probe);
    if (chosen.probe == "convex") return with_settings(presets::abdomen.probe);
    if (chosen.probe == "phased") return with_settings(presets::heart.probe);
    return std::visit(with_settings, usual);
}

template <transducer Probe>
void run(const simulate_options& chosen, subject& one, const Probe& probe, timed_stages& stage) {
    const law2011 law = law_named(chosen.law);
    b_mode_settings settings = chosen.probe.empty() ? one.settings : presets::settings_for(probe);
    const float depth = chosen.depth ? *chosen.depth * 1_mm : one.settings.depth;
    const acquisition scan{.depth = depth, .samples = law.samples(depth, probe.frequency)};
    const uvec2 size{chosen.size[0], chosen.size[1]};
    const std::string folder = chosen.output + '/';
    scene& body = one.body;
    const pose& at = one.at;
    std::printf("%s\n", one.title.c_str());
    if (!chosen.file.empty()) place_background(chosen, at, body);
    const diagnosis found = stage("diagnose", [&](const auto&) { return diagnose(body, probe, at, scan); });
    if (!chosen.file.empty()) { // covered after the diagnosis, which is of the file
        const float skin = chosen.skin.value_or(chosen.background ? 0 : 1.5F) * 1_mm;
        if (skin > 0 && add_skin(body, probe, at, {.thickness = skin}) != skin_place::none) body.build(exec::par);
    }
    const vec3 from = at.translation / 1_mm;
    std::printf("  %zu objects, %zu triangles, seen from (%g, %g, %g) mm: %g mm deep, %u lines, %g MHz\n",
                body.objects().size(), count_triangles(body), from.x, from.y, from.z, depth / 1_mm, probe.lines,
                probe.frequency / 1_MHz);

    stage("scene.obj",
          [&](const auto&) { return write_debug_obj(folder + "scene.obj", body, probe, at, depth), true; });
    const scan_map map =
        stage("scan map", [&](const auto& policy) { return make_scan_map(policy, probe, scan, {.size = size}); });
    const auto write = [&](const std::string& name, const auto& make) {
        return stage(name.c_str(), [&](const auto& policy) {
            image picture = make(policy);
            write_png(folder + name + ".png", picture);
            return picture;
        });
    };
    const auto draw = [&](const std::string& name, const one_term& model) {
        return write(name, [&](const auto& policy) {
            return scan_convert(policy, trace(policy, body, probe, at, model, scan), map);
        });
    };
    const std::vector<medium> media{body.media().begin(), body.media().end()};
    draw("intensity", intensity(law, media));
    draw("absorption", absorption(law, media));
    draw("reflection", reflection_alone(law, media));
    const image combined = draw("combined", {law, media});
    const image noisy = write(
        "noise", [&](const auto& policy) { return add_noise(policy, combined, make_noise(policy, combined.size)); });
    write("blur", [&](const auto& policy) { return radial_blur(policy, noisy, probe, map); });
    settings.depth = depth;
    settings.size = size;
    settings.tgc = chosen.tgc ? *chosen.tgc * 1_dB_per_cm : one.settings.tgc;
    settings.planes = chosen.planes.value_or(chosen.anatomy.empty() ? 7 : one.settings.planes);
    settings.compound.angles = chosen.looks.value_or(chosen.anatomy.empty() ? 3 : one.settings.compound.angles);
    write("b_mode", [&](const auto& policy) { return b_mode(policy, body, probe, at, settings); });

    std::printf(
        "The images, intensity.png to b_mode.png, and scene.obj (the probe, its lines and the meshes) are in %s\n",
        folder.c_str());
    const bool is_open = std::find(found.problems.begin(), found.problems.end(), diagnosis::problem::open_surface) !=
                         found.problems.end();
    if (is_open && !chosen.file.empty() && !chosen.repair)
        std::puts("Some surfaces are open: --repair may close them.");
    if (!found.sentence.empty())
        std::printf("%s\nOpen %sscene.obj in a mesh viewer to see the probe and the meshes.\n", found.sentence.c_str(),
                    folder.c_str());
}

int main(int count, char** arguments) {
    simulate_options chosen;
    return command_line::run(
        "simulate", count, arguments, [&](CLI::App& app) { add_options(app, chosen); },
        [&] {
            if (chosen.list) {
                list_regions(chosen.anatomy);
                return 0;
            }
            check_place(chosen);
            check_output_folder(chosen.output);
            timed_stages stage{11};
            subject one = stage("load", [&](const auto&) { return load(chosen); });
            std::visit([&](const auto& probe) { run(chosen, one, probe, stage); }, probe_of(chosen, one.probe));
            return 0;
        });
}
