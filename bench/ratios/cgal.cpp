#include <insonify/bvh/bvh.hpp>
#include "../support/meshes.hpp"
#include "../support/rays.hpp"
#include "rows.hpp"
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

/// CGAL's tree, in double as most of its users have it.
namespace bench {
namespace {

using kernel = CGAL::Simple_cartesian<double>;
using primitive = CGAL::AABB_triangle_primitive<kernel, std::vector<kernel::Triangle_3>::const_iterator>;
using cgal_tree = CGAL::AABB_tree<CGAL::AABB_traits<kernel, primitive>>;

kernel::Point_3 point(vec3 p) { return {p.x, p.y, p.z}; }

void measure_cgal_rows(table& into) {
    if (!into.wants("closest of CGAL")) return;
    const mesh organ = organ_82k();
    const mesh_view surface{organ};
    std::vector<kernel::Triangle_3> triangles;
    for (std::size_t i = 0; i < surface.size(); ++i) {
        const triangle one = surface[i];
        triangles.emplace_back(point(one.a), point(one.b), point(one.c));
    }
    cgal_tree theirs{triangles.begin(), triangles.end()};
    theirs.build();
    const bvh ours{exec::par, organ};
    const std::vector<ray> rays = fan_rays(8);
    std::vector<kernel::Ray_3> same;
    for (const ray& r : rays) {
        const vec3& d = r.direction;
        same.emplace_back(point(r.origin), kernel::Vector_3{d.x, d.y, d.z});
    }
    std::vector<hit> hits(rays.size());
    std::vector<std::uint32_t> met(rays.size());
    const auto ask_theirs = [&] {
        for (std::size_t i = 0; i < same.size(); ++i) {
            const auto found = theirs.first_intersected_primitive(same[i]);
            met[i] = found ? static_cast<std::uint32_t>(*found - triangles.cbegin()) : ~0U;
        }
    };
    ours.closest(exec::unseq, rays, hits);
    ask_theirs();
    std::size_t different = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) different += hits[i].primitive != met[i];
    into.measure({.work = "closest of CGAL, fan",
                  .data = "organ 82k",
                  .unit = "M rays/s",
                  .different = static_cast<double>(different) / static_cast<double>(hits.size())},
                 {{"insonify", [&] { ours.closest(exec::unseq, rays, hits); }}, {"CGAL AABB_tree", ask_theirs}},
                 static_cast<double>(rays.size()));
}

const rows of_cgal{15, measure_cgal_rows};

} // namespace
} // namespace bench
