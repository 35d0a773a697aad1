/// Prints how long a session takes from an event to its picture: live_latency --help
///
/// 256 lines, 40 mm, 5 planes, compounding, persistence, pulse and pressure, on two threads. Every other frame turns knobs
/// beforehand; their cost is the ratio of the two medians.
#include "../command_line.hpp"
#include "session.hpp"
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

namespace {

using namespace insonify;

/// Milliseconds of a frame after events.
double picture_after(live::session& one, const std::vector<live::event>& events) {
    const auto begin = std::chrono::steady_clock::now();
    for (const live::event& each : events) one.apply(each);
    one.frame(exec::par_unseq.threads(2));
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

double quantile(std::vector<double>& times, double fraction) {
    std::sort(times.begin(), times.end());
    return times[static_cast<std::size_t>(fraction * static_cast<double>(times.size() - 1))];
}

void print(const char* name, std::vector<double>& times) {
    const double median = quantile(times, 0.5);
    std::printf("%-28s median %6.1f ms, 99th percentile %6.1f ms, %5.1f frames/s\n", name, median,
                quantile(times, 0.99), 1e3 / median);
}

int run(int frames) {
    const auto configured = [](float looks) {
        live::session one;
        for (const live::event& each : {live::event{"lines", {256}},
                                        {"depth", {40}},
                                        {"planes", {5}},
                                        {"width", {512}},
                                        {"compound", {looks}},
                                        {"persistence", {0.3F}},
                                        {"press", {2}},
                                        {"advance", {20}}})
            one.apply(each);
        for (int i = 0; i < 8; ++i) one.frame(exec::par_unseq.threads(2));
        return one;
    };
    live::session one = configured(3), at_rest = configured(1), turned = configured(1);
    std::vector<double> moved, still, knobs, colour, pulsed;
    for (int i = 0; i < frames; ++i) {
        const float side = i % 2 == 0 ? 1.0F : -1.0F, fraction = static_cast<float>(i % 7);
        moved.push_back(picture_after(one, {{"slide", {0.3F * side, 0.2F * side}}, {"tilt", {0.5F * side}}}));
        still.push_back(picture_after(at_rest, {}));
        knobs.push_back(picture_after(turned, {{"depth", {37 + fraction}},
                                               {"focus", {15 + fraction}},
                                               {"frequency", {7 + 0.1F * fraction}},
                                               {"gain", {side}}}));
    }
    print("probe moves", moved);
    print("nothing turns", still);
    print("four knobs turn", knobs);
    std::printf("knobs cost %.2f times\n", quantile(knobs, 0.5) / quantile(still, 0.5));
    at_rest.apply({"tilt", {20}});
    for (const float shown : {2.0F, 4.0F}) {
        at_rest.apply({"mode", {shown}});
        std::vector<double> times;
        for (int i = 0; i < frames / 4; ++i) times.push_back(picture_after(at_rest, {}));
        print(shown == 2 ? "colour Doppler" : "pulsed Doppler", times);
    }
    return 0;
}

} // namespace

int main(int count, char** arguments) {
    int frames = 200;
    return command_line::run(
        "live_latency", count, arguments,
        [&](CLI::App& app) {
            app.description("Prints how long a session takes from an event to its picture, on two threads.");
            command_line::add_whole_number(app, "--frames", frames, "COUNT", "frames of each kind", 10, 100'000);
        },
        [&] { return run(frames); });
}
