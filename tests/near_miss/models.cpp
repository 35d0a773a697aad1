#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>

using namespace insonify;

/// A model with all optional members; one of them is not what it should be: see CMakeLists.txt.
struct model {
    using sample_type = vec2;

    std::uint32_t samples(float, float) const { return 64; }
    template <class Policy>
    void operator()(const Policy&, const traced_line&, float, view<vec2>) const {}
#ifndef NEAR_MISS_emit
    template <class Echoes>
    void emit(const traced_line&, const Echoes&) const {}
#else
    template <class Echoes>
    void emits(const traced_line&, const Echoes&) const {}
#endif
#ifndef NEAR_MISS_covariance
    float covariance(float, float) const { return 1; }
#else
    float coveriance(float, float) const { return 1; }
#endif
#if defined(NEAR_MISS_arrivals)
    void arrival(const traced_line&, float, view<vec2>) const {}
#elif defined(NEAR_MISS_arguments)
    void arrivals(const traced_line&, view<vec2>, float) const {}
#else
    void arrivals(const traced_line&, float, view<vec2>) const {}
#endif
#ifndef NEAR_MISS_depth
    float max_depth(float depth, view<const medium>) const { return depth; }
#else
    float max_depth(float depth) const { return depth; }
#endif
};

int main() { return static_cast<int>(trace(exec::seq, scene{}, linear_array{}, pose{}, model{}, {}).count); }
