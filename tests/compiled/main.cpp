#include "pictures.hpp"
#include <cmath>
#include <cstdio>

using namespace insonify;

namespace {

float largest_difference(const image& a, const image& b) {
    if (a.size != b.size) return 1;
    float largest = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) largest = max(largest, std::fabs(a.pixels[i] - b.pixels[i]));
    return largest;
}

float power(const iq_lines& lines) {
    double sum = 0;
    for (const vec2& sample : lines.values) sum += static_cast<double>(dot(sample, sample));
    return static_cast<float>(sum);
}

int faults = 0;
void check(bool holds, const char* what) {
    std::printf("%s: %s\n", holds ? "ok" : "FAILED", what);
    faults += holds ? 0 : 1;
}

} // namespace

int main() {
    const scene body = make_body();
    const image picture = picture_of_linear_array(body), stages = stages_of_linear_array(body);
    float brightest = 0, mean = 0;
    for (const float pixel : stages.pixels) {
        brightest = max(brightest, pixel);
        mean += pixel / static_cast<float>(stages.pixels.size());
    }
    check(brightest == 1 && mean > 0.1F && mean < 0.9F, "stages give a picture");
    check(largest_difference(picture, picture_of_own_probe(body)) < 1e-4F,
          "a probe of another type, compiled without optimisation, draws the same picture");
    const float ratio = power(echoes_of_own_model(body)) / power(echoes_of_physical(body));
    check(ratio > 0.002F && ratio < 0.05F, "a model of another type has echoes of its own");
    try {
        b_mode(exec::par, body, linear_array{.lines = 0}, pose{});
        check(false, "errors reach the caller");
    } catch (const usage_error&) {
        check(true, "errors reach the caller");
    }
    return faults;
}
