#include <insonify/acoustics/laws.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace interface_law_test {
namespace {

// A minimal law, and a user's law with a setting.
struct transparent {
    INSONIFY_FN response operator()(const incidence&) const { return {}; }
};
struct hard_surface {
    float hardness = 0.9F;

    INSONIFY_FN response operator()(const incidence& at) const {
        return {.reflected = hardness * at.cosine * at.cosine, .transmitted = 1 - hardness};
    }
};
static_assert(interface_law<transparent> && interface_law<hard_surface>);
static_assert(interface_law<response (*)(const incidence&)>);

// Not laws: wrong result, wrong arguments, not const.
struct returns_number {
    float operator()(const incidence&) const { return 0; }
};
struct takes_media {
    response operator()(const medium&, const medium&) const { return {}; }
};
struct not_const {
    response operator()(const incidence&) { return {}; }
};
static_assert(!interface_law<int> && !interface_law<returns_number> && !interface_law<takes_media> &&
              !interface_law<not_const>);

template <interface_law Law>
response evaluate(const Law& law, const incidence& at) {
    return law(at);
}

} // namespace

TEST_CASE("interface_law: the default response is full transmission without an echo") {
    const response answer = evaluate(transparent{}, {});
    CHECK(answer.reflected == 0);
    CHECK(answer.transmitted == 1);
}

TEST_CASE("interface_law: a user's law receives the angle and has its own settings") {
    const response answer = evaluate(hard_surface{.hardness = 0.8F}, {.cosine = 0.5F});
    CHECK(answer.reflected == doctest::Approx(0.2).scale(1e-30));
    CHECK(answer.transmitted == doctest::Approx(0.2).scale(1e-30));
}

TEST_CASE("interface_law: incidence is normal by default") { CHECK(incidence{}.cosine == 1); }

} // namespace interface_law_test
