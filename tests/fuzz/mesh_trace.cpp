// Arbitrary bits as vertices, faces, media and poses: what cannot be used is refused, and the rest is traced. Trees over
// triangles answer as going through all of them does.
#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/read/ground_truth.hpp>
#include <insonify/tracing/trace.hpp>
#include "input.hpp"
#include <algorithm>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

using namespace insonify;

namespace {

mesh read_mesh(fuzz::input& in) {
    mesh m;
    m.positions.resize(in.below(25));
    for (vec3& p : m.positions) p = in.point();
    m.faces.resize(in.below(33));
    for (uvec3& f : m.faces) {
        f.x = in.byte();
        f.y = in.byte();
        f.z = in.byte();
        const auto count = static_cast<std::uint32_t>(m.positions.size());
        if (f.x < 250 && count > 0) f = {f.x % count, f.y % count, f.z % count}; // else out of range, mostly
    }
    return m;
}

bool in_range(const mesh& m) {
    return std::all_of(m.faces.begin(), m.faces.end(), [&](const uvec3& f) {
        return std::max({f.x, f.y, f.z}) < m.positions.size();
    });
}

/// What triangle.hpp says of every triangle by itself. `doubt` is by how much floats may be wrong about the distance.
struct expected_hit {
    hit found{};
    double doubt = 0;
};
std::vector<expected_hit> all_of(const mesh& m, ray r) {
    std::vector<expected_hit> hits;
    if (!fuzz::legal(r)) return hits;
    const sheared_ray sheared{r};
    for (std::uint32_t i = 0; i < m.faces.size(); ++i) {
        const triangle t = mesh_view{m}[i];
        if (!is_finite(bounds(t))) continue;
        hit found = intersect(sheared, t);
        if (!found) continue;
        found.primitive = i;
        const double a = sheared(t.a).z, b = sheared(t.b).z, c = sheared(t.c).z;
        const double reach = std::max({std::fabs(a), std::fabs(b), std::fabs(c)});
        const double underflow = 6e-45; // each step rounds what is next to nothing to a multiple of 1.4e-45
        hits.push_back({found, (4e-6 * reach + underflow) * std::fabs(sheared.shear.z)});
    }
    return hits;
}

void check_trees(const mesh& m, const std::vector<ray>& rays) {
    const bvh tree{exec::seq, m};
    std::vector<std::vector<hit>> batch(rays.size());
    std::vector<hit> all, closest(rays.size());
    tree.all(exec::unseq, rays, batch);
    tree.closest(exec::unseq, rays, closest);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const ray& r = rays[i];
        tree.all(r, all);
        for (const hit& found : all) {
            fuzz::require(found.primitive < m.faces.size(), "a hit names a face");
            fuzz::require(is_finite(found.distance) && found.distance >= r.min_distance &&
                              found.distance <= r.max_distance,
                          "a hit lies within the limits of its ray");
        }
        const std::vector<expected_hit> expected = all_of(m, r);
        std::size_t matched = 0;
        for (const expected_hit& one : expected) {
            const auto same = [&](const hit& found) { return found.primitive == one.found.primitive; };
            const auto found = std::find_if(all.begin(), all.end(), same);
            const double distance = one.found.distance;
            if (found != all.end()) {
                ++matched;
                fuzz::require(std::fabs(found->distance - distance) <= one.doubt, "a hit is where its triangle is");
            } else {
                fuzz::require(!(distance - one.doubt >= r.min_distance && distance + one.doubt <= r.max_distance),
                              "no triangle is missed");
            }
        }
        fuzz::require(matched == all.size(), "nothing is hit but what is there");
        fuzz::require(tree.closest(r) == (all.empty() ? hit{} : all.front()), "the closest hit is the first of all");
        fuzz::require(tree.any(r) == !all.empty(), "something is hit where anything is");
        fuzz::require(batch[i] == all && closest[i] == tree.closest(r), "a batch gives each ray what it gets alone");
    }
}

/// A tissue, or arbitrary numbers.
medium read_medium(fuzz::input& in) {
    const std::uint32_t kind = in.byte();
    if (kind != 'm') return tissue::all[kind % std::size(tissue::all)].value;
    return {.density = in.number(),
            .sound_speed = in.number(),
            .attenuation = in.number(),
            .attenuation_power = in.number(),
            .backscatter = in.number(),
            .roughness = in.number()};
}

pose read_pose(fuzz::input& in) {
    switch (in.below(3)) {
    case 0:
        return {};
    case 1:
        return {mat3{1}, in.point()};
    default: {
        const vec3 from = in.point(), towards = in.point();
        return look_at(from, towards, in.point());
    }
    }
}

