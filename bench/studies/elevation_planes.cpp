#include <insonify/core/random.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/presets.hpp>
#include <insonify/tracing/elevation.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

/// Searches for the pairs (delta, psi) of `detail::elevation_planes`: those of the smallest error in the echoes of half spaces
/// that begin at any height, at depths of 5 to 60 mm and up to twice the elevation focus, for a linear, a convex and a phased
/// array. Prints the error of the pairs of the library beside the smallest that it finds.
namespace {

using namespace insonify;
using pairs = std::vector<detail::elevation_pair>;

double above(double deviations) { return 0.5 * std::erfc(deviations / std::sqrt(2.0)); }

struct errors {
    double steps =
        0; ///< rms over depths and heights: level of a half space by the planes above its border less that of the beam
    double width = 0; ///< most that the rms height, weighted by power, differs from the beam's
};

template <class Probe>
void add_errors(const Probe& probe, const pairs& of, float from, float to, double& squares, double& count,
                double& width) {
    constexpr float depth = 125_mm;
    const auto planes_count = static_cast<std::uint32_t>(2 * of.size() + 1);
    const beam_model beam = beam_of(probe, depth);
    const detail::elevation_planes planes{beam, planes_count, of, depth, true};
    for (float z = from; z <= to; z += (to - from) / 22) {
        const auto weights = planes.at(z);
        const auto sigma = static_cast<double>(beam.elevation_sigma(z));
        double rms = 0;
        for (std::uint32_t i = 0; i < planes_count; ++i)
            rms += std::pow(static_cast<double>(weights.random[i] * planes[i].height(z)) / sigma, 2);
        width = std::max(width, std::fabs(std::sqrt(2 * rms) - 1));
        for (double y = 0.05; y < 2.5; y += 0.1) {
            double random = 0, coherent = 0;
            for (std::uint32_t i = 0; i < planes_count; ++i)
                if (static_cast<double>(planes[i].height(z)) > y * sigma) {
                    random += std::pow(static_cast<double>(weights.random[i]), 2);
                    coherent += static_cast<double>(weights.coherent[i]);
                }
            squares += std::pow(random - above(std::sqrt(2.0) * y), 2) + std::pow(coherent - above(y), 2);
            count += 2;
        }
    }
}

errors errors_of(const pairs& of) {
    double squares = 0, count = 0;
    errors all;
    add_errors(linear_array{}, of, 5_mm, 60_mm, squares, count, all.width);
    add_errors(presets::c5_2v, of, 5_mm, 120_mm, squares, count, all.width);
    add_errors(presets::p4_2v, of, 5_mm, 120_mm, squares, count, all.width);
    all.steps = std::sqrt(squares / count);
    return all;
}

/// Changes one number of the pairs at a time, by random steps that become smaller.
pairs search(pairs best, std::uint64_t seed) {
    double least = errors_of(best).steps;
    for (std::uint64_t i = 0; i < 1500; ++i) {
        pairs next = best;
        const float size = 0.3F * std::exp(-static_cast<float>(i) / 400);
        detail::elevation_pair& one = next[i % next.size()];
        const float step = size * (2 * hash_uniform(seed, i) - 1);
        if (i / next.size() % 2 == 0)
            one.delta += step;
        else
            one.psi += step;
        const double error = errors_of(next).steps;
        if (error < least) {
            least = error;
            best = next;
        }
    }
    return best;
}

void print(const char* whose, const pairs& of) {
    const errors e = errors_of(of);
    std::printf("  %-10s error of half spaces %.4f, of the rms height %.1f %%:", whose, e.steps, 100 * e.width);
    for (const detail::elevation_pair& one : of)
        std::printf(" (%.3f, %.1f deg)", static_cast<double>(one.delta), static_cast<double>(one.psi / 1_deg));
    std::printf("\n");
}

} // namespace

int main() {
    for (const std::uint32_t count : {3U, 5U, 7U}) {
        std::printf("%u planes\n", count);
        const auto own = detail::elevation_pairs(count);
        const pairs library(own.begin(), own.end());
        print("library", library);
        pairs best = search(library, 1);
        for (std::uint64_t seed = 2; seed < 8; ++seed) { // also from elsewhere
            pairs start;
            for (std::uint64_t i = 0; i < library.size(); ++i)
                start.push_back({0.5F + 1.5F * hash_uniform(seed, 100 + i), 120_deg * hash_uniform(seed, 200 + i)});
            const pairs found = search(start, seed);
            if (errors_of(found).steps < errors_of(best).steps) best = found;
        }
        print("found", best);
    }
}
