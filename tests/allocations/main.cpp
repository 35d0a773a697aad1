#include <insonify/insonify.hpp>
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <type_traits>
#include <vector>

// Counts what a clip allocates, frame by frame: nothing when it is shown again, and memory has grown to what it takes. And
// what `trace_channels` takes, against what it says beforehand.
namespace {
std::atomic<long> allocations{0};
std::atomic<std::size_t> held{0}, max_held{0}; // bytes

struct block_header {
    void* memory;
    std::size_t size;
};

// Kept out of line: inlined, GCC would take malloc and delete, or new and free, for pairs that do not match.
[[gnu::noinline]] void* allocated(std::size_t size, std::size_t alignment) {
    ++allocations;
    std::size_t room = size + alignment + sizeof(block_header);
    void* const memory = std::malloc(room);
    if (memory == nullptr) throw std::bad_alloc{};
    room -= sizeof(block_header);
    void* place = static_cast<char*>(memory) + sizeof(block_header);
    place = std::align(alignment, size, place, room);
    static_cast<block_header*>(place)[-1] = {memory, size};
    const std::size_t now = held += size;
    for (std::size_t before = max_held; before < now && !max_held.compare_exchange_weak(before, now);) {
    }
    return place;
}
[[gnu::noinline]] void freed(void* place) noexcept {
    if (place == nullptr) return;
    const block_header own = static_cast<block_header*>(place)[-1];
    held -= own.size;
    std::free(own.memory);
}
} // namespace

