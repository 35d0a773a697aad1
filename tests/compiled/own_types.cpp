#include "pictures.hpp"

using namespace insonify;

namespace {

struct own_probe : linear_array {};

struct tenth_of_physical {
    using sample_type = vec2;
    physical<> whole{};

    std::uint32_t samples(float depth, float frequency) const { return whole.samples(depth, frequency); }
    template <class Policy>
    void operator()(const Policy& policy, const traced_line& line, float spacing, view<vec2> out) const {
        whole(policy, line, spacing, out);
        for (vec2& sample : out) sample *= 0.1F;
    }
    static constexpr bool sharp_shadows = true;
};

} // namespace

image picture_of_own_probe(const scene& body) {
    return b_mode(exec::par_unseq, body, own_probe{}, pose{}, {.depth = 30_mm});
}

iq_lines echoes_of_own_model(const scene& body) {
    return trace(exec::par, body, linear_array{}, pose{}, tenth_of_physical{}, {.depth = 30_mm});
}
