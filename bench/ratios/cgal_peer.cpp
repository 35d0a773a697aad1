#include "../support/cgal_peer.hpp"
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

namespace bench {

namespace {
using kernel = CGAL::Simple_cartesian<double>;
using primitive = CGAL::AABB_triangle_primitive<kernel, std::vector<kernel::Triangle_3>::const_iterator>;
} // namespace

struct cgal_peer::parts {
    std::vector<kernel::Triangle_3> triangles{};
    std::vector<kernel::Ray_3> rays{};
    CGAL::AABB_tree<CGAL::AABB_traits<kernel, primitive>> tree{};
};

cgal_peer::cgal_peer(const std::vector<double>& corners, const std::vector<double>& rays)
    : parts_{std::make_unique<parts>()} {
    const auto point = [](const double* p) { return kernel::Point_3{p[0], p[1], p[2]}; };
    for (std::size_t i = 0; i < corners.size(); i += 9)
        parts_->triangles.emplace_back(point(&corners[i]), point(&corners[i + 3]), point(&corners[i + 6]));
    for (std::size_t i = 0; i < rays.size(); i += 6)
        parts_->rays.emplace_back(point(&rays[i]), kernel::Vector_3{rays[i + 3], rays[i + 4], rays[i + 5]});
    parts_->tree.insert(parts_->triangles.cbegin(), parts_->triangles.cend());
    parts_->tree.build();
}
cgal_peer::~cgal_peer() = default;

void cgal_peer::closest(std::vector<std::uint32_t>& met) const {
    for (std::size_t i = 0; i < parts_->rays.size(); ++i) {
        const auto found = parts_->tree.first_intersected_primitive(parts_->rays[i]);
        met[i] = found ? static_cast<std::uint32_t>(*found - parts_->triangles.cbegin()) : ~0U;
    }
}

} // namespace bench
