#ifndef INSONIFY_TESTS_TRUST_REFUSALS_HPP
#define INSONIFY_TESTS_TRUST_REFUSALS_HPP

#include <insonify/insonify.hpp>
#include <doctest/doctest.h>
#include <functional>
#include <limits>
#include <string>
#include <vector>

/// Checks the sentences of exceptions. Together the tests have every sentence that the library throws, but for those about
/// files, which tests/io checks.
namespace errors_test {

using namespace insonify;

struct refusal {
    std::function<void()> call{};
    std::string sentence{};
};

template <class Error>
void check(const std::vector<refusal>& refusals) {
    for (const refusal& one : refusals) {
        std::string said = "nothing";
        try {
            one.call();
        } catch (const Error& thrown) {
            said = thrown.what();
        } catch (const std::exception& other) {
            said = std::string{"another type: "} + other.what();
        }
        INFO("said: " << said);
        INFO("to be said: " << one.sentence);
        CHECK(said.find(one.sentence) != std::string::npos);
    }
}

inline const float nan = std::numeric_limits<float>::quiet_NaN();

inline const linear_array probe{.lines = 4};

inline const acquisition scan{.depth = 20_mm, .samples = 64};

inline scene body() {
    scene one{tissue::muscle};
    one.add(make_sphere({0, 0, 10_mm}, 4_mm, 1), tissue::bone, {.name = "bone"});
    one.build(exec::seq);
    return one;
}

} // namespace errors_test

#endif