/// `physical` at a few depths only: the table that it makes for each is kept.
constexpr float depths[] = {1e-5F, 1e-3F, 5e-3F, 2e-2F};

template <transducer Probe>
void check_echoes(const scene& body, const Probe& probe, const pose& at, const acquisition& scan) {
    static line_tracer<> own[std::size(depths)][2];
    static iq_lines echoes;
    const auto which = static_cast<std::size_t>(std::find(std::begin(depths), std::end(depths), scan.depth) - depths);
    echoes = own[which][scan.planes == 3 ? 1 : 0].trace(exec::unseq, body, probe, at, physical{}, scan, {},
                                                        std::move(echoes));
    for (const vec2& echo : echoes.values) fuzz::require(is_finite(echo.x) && is_finite(echo.y), "echoes are finite");
}

template <transducer Probe>
void check_frame(const scene& body, const Probe& probe, const pose& at, const acquisition& scan, std::uint32_t way) {
    const label_settings settings{.depth = scan.depth, .samples = scan.samples};
    if (way == 0) {
        const scan_lines rays = trace(exec::seq, body, probe, at, law2011{}, scan, straight_lines{line_search::rays});
        fuzz::require(fuzz::all_finite(rays.values), "intensities are finite");
    } else if (way == 1) {
        const scan_lines slices =
            trace(exec::unseq, body, probe, at, law2011{}, scan, straight_lines{line_search::slices});
        fuzz::require(fuzz::all_finite(slices.values), "intensities are finite");
    } else if (way == 2) {
        const ground_truth_lines truth = ground_truth(exec::seq, body, probe, at, settings);
        for (const label_id id : truth.label.values)
            fuzz::require(id == background_label || id < body.objects().size(), "a label names an object");
        for (const label_id medium : truth.medium.values)
            fuzz::require(medium < body.media().size(), "a sample lies in a medium of the scene");
        fuzz::require(fuzz::all_finite(truth.transmitted.values) && fuzz::all_finite(truth.incidence.values),
                      "what is true of a sample is finite");
    } else {
        check_echoes(body, probe, at, scan);
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    try {
        std::vector<ray> rays(1 + in.below(9));
        for (ray& r : rays) {
            r = {.origin = in.point(), .direction = in.point()};
            if (in.below(4) == 1) r.min_distance = in.number();
            if (in.below(4) == 1) r.max_distance = in.number();
        }
        scene body{read_medium(in)};
        pose at = read_pose(in);
        const std::uint32_t way = in.below(4);
        const float frequency = way == 3 ? 5e6F : 1e3F; // so that lines may be long
        const acquisition scan{
            .depth = way == 3 ? depths[in.below(4)] : in.number(), .samples = 1 + in.below(16), .planes = in.below(4)};
        const bool wedge = in.below(2) != 0;
        for (std::uint32_t left = 1 + in.below(3); left > 0; --left) {
            const mesh surface = read_mesh(in);
            if (left == 1) validate(surface);
            if (left == 1 && in_range(surface)) check_trees(surface, rays);
            try {
                body.add(surface, read_medium(in), {.priority = static_cast<int>(in.below(3)), .at = read_pose(in)});
                fuzz::require(in_range(surface), "faces out of range are refused");
            } catch (const geometry_error&) {
            } catch (const usage_error&) {
            }
        }
        body.build(exec::seq);
        const bool some_rest = in.below(2) != 0; // the others are handed out for moving
        for (const object& one : body.objects()) {
            if (some_rest && in.below(2) == 0) continue;
            const std::vector<vec3> before = one.surface.positions;
            const std::span<vec3> now = body.positions(one.id);
            for (vec3& p : now) p = in.empty() ? p : in.point();
            const bool finite = std::all_of(now.begin(), now.end(), [](vec3 p) { return is_finite(p); });
            try {
                body.update(exec::seq);
                fuzz::require(finite, "a frame that is not finite is refused");
            } catch (const geometry_error&) {
                fuzz::require(!finite && one.surface.positions == before,
                              "a frame that is refused leaves the last one");
            }
        }
        body.update(exec::seq);
        if (wedge)
            check_frame(body, convex_array{.lines = 7, .radius = 0.5F, .field_of_view = 1, .frequency = frequency}, at,
                        scan, way);
        else
            check_frame(body, linear_array{.lines = 8, .width = 1, .frequency = frequency}, at, scan, way);
    } catch (const geometry_error&) {
    } catch (const usage_error&) {
    }
    return 0;
}
