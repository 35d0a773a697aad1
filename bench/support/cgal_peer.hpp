#ifndef INSONIFY_BENCH_SUPPORT_CGAL_PEER_HPP
#define INSONIFY_BENCH_SUPPORT_CGAL_PEER_HPP

#include <cstdint>
#include <memory>
#include <vector>

namespace bench {

/// CGAL's tree, in double as most of its users have it. CGAL brings compiler flags that slow others down, so it is compiled
/// by itself, without a header of ours, and takes plain numbers.
class cgal_peer {
  public:
    /// @param corners  nine numbers a triangle
    /// @param rays     six numbers a ray: origin, direction
    cgal_peer(const std::vector<double>& corners, const std::vector<double>& rays);
    ~cgal_peer();

    /// The triangle that each ray meets first, ~0U for none.
    void closest(std::vector<std::uint32_t>& met) const;

  private:
    struct parts;
    std::unique_ptr<parts> parts_;
};

} // namespace bench
#endif
