#include "../support/chain_scene.hpp"
#include "rows.hpp"

/// The whole chain, and what a second thread brings each of its stages.
namespace bench {
namespace {

using namespace insonify;

// A published figure: raysim on an RTX 6000 Ada, 256 lines x 4096 samples of one liver to 500 x 500.
constexpr double raysim_ms = 7.3, must_ms = 15;

void measure_whole(table& into, std::uint32_t threads) {
    const scene body = chain::organ();
    chain::frame own;
    std::vector<contender> all{{"", [&] { own.draw(exec::par_unseq.threads(threads), body); }}};
    run(all, {.seconds = 4});
    const double ours = all.front().median() * 1e3;
    into.add({.work = "chain, physical, 256 x 4096 to 500 x 500",
              .data = "organ 20k, " + std::to_string(threads) + " threads",
              .unit = "ms",
              .ours = ours,
              .peers = raysim_ms,
              .peer = "raysim, RTX 6000 Ada, as published",
              .ratio = raysim_ms / ours,
              .must = raysim_ms / must_ms});
}

// Ours is a stage on two threads, its peer the same on one.
template <class Work>
void measure_scaling(table& into, const std::string& stage, const Work& work) {
    into.measure({.work = "two threads: " + stage, .data = "organ 20k", .unit = "ms"},
                 {{"", [&] { work(exec::par_unseq.threads(2)); }}, {"one thread", [&] { work(exec::unseq); }}});
}

void measure_chain_rows(table& into) {
    if (into.wants("chain, physical"))
        for (const std::uint32_t threads : {1U, 2U}) measure_whole(into, threads);
    if (!into.wants("two threads")) return;
    const scene body = chain::organ();
    chain::frame own;
    own.draw(exec::par_unseq, body);
    measure_scaling(into, "trace", [&](const auto& policy) { own.trace_echoes(policy, body); });
    measure_scaling(into, "convolve", [&](const auto& policy) { own.spread(policy); });
    measure_scaling(into, "envelope", [&](const auto& policy) { own.detect(policy); });
    measure_scaling(into, "tgc", [&](const auto& policy) { own.compensate(policy); });
    measure_scaling(into, "log_compress", [&](const auto& policy) { own.compress(policy); });
    measure_scaling(into, "scan_convert", [&](const auto& policy) { own.convert(policy); });
    measure_scaling(into, "make_scan_map",
                    [&](const auto& policy) { make_scan_map(policy, chain::probe, chain::scan, chain::picture); });
}

const rows of_chain{40, measure_chain_rows};

} // namespace
} // namespace bench