[[gnu::noinline]] void* operator new(std::size_t size) { return allocated(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
    return allocated(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* place) noexcept { freed(place); }
[[gnu::noinline]] void operator delete(void* place, std::size_t) noexcept { freed(place); }
[[gnu::noinline]] void operator delete(void* place, std::align_val_t) noexcept { freed(place); }
[[gnu::noinline]] void operator delete(void* place, std::size_t, std::align_val_t) noexcept { freed(place); }

namespace {
using namespace insonify;

// The most that one frame allocates, from the second round on: five hundred objects, of which some are placed and some
// deformed each frame, traced as echoes along straight lines and along paths, as intensities by rays and as labels.
template <class Policy>
long allocated_among_many(const Policy& policy) {
    scene body{tissue::muscle};
    const medium media[] = {tissue::blood, tissue::fat, tissue::liver};
    std::vector<object_id> balls;
    for (std::uint64_t i = 0; i < 500; ++i) {
        const vec3 fraction{hash_uniform(1, 3 * i), hash_uniform(1, 3 * i + 1), hash_uniform(1, 3 * i + 2)};
        balls.push_back(
            body.add(make_sphere({0, 0, 0}, 1_mm, 1), media[i % 3],
                     {.at = {.translation = vec3{-20_mm, -2_mm, 1_mm} + fraction * vec3{40_mm, 4_mm, 38_mm}}}));
    }
    body.build(policy);
    const linear_array probe{.lines = 24, .width = 40_mm, .frequency = 5_MHz};
    const acquisition scan{.depth = 40_mm, .samples = 640}, thick{.depth = 40_mm, .samples = 640, .planes = 3};
    line_tracer<> of_lines;
    line_tracer<physical<>, paths> of_paths;
    line_tracer<law2011> of_rays;
    iq_lines lines, along_paths;
    scan_lines intensities;
    label_lines labels;
    constexpr int frames = 8;
    long largest = 0;
    for (int i = 0; i < 2 * frames; ++i) {
        const auto step = static_cast<float>(i % frames);
        const pose at{.translation = {0.1_mm * step, 0, 0}};
        const long before = allocations;
        for (std::size_t k = 0; k < balls.size(); k += 5) {
            pose moved = body[balls[k]].at;
            moved.translation.y = 0.2_mm * (step - 4);
            body.place(balls[k], moved);
        }
        for (std::size_t k = 1; k < balls.size(); k += 5)
            for (vec3& p : body.positions(balls[k])) p *= i % 2 == 0 ? 1.1F : 1 / 1.1F;
        body.update(policy);
        lines = of_lines.trace(policy, body, probe, at, physical{}, thick, {}, std::move(lines));
        along_paths = of_paths.trace(policy, body, probe, at, physical{}, thick, {}, std::move(along_paths));
        intensities = of_rays.trace(policy, body, probe, at, law2011{}, scan, straight_lines{line_search::rays},
                                    std::move(intensities));
        labels = label(policy, of_lines.layers(), {scan.depth, scan.samples}, std::move(labels));
        if (i >= frames) largest = std::max(largest, allocations - before);
    }
    return largest;
}

// The most that one frame allocates once every value of every knob has been seen: knobs that turn at each frame.
template <class Policy>
long allocated_by_knobs(const Policy& policy, const scene& body, std::uint32_t looks) {
    scanner machine{linear_array{.lines = 64, .width = 40_mm, .frequency = 7.5_MHz},
                    b_mode_settings{.depth = 40_mm, .size = {128, 0}, .planes = 3, .persistence = 0.3F}};
    machine.cine_length = 5;
    machine.settings.compound.angles = looks;
    constexpr int values = 4, knobs = 8, seen = 2 * values * knobs; // every combination that comes again
    long largest = 0;
    for (int i = 0; i < seen + values * knobs; ++i) {
        const auto value = static_cast<float>(i / knobs % values);
        const long before = allocations;
        switch (i % knobs) {
        case 0:
            machine.settings.depth = 40_mm - value * 1_mm;
            break;
        case 1:
            machine.probe.focus = 15_mm + value * 1_mm;
            break;
        case 2:
            machine.probe.frequency = 7.5_MHz - value * 0.1_MHz;
            break;
        case 3:
            machine.settings.gain_db = value;
            break;
        case 4:
            machine.settings.time_gain.sliders[3] = value;
            break;
        case 5:
            machine.probe.width = 40_mm - value * 1_mm;
            break;
        case 6:
            machine.settings.planes = 1 + 2 * (static_cast<std::uint32_t>(value) % 2);
            break;
        default:
            machine.settings.dynamic_range_db = 60 + value;
        }
        machine.scan(policy, body, {.translation = {0.1_mm * value, 0, 0}});
        machine.labels(policy, body);
        if (i >= seen) largest = std::max(largest, allocations - before);
    }
    machine.freeze();
    for (std::uint32_t back = 0; back < 10; ++back) { // the first round grows
        const long before = allocations;
        machine.settings.tgc = 50 + static_cast<float>(back);
        machine.show(policy, back % 5);
        if (back >= 5) largest = std::max(largest, allocations - before);
    }
    return largest;
}

// The most that one frame allocates while a probe is pressed into a limb whose vessels pulse and collapse, from the second
// round on.
template <class Policy>
long allocated_by_press(const Policy& policy) {
    scene body{tissue::air};
    body.add(make_cylinder({0, -60_mm, 40_mm}, {0, 60_mm, 40_mm}, 40_mm, 256, 64), tissue::fat);
    body.add(make_cylinder({0, -50_mm, 40_mm}, {0, 50_mm, 40_mm}, 36_mm, 128, 32), tissue::muscle);
    body.add(make_cylinder({0, -50_mm, 17_mm}, {0, 50_mm, 17_mm}, 4_mm, 64, 32), tissue::blood);
    body.build(policy);
    const linear_array probe{.lines = 64, .width = 38_mm, .frequency = 7.5_MHz};
    scanner<linear_array> machine{probe, {.depth = 40_mm, .size = {256, 256}}};
    presser pressing;
    constexpr int frames = 8;
    long largest = 0;
    for (int i = 0; i < 2 * frames; ++i) {
        const auto step = static_cast<float>(i % frames);
        const pose at{.translation = {0.2_mm * step, 0, 1_mm + 0.5_mm * step}};
        const long before = allocations;
        const contact& touch = pressing.press(body, probe, at);
        body.deform(policy,
                    compose(collapse{.from = {0, 0, 17_mm}, .to = {0, 1, 17_mm}, .radius = 4_mm, .outside = 300 * step},
                            touch.deformation));
        machine.scan(policy, body, at);
        if (i >= frames) largest = std::max(largest, allocations - before);
    }
    return largest;
}

// The most that one frame allocates while maps deform the body, from the second round on: functions, and tetrahedra.
template <class Policy>
long allocated_by_maps(const Policy& policy) {
    scene body{tissue::muscle};
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 4), tissue::blood);
    body.add(make_box({-30_mm, -10_mm, 0}, {30_mm, 10_mm, 5_mm}, 5), tissue::fat);
    body.build(policy);
    const linear_array probe{.lines = 64, .width = 40_mm, .frequency = 7.5_MHz};
    tetrahedra divided{{{-90_mm, -90_mm, -90_mm}, {250_mm, 0, 0}, {0, 250_mm, 0}, {0, 0, 250_mm}}, {{0, 1, 2, 3}}};
    scanner<linear_array> machine{probe, {.depth = 40_mm, .size = {256, 256}}};
    constexpr int frames = 8;
    long largest = 0;
    for (int i = 0; i < 4 * frames; ++i) {
        const float time = 0.1F * static_cast<float>(i % frames);
        const long before = allocations;
        if (i / frames % 2 == 0) {
            body.deform(policy, compose(breathing{.time = time}, pulsation{.from = {-8_mm, 0, 15_mm}, .time = time}));
        } else {
            divided.nodes()[3].z = 250_mm + 1_mm * time;
            body.deform(policy, divided);
        }
        machine.scan(policy, body, pose{});
        const bool changes_type = i % frames == 0;
        if (i >= 2 * frames && !changes_type) largest = std::max(largest, allocations - before);
    }
    return largest;
}

// The most that one frame allocates with colour Doppler over the picture, from the second frame on.
template <class Policy>
long allocated_by_flow(const Policy& policy) {
    scene body{tissue::muscle};
    const object_id vessel = body.add(make_cylinder({0, -40_mm, 15_mm}, {0, 40_mm, 15_mm}, 5_mm, 32, 8), tissue::blood);
    body.build(policy);
    const auto stream = [=](object_id id, vec3, float) { return id == vessel ? vec3{0, 0.1F, -0.3F} : vec3{0}; };
    scanner<linear_array> machine{linear_array{.lines = 32, .width = 20_mm, .frequency = 5_MHz},
                                  {.depth = 30_mm, .size = {128, 128}}};
    kept_scan_map<linear_array> kept;
    colour_image picture;
    long largest = 0;
    for (int i = 0; i < 6; ++i) {
        const long before = allocations;
        const auto time = 0.04F * static_cast<float>(i);
        const image& grey = machine.scan(policy, body, pose{});
        const flow_lines& seen =
            machine.colour(policy, body, stream, {.ensemble = 6, .box = {.from = 8_mm, .to = 22_mm}, .time = time});
        const scan_map& map =
            kept(policy, machine.probe, {.depth = seen.depth, .samples = seen.samples}, {.size = grey.size});
        picture = colour_overlay(policy, grey, seen, map, {}, std::move(picture));
        if (i > 0) largest = std::max(largest, allocations - before);
    }
    return largest;
}

// Whether `trace_channels` says at least what it takes, and not half as much again; and takes none of it where that is
// too much.
template <class Policy>
bool says_memory(const char* name, const Policy& policy, const scene& body, const element_array& array,
                 channel_settings settings) {
    const std::vector<transmit> sent = plane_waves(array, 3, 20_deg);
    const auto trace = [&] { return trace_channels(policy, body, array, pose{}, physical{}, sent, settings); };
    settings.max_memory = 1;
    const std::size_t before = held;
    max_held = before;
    double said = 0; // GB
    try {
        trace();
    } catch (const usage_error& refused) {
        const std::string sentence = refused.what();
        const std::size_t at = sentence.find("take ");
        said = at == std::string::npos ? 0 : std::strtod(sentence.c_str() + at + 5, nullptr);
    }
    const auto taken_since = [&] { return 1e-9 * static_cast<double>(max_held - before); };
    const double refused = taken_since();
    settings.max_memory = std::uint64_t{4} << 30U;
    max_held = before;
    trace();
    const double taken = taken_since();
    std::printf("channel data of %s: %.4f GB said, %.4f GB taken, %.4f GB where it is refused\n", name, said, taken,
                refused);
    return said >= taken && said <= 1.5 * taken && refused < 0.2 * taken;
}
bool channels_say_memory() {
    scene layered{tissue::liver}, plain{medium{.density = 1000, .sound_speed = 1540}};
    for (int i = 0; i < 20; ++i)
        layered.add(
            make_sphere({static_cast<float>(i % 5 - 2) * 4_mm, 0, static_cast<float>(i / 5 + 1) * 4_mm}, 1.8_mm, 3),
            i % 2 == 0 ? tissue::blood : tissue::fat);
    layered.build(exec::par);
    plain.build(exec::par);
    std::vector<point_scatterer> points;
    for (std::uint64_t i = 0; i < 200000; ++i)
        points.push_back({{(hash_uniform(1, i) - 0.5F) * 8_mm, 0, 2_mm + hash_uniform(2, i) * 8_mm}, 1e-6F});
    const element_array many{.elements = 64}, few{.elements = 8};
    const auto& all = exec::par_unseq;
    const bool of_layers = says_memory("layers", all, layered, many, {.depth = 20_mm}),
               of_fronts = says_memory("wave fronts", all, layered, many, {.depth = 20_mm, .wave_fronts = true}),
               of_points = says_memory("points", all, plain, few, {.depth = 12_mm, .points = points});
    // Deep, so that the transforms of each thread count.
    const channel_settings deep{.depth = 900_mm, .opening = 0, .speckle = false};
    const bool of_one = says_memory("one thread", exec::unseq, plain, few, deep),
               of_eight = says_memory("eight threads", all.threads(8), plain, few, deep);
    return of_layers && of_fronts && of_points && of_one && of_eight;
}
} // namespace

