#include <insonify/acoustics/interface_law.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace interface_law_test {
namespace {

// The smallest law there is, and one of a user's own with a setting.
struct silent {
    INSONIFY_FN response operator()(const incidence&) const { return {}; }
};
struct hard_surface {
    float hardness = 0.9F;

    INSONIFY_FN response operator()(const incidence& at) const {
        return {.reflected = hardness * at.cosine * at.cosine, .transmitted = 1 - hardness};
    }
};
static_assert(interface_law<silent> && interface_law<hard_surface>);
static_assert(interface_law<response (*)(const incidence&)>);

// What is none: another answer, no answer, another question, one that changes as it is asked.
struct answers_a_number {
    float operator()(const incidence&) const { return 0; }
};
struct asks_for_media {
    response operator()(const medium&, const medium&) const { return {}; }
};
struct remembers {
    response operator()(const incidence&) { return {}; }
};
static_assert(!interface_law<int> && !interface_law<answers_a_number> && !interface_law<asks_for_media> &&
              !interface_law<remembers>);

template <interface_law Law>
response ask(const Law& law, const incidence& at) {
    return law(at);
}

} // namespace

TEST_CASE("interface law: a law that says nothing lets all sound through and sends none back") {
    const response answer = ask(silent{}, {});
    CHECK(answer.reflected == 0);
    CHECK(answer.transmitted == 1);
}

TEST_CASE("interface law: a user's own law sees the angle and its own setting") {
    const response answer = ask(hard_surface{.hardness = 0.8F}, {.cosine = 0.5F});
    CHECK(answer.reflected == doctest::Approx(0.2));
    CHECK(answer.transmitted == doctest::Approx(0.2));
}

TEST_CASE("interface law: incidence is normal unless it says otherwise") { CHECK(incidence{}.cosine == 1); }

} // namespace interface_law_test
