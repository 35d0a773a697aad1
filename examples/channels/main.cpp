// Channel data of an OBJ file, of a region of the body or of a phantom, as HDF5 in the layout of zea or of USTB.
// `channels --help` lists the options.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "../dataset/file.hpp"
#include "../nerve_block_phantom.hpp"
#include "options.hpp"
#include "recording.hpp"
#include "uff_file.hpp"
#include "zea_file.hpp"
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

using namespace insonify;

namespace {

/// What lies there, from where, and how a view of it is recorded.
struct subject {
    std::string title{};
    scene body{};
    pose at{};
    std::vector<point_scatterer> points{};
    std::string array_type = "linear";
    float depth = 40_mm;
};

/// Nine point scatterers in a fluid, which scatter as much as a surface of some square millimetres.
subject make_points() {
    subject one{.title = "nine point scatterers in a fluid of 1540 m/s",
                .body = scene{medium{.density = 1000, .sound_speed = 1540}}.build(exec::par)};
    for (const float z : {10_mm, 20_mm, 30_mm})
        for (const float x : {-10_mm, 0.0F, 10_mm}) one.points.push_back({{x, 0, z}, 1_mm});
    return one;
}

subject load_phantom(const channels::options& chosen) {
    subject one = chosen.phantom == "points" ? make_points()
                                             : subject{.title = "the phantom of a nerve block",
                                                       .body = nerve_block_phantom().build(exec::par)};
    one.at = pose_of(chosen, pose{});
    return one;
}

/// The probe of a view, pressed into the skin, gives it the shape of its face.
/// @throws usage_error  for an array of another kind
void check_array(const channels::options& chosen, const anatomy::view& seen) {
    const std::string type = channels::array_type(seen.probe);
    if (chosen.array.empty() || chosen.from) return;
    if (const char* const own = channels::find_array(chosen.array).type; own != type)
        throw usage_error{"--array: " + chosen.array + " is a " + own + " array, but a " + type +
                          " probe is pressed into the skin in the view '" + seen.name + "'; choose " +
                          channels::arrays_of_type(type) + ", or another place with --from"};
}

subject load_view(const channels::options& chosen) {
    region_in_view made = load_region(chosen);
    check_array(chosen, made.seen);
    return {.title = made.title,
            .body = std::move(made.body),
            .at = made.at,
            .array_type = channels::array_type(made.seen.probe),
            .depth = made.seen.settings.depth};
}

subject load_mesh(const channels::options& chosen) {
    body_of_file made = load_file(chosen);
    check_anatomy(made.body, chosen.file, chosen.unit * 1_mm, "--unit 1", chosen.repair ? "" : "--repair");
    std::printf("%s\n", made.description.c_str());
    made.body.build(exec::par);
    const pose at = pose_of(chosen, made.body.box());
    return {.title = std::filesystem::path{chosen.file}.filename().string(), .body = std::move(made.body), .at = at};
}

subject load(const channels::options& chosen) {
    if (!chosen.anatomy.empty()) return load_view(chosen);
    return chosen.file.empty() ? load_phantom(chosen) : load_mesh(chosen);
}

template <element_transducer Array>
void run(const channels::options& chosen, const subject& one, const channels::named_array& named, const Array& array) {
    const std::vector<transmit> sent = channels::transmits_named(chosen.transmits, array);
    // Points are those of the array: they stay in front of it wherever it is.
    std::vector<point_scatterer> points = one.points;
    for (point_scatterer& each : points) each.position = one.at.point(each.position);
    channel_settings settings{.depth = chosen.depth ? *chosen.depth * 1_mm : one.depth,
                              .sampling_frequency = chosen.sampling_frequency * 1_MHz,
                              .opening = named.opening_deg * 1_deg,
                              .wave_fronts = chosen.wave_fronts,
                              .noise_level_db = chosen.noise.value_or(no_level_db),
                              .max_memory = static_cast<std::uint64_t>(1e9 * static_cast<double>(chosen.memory)),
                              .points = points};
    const auto trace_one = [&](std::uint32_t frame) -> channels::frame_data {
        const auto begin = std::chrono::steady_clock::now();
        settings.frame = frame;
        channel_data received = trace_channels(exec::par_unseq, one.body, array, one.at, physical{}, sent, settings);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
        if (frame == 0)
            std::printf("%s: %u transmits, %u elements, %u samples at %g MHz; %.2f s a frame\n", one.title.c_str(),
                        received.transmits, received.elements, received.samples,
                        static_cast<double>(received.sampling_frequency / 1_MHz), taken.count());
        if (chosen.iq) return channels::thinned(demodulate(exec::par_unseq, received));
        return {.received = std::move(received)};
    };
    const channels::recording made{.array = named,
                                   .body = one.body,
                                   .at = one.at,
                                   .title = one.title,
                                   .points = one.points,
                                   .frames = chosen.frames,
                                   .depth = settings.depth,
                                   .trace_one = trace_one};
    dataset::replace_file(chosen.output, chosen.format == "uff" ? channels::uff_file(made) : channels::zea_file(made));
    std::printf("%s: %.1f MB\n", chosen.output.c_str(),
                1e-6 * static_cast<double>(std::filesystem::file_size(chosen.output)));
}

/// A path that cannot be written is reported before the work starts.
void check_output(const std::string& path) {
    if (std::filesystem::is_directory(path))
        throw io_error{"--output: '" + path + "' is a folder; name a file, such as channels.hdf5"};
    const std::string trial = path + ".draft";
    dataset::write_file(trial, "");
    std::filesystem::remove(trial);
}

} // namespace

int main(int count, char** arguments) {
    channels::options chosen;
    return command_line::run(
        "channels", count, arguments, [&](CLI::App& app) { channels::add_options(app, chosen); },
        [&] {
            if (chosen.list) {
                list_regions(chosen.anatomy);
                return 0;
            }
            check_place(chosen);
            check_output(chosen.output);
            std::visit([&](const auto& any) { static_cast<void>(channels::transmits_named(chosen.transmits, any)); },
                       channels::arrays().front().elements); // its words, before the work starts
            const subject one = load(chosen);
            const channels::named_array& named =
                chosen.array.empty() ? channels::array_of_type(one.array_type) : channels::find_array(chosen.array);
            std::visit([&](const auto& array) { run(chosen, one, named, array); }, named.elements);
            return 0;
        });
}
