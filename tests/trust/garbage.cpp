#include <insonify/acoustics/tissue.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/read/label.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cstdint>
#include <doctest/doctest.h>
#include <span>
#include <utility>
#include <vector>

using namespace insonify;

// To be run under the address, undefined and float-divide-by-zero sanitizers, too.
namespace garbage_test {
namespace {

class chance {
  public:
    explicit chance(std::uint64_t seed) : seed_{seed} {}
    std::uint32_t bits() { return static_cast<std::uint32_t>(hash_bits(seed_, next_++) >> 32U); }
    std::uint32_t below(std::uint32_t n) { return bits() % n; }
    float number() { return __builtin_bit_cast(float, bits()); }
    vec3 point() {
        const float x = number(), y = number(), z = number();
        return {x, y, z};
    }

  private:
    std::uint64_t seed_, next_ = 0;
};

mesh random_mesh(chance& any) {
    mesh m;
    m.positions.resize(1 + any.below(200));
    for (vec3& p : m.positions) p = any.point();
    m.faces.resize(any.below(257));
    const auto count = static_cast<std::uint32_t>(m.positions.size());
    for (uvec3& f : m.faces) f = {any.below(count), any.below(count), any.below(count)};
    return m;
}

bool reaches(const hit& found, const ray& r, std::size_t faces) {
    return found.primitive < faces && is_finite(found.distance) && found.distance >= r.min_distance &&
           found.distance <= r.max_distance;
}

} // namespace

TEST_CASE("a thousand scenes of random bits are built, moved and traced") {
    std::uint64_t faces = 0, hits = 0;
    std::size_t bad_hits = 0, differing_answers = 0, bad_values = 0, bad_labels = 0, bad_frames = 0, refused = 0;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        chance any{seed};
        scene body{tissue::water};
        for (int i = 0; i < 20; ++i) {
            mesh m = random_mesh(any);
            faces += m.faces.size();
            const bvh tree{exec::unseq, m};
            std::vector<hit> all;
            for (int k = 0; k < 2; ++k) {
                const ray r{.origin = any.point(), .direction = any.point()};
                tree.all(r, all);
                hits += all.size();
                for (const hit& found : all) bad_hits += reaches(found, r, m.faces.size()) ? 0 : 1;
                differing_answers += tree.closest(r) == (all.empty() ? hit{} : all.front()) ? 0 : 1;
                differing_answers += tree.any(r) == !all.empty() ? 0 : 1;
            }
            if (i == 0) validate(m);
            // A scene takes finite vertices only, also in later frames.
            mesh at_rest = m;
            for (vec3& p : at_rest.positions) p = {hash_uniform(seed, any.bits()), 0, 0};
            const object_id id = body.add(at_rest, tissue::all[any.below(std::size(tissue::all))].value);
            body.build(exec::seq);
            std::copy(m.positions.begin(), m.positions.end(), body.positions(id).begin());
            const bool finite =
                std::all_of(m.positions.begin(), m.positions.end(), [](vec3 p) { return is_finite(p); });
            if (finite) continue;
            if (i % 2 == 0)
                CHECK_THROWS_AS(body.build(exec::seq), geometry_error);
            else
                CHECK_THROWS_AS(body.update(exec::seq), geometry_error);
            bad_frames += std::as_const(body)[id].surface.positions == at_rest.positions ? 0 : 1;
            ++refused;
            const std::span<vec3> now = body.positions(id);
            for (std::size_t k = 0; k < now.size(); ++k)
                if (is_finite(m.positions[k])) now[k] = m.positions[k];
        }
        body.build(exec::seq);
        for (const object& one : body.objects()) body.positions(one.id); // by a linear pass first
        body.update(exec::seq);
        const linear_array probe{.lines = 4, .frequency = min_frequency};
        const acquisition scan{.depth = 1 + 9 * hash_uniform(seed, 0), .samples = 16};
        const scan_lines slices =
            trace(exec::unseq, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::slices});
        for (const float value : slices.values) bad_values += is_finite(value) ? 0 : 1;
        const label_lines labels =
            label(exec::seq, body, probe, pose{}, {.depth = scan.depth, .samples = scan.samples});
        for (const label_id id : labels.values) bad_labels += id == background_label || id < 20 ? 0 : 1;
        body.update(exec::seq);
        const scan_lines rays =
            trace(exec::seq, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::rays});
        for (const float value : rays.values) bad_values += is_finite(value) ? 0 : 1;
    }
    CHECK(bad_hits == 0);
    CHECK(differing_answers == 0);
    CHECK(bad_values == 0);
    CHECK(bad_labels == 0);
    CHECK(bad_frames == 0);
    CHECK(refused > 5000);
    CHECK(faces > 2'000'000);
    CHECK(hits > 1000);
}

} // namespace garbage_test
