// One algorithm, any execution policy: seq, par, unseq and par_unseq as in the standard, the objects of std::execution,
// and your own.
#include <insonify/insonify.hpp>
#include <algorithm>
#include <cstdio>
#include <thread>

namespace mine {

/// Two threads: one for the odd indices, one for the even ones. A policy needs nothing but the function below.
struct odd_and_even {};

template <class Body>
void for_each_index(const odd_and_even&, std::size_t count, const Body& body) {
    std::thread odd{[&] {
        for (std::size_t i = 1; i < count; i += 2) body(i);
    }};
    for (std::size_t i = 0; i < count; i += 2) body(i);
    odd.join();
}

} // namespace mine

static_assert(insonify::exec::policy<mine::odd_and_even>);

int main() {
    using namespace insonify;
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 5), tissue::bone);
    body.build(exec::par);

    const auto lines = [&](const auto& policy) {
        return trace(policy, body, linear_array{}, pose{}, law2011{}, {.depth = 60_mm, .samples = 384}).values;
    };
    const std::vector<float> scalar = lines(exec::seq), simd = lines(exec::unseq);
    const bool threads_change_nothing = lines(exec::par) == scalar && lines(exec::par.threads(3)) == scalar &&
                                        lines(mine::odd_and_even{}) == scalar && lines(exec::par_unseq) == simd;

    float deviation = 0; // of SIMD from scalar: rounding only
    for (std::size_t i = 0; i < scalar.size(); ++i)
        deviation = std::max(deviation, std::fabs(scalar[i] - simd[i]) / scalar[i]);
    std::printf("threads change %s; SIMD differs by %.1e\n", threads_change_nothing ? "nothing" : "the result",
                deviation);
    return threads_change_nothing && deviation < 1e-5F ? 0 : 1;
}
