#include <insonify/core/random.hpp>
#include <benchmark/benchmark.h>

/// Random numbers made from seed and number.
namespace {

using namespace insonify;

template <class Number>
void numbers(benchmark::State& state, const Number& number) {
    std::uint64_t i = 0;
    for (auto _ : state) benchmark::DoNotOptimize(number(i++));
    state.SetItemsProcessed(state.iterations());
}
void uniform(benchmark::State& state) {
    numbers(state, [](std::uint64_t i) { return hash_uniform(1, i); });
}
void normal(benchmark::State& state) {
    numbers(state, [](std::uint64_t i) { return hash_normal(1, i); });
}

} // namespace

BENCHMARK(uniform);
BENCHMARK(normal);
