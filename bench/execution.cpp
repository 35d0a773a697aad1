#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <benchmark/benchmark.h>
#include <vector>

/// What a parallel call costs before it has done anything, and functions on many numbers.
namespace {

using namespace insonify;

void empty_body(benchmark::State& state) {
    const auto policy = exec::par.threads(static_cast<std::uint32_t>(state.range(0)));
    for (auto _ : state)
        for_each_index(policy, static_cast<std::size_t>(state.range(1)),
                       [](std::size_t i) { benchmark::DoNotOptimize(i); });
}
// Work of so many microseconds in 64 parts: from which size on do threads pay?
void small_work(benchmark::State& state) {
    const auto policy = exec::par.threads(static_cast<std::uint32_t>(state.range(0)));
    std::vector<float> values(static_cast<std::size_t>(state.range(1)) * 1000, 2.0F);
    for (auto _ : state)
        exec::for_each_block(policy, values.size(), values.size() / 64, 1e6F, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) values[i] = 1 / (values[i] + 1);
            benchmark::ClobberMemory();
        });
}
template <class Function>
void many(benchmark::State& state, const Function& function) {
    std::vector<float> values(4096, 1.5F);
    for (auto _ : state) {
        for (std::size_t i = 0; i < values.size(); i += simd_width)
            store(function(load<simd_width>(values.data() + i)), values.data() + i);
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * 4096);
}
void powers_of_two(benchmark::State& state) {
    many(state, [](const auto& x) { return power_of_two<simd_width>(x); });
}
void logarithms_of_two(benchmark::State& state) {
    many(state, [](const auto& x) { return logarithm_of_two<simd_width>(x); });
}

} // namespace

BENCHMARK(empty_body)->ArgsProduct({{1, 2}, {1, 2, 64, 4096}})->UseRealTime();
BENCHMARK(small_work)->ArgsProduct({{1, 2}, {1, 4, 16, 64, 256}})->UseRealTime();
BENCHMARK(powers_of_two);
BENCHMARK(logarithms_of_two);
