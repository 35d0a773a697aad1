#include "../support/chain_scene.hpp"
#include "../support/paper_scenes.hpp"
#include "rows.hpp"

/// How late frames may come: the first one, which allocates and makes tables, and the slowest of a hundred after that;
/// each against the median.
namespace bench {
namespace {

using namespace insonify;

void measure_frames(table& into, const std::string& data, const std::function<void()>& draw) {
    std::vector<double> milliseconds;
    for (int i = 0; i < 1001; ++i) milliseconds.push_back(seconds_of(draw) * 1e3);
    const double first = milliseconds.front();
    milliseconds.erase(milliseconds.begin());
    std::sort(milliseconds.begin(), milliseconds.end());
    const double median = milliseconds[500];
    const auto add = [&](const std::string& work, double ours) {
        into.add({.work = work,
                  .data = data,
                  .unit = "ms",
                  .ours = ours,
                  .peers = median,
                  .peer = "median",
                  .ratio = median / ours});
    };
    add("first frame", first);
    add("99th percentile of 1000 frames", milliseconds[990]);
}

void measure_latency_rows(table& into) {
    if (!into.wants("first frame") && !into.wants("99th percentile of 1000 frames")) return;
    {
        const scene body = chain::organ();
        chain::frame own;
        measure_frames(into, "chain, organ 20k", [&] { own.draw(exec::par_unseq, body); });
    }
    const scene body = paper::scene_of(paper::one_cube(6));
    paper::frames<> own;
    measure_frames(into, "paper's frame, 49152 triangles", [&] { own(paper::best, body); });
}

const rows of_latency{50, measure_latency_rows};

} // namespace
} // namespace bench
