#include <insonify/bvh/bvh.hpp>
#include "../support/cgal_peer.hpp"
#include "../support/meshes.hpp"
#include "../support/rays.hpp"
#include "rows.hpp"

namespace bench {
namespace {

void append(std::vector<double>& numbers, vec3 v) { numbers.insert(numbers.end(), {v.x, v.y, v.z}); }

void measure_cgal_rows(table& into) {
    if (!into.wants("closest of CGAL")) return;
    const mesh organ = organ_82k();
    const mesh_view surface{organ};
    const std::vector<ray> rays = fan_rays(8);
    std::vector<double> corners, same_rays;
    for (std::size_t i = 0; i < surface.size(); ++i)
        for (const vec3& corner : {surface[i].a, surface[i].b, surface[i].c}) append(corners, corner);
    for (const ray& r : rays) {
        append(same_rays, r.origin);
        append(same_rays, r.direction);
    }
    const bvh ours{exec::par, organ};
    const cgal_peer theirs{corners, same_rays};
    std::vector<hit> hits(rays.size());
    std::vector<std::uint32_t> met(rays.size());
    ours.closest(exec::unseq, rays, hits);
    theirs.closest(met);
    std::size_t different = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) different += hits[i].primitive != met[i];
    into.measure({.work = "closest of CGAL, fan",
                  .data = "organ 82k",
                  .unit = "M rays/s",
                  .different = static_cast<double>(different) / static_cast<double>(hits.size())},
                 {{"insonify", [&] { ours.closest(exec::unseq, rays, hits); }},
                  {"CGAL AABB_tree", [&] { theirs.closest(met); }}},
                 static_cast<double>(rays.size()));
}

const rows of_cgal{15, measure_cgal_rows};

} // namespace
} // namespace bench
