#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/paper/law2011.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace acoustic_model_test {
namespace {

struct minimal {
    using sample_type = float;
    std::uint32_t samples(float, float) const { return 1; }
    void operator()(const auto&, const traced_line&, float, view<float>) const {}
};
struct without_samples {
    using sample_type = float;
    void operator()(const auto&, const traced_line&, float, view<float>) const {}
};
struct without_type {
    std::uint32_t samples(float, float) const { return 1; }
    void operator()(const auto&, const traced_line&, float, view<float>) const {}
};
static_assert(acoustic_model<minimal> && acoustic_model<law2011>);
static_assert(!acoustic_model<without_samples> && !acoustic_model<without_type> && !acoustic_model<int>);

} // namespace
} // namespace acoustic_model_test

TEST_CASE("acoustic_model: optional members have defaults") {
    const acoustic_model_test::minimal own{};
    CHECK(detail::max_depth_of(own, 40_mm, {}) == 40_mm);
    CHECK_FALSE(detail::takes_normal_incidence<acoustic_model_test::minimal>);
    CHECK(detail::nanoseconds_of<acoustic_model_test::minimal>() == 5);

    CHECK(detail::max_depth_of(law2011{.reflection_length = 2_mm}, 40_mm, {}) == doctest::Approx(42_mm).scale(1e-30));
    CHECK(detail::takes_normal_incidence<law2011>);
    CHECK(detail::nanoseconds_of<law2011>() == 0.5F);
}
