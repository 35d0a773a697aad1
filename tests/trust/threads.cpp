#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/trace.hpp>
#include <atomic>
#include <cstddef>
#include <doctest/doctest.h>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace insonify;

// To be run under the thread sanitizer, too.
namespace threads_test {
namespace {

const linear_array probe{.lines = 32};
const acquisition scan{.depth = 50_mm, .samples = 128};

scene body_of(float radius) {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 25_mm}, radius, 4), tissue::bone);
    return body;
}

/// The same work on four threads at once.
template <class Work>
void at_once(const Work& work) {
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) threads.emplace_back([&work, i] { work(i); });
    for (std::thread& one : threads) one.join();
}

} // namespace

TEST_CASE("const functions of one scene may be called from many threads") {
    scene body = body_of(10_mm);
    body.build(exec::par);
    const scene& fixed = body;
    const scan_lines expected = trace(exec::seq, fixed, probe, pose{}, law2011{}, scan);
    std::atomic<int> different{0};
    at_once([&](int thread) {
        for (int i = 0; i < 5; ++i) {
            const scan_lines seen = (i + thread) % 2 == 0
                                        ? trace(exec::par.threads(2), fixed, probe, pose{}, law2011{}, scan,
                                                straight_lines{line_search::rays})
                                        : trace(exec::par.threads(3), fixed, probe, pose{}, law2011{}, scan);
            if ((i + thread) % 2 != 0 && !(seen == expected)) ++different;
            if (fixed.box().empty() || fixed.find("none")) ++different;
        }
    });
    CHECK(different == 0);
}

TEST_CASE("different scenes may be built, moved and traced at the same time") {
    std::atomic<int> different{0};
    at_once([&](int thread) {
        const float radius = 5_mm + 2_mm * static_cast<float>(thread);
        scene body = body_of(radius), alone = body;
        body.build(exec::par.threads(3));
        alone.build(exec::seq);
        for (int i = 0; i < 3; ++i) {
            for (scene* one : {&body, &alone})
                for (vec3& p : one->positions(one->objects()[0].id)) p.x += 1_mm;
            body.update(exec::par.threads(2));
            alone.update(exec::seq);
            if (!(trace(exec::par.threads(2), body, probe, pose{}, law2011{}, scan) ==
                  trace(exec::seq, alone, probe, pose{}, law2011{}, scan)))
                ++different;
        }
    });
    CHECK(different == 0);
}

TEST_CASE("exceptions thrown inside bodies leave their own call alone, also among others") {
    std::atomic<int> wrong{0}, done{0};
    at_once([&](int thread) {
        for (int i = 0; i < 20; ++i) {
            const std::size_t bad = 10 + static_cast<std::size_t>(i);
            try {
                for_each_index(exec::par.threads(3), 100, [&](std::size_t k) {
                    if (thread % 2 == 0 && k >= bad) throw std::runtime_error{std::to_string(k)};
                    ++done;
                });
                if (thread % 2 == 0) ++wrong;
            } catch (const std::runtime_error& thrown) {
                if (thread % 2 != 0 || thrown.what() != std::to_string(bad)) ++wrong;
            }
        }
    });
    CHECK(wrong == 0);
    CHECK(done >= 2 * 20 * 100);
}

} // namespace threads_test