int main() {
    scene body{tissue::muscle};
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 4), tissue::blood);
    const object_id bone = body.add(make_sphere({0, 0, 0}, 5_mm, 4), tissue::bone);
    body.build(exec::par);

    const linear_array probe{.lines = 128, .width = 40_mm, .frequency = 7.5_MHz};
    const b_mode_settings plain{.depth = 40_mm, .size = {256, 256}};
    const auto allocated_by = [&](const auto& policy, const b_mode_settings& settings, const auto& how) {
        scanner<linear_array, physical<>, std::decay_t<decltype(how)>> machine{probe, settings};
        const mesh rest = make_sphere({0, 0, 0}, 5_mm, 4);
        constexpr int frames = 8;
        const int seen = frames * static_cast<int>(settings.compound.angles); // every frame by every look
        long largest = 0;
        for (int i = 0; i < seen + frames; ++i) {
            const auto frame = static_cast<float>(i % frames);
            const long before = allocations;
            body.place(bone, {.translation = {8_mm, 0, 20_mm - 0.1_mm * frame}});
            const std::span<vec3> now = body.positions(bone);
            for (std::size_t k = 0; k < now.size(); ++k) now[k] = (1 - 0.01F * frame) * rest.positions[k];
            body.update(policy);
            machine.scan(policy, body, {.translation = {0, 0.05_mm * frame, 0}});
            if (i >= seen) largest = std::max(largest, allocations - before);
        }
        return largest;
    };
    const straight_lines straight{};
    const long sequenced = allocated_by(exec::seq, plain, straight),
               parallel = allocated_by(exec::par_unseq.threads(2), plain, straight);
    std::printf("allocations a frame: %ld with seq, %ld with par_unseq; expected 0\n", sequenced, parallel);
    const long followed = allocated_by(exec::par_unseq.threads(2), plain, paths{});
    std::printf("by paths: %ld; expected 0\n", followed);
    b_mode_settings all = plain, one = plain;
    all.compound = {.angles = 3};
    one.compound = {.angles = 3, .update = compound_settings::update_mode::one};
    const long compounded = allocated_by(exec::par_unseq.threads(2), all, straight),
               rolling = allocated_by(exec::par_unseq.threads(2), one, straight);
    std::printf("compounded: %ld all at once, %ld one look at a time; expected 0\n", compounded, rolling);
    const long knobs =
        std::max(allocated_by_knobs(exec::seq, body, 1), allocated_by_knobs(exec::par_unseq.threads(2), body, 3));
    std::printf("a knob turned at every frame, and frozen frames: %ld; expected 0\n", knobs);
    const long many = allocated_among_many(exec::seq), many_parallel = allocated_among_many(exec::par_unseq.threads(2));
    std::printf("among 500 objects: %ld with seq, %ld with par_unseq; expected 0\n", many, many_parallel);
    const long maps = allocated_by_maps(exec::seq), maps_parallel = allocated_by_maps(exec::par_unseq.threads(2));
    std::printf("deformed by maps: %ld with seq, %ld with par_unseq; expected 0\n", maps, maps_parallel);
    const long pressed = allocated_by_press(exec::seq),
               pressed_parallel = allocated_by_press(exec::par_unseq.threads(2));
    std::printf("pressed by the probe: %ld with seq, %ld with par_unseq; expected 0\n", pressed, pressed_parallel);
    const long flow = allocated_by_flow(exec::seq), flow_parallel = allocated_by_flow(exec::par_unseq.threads(2));
    std::printf("colour Doppler: %ld with seq, %ld with par_unseq; expected 0\n", flow, flow_parallel);
    const bool said = channels_say_memory();
    return said && flow == 0 && flow_parallel == 0 && pressed == 0 && pressed_parallel == 0 && maps == 0 &&
                   maps_parallel == 0 && sequenced == 0 && parallel == 0 && followed == 0 && compounded == 0 &&
                   rolling == 0 && knobs == 0 && many == 0 && many_parallel == 0
               ? 0
               : 1;
}
