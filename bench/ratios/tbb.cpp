#include <insonify/execution/policy.hpp>
#include "rows.hpp"
#include <execution>
#include <numeric>

/// Our threads against the standard library's, which are TBB's: the same body for the same indices.
namespace bench {
namespace {

using namespace insonify;

void measure_thread_rows(table& into) {
    if (!into.wants("threads")) return;
    for (const std::size_t work :
         {0UL, 20UL, 200UL, 2000UL}) { // divisions an index: about 0, 5, 50, 500 microseconds in all
        std::vector<std::size_t> indices(64);
        std::iota(indices.begin(), indices.end(), 0);
        std::vector<float> results(indices.size());
        const auto body = [&](std::size_t i) {
            float x = static_cast<float>(i);
            for (std::size_t k = 0; k < work; ++k) x = 1 / (x + 1);
            results[i] = x;
        };
        into.measure({.work = "threads, 64 indices of " + std::to_string(work) + " divisions",
                      .data = std::to_string(std::thread::hardware_concurrency()) + " threads",
                      .unit = "ms"},
                     {{"insonify", [&] { for_each_index(exec::par, indices.size(), body); }},
                      {"std::execution::par of TBB",
                       [&] { std::for_each(std::execution::par, indices.begin(), indices.end(), body); }},
                      {"one thread", [&] { for_each_index(exec::seq, indices.size(), body); }}});
    }
}

const rows of_threads{60, measure_thread_rows};

} // namespace
} // namespace bench
