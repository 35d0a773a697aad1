#include <insonify/bvh/build_sah.hpp>
#include <insonify/core/random.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace sah_bins_test {

using namespace insonify::detail;

namespace {

// Boxes of all sizes, in clusters, so that planes differ much in cost.
std::vector<aabb> random_boxes(std::size_t count, std::uint64_t seed) {
    std::vector<aabb> boxes;
    const auto at = [&](std::uint64_t i) {
        return vec3{hash_uniform(seed, 3 * i), hash_uniform(seed, 3 * i + 1), hash_uniform(seed, 3 * i + 2)};
    };
    for (std::uint64_t i = 0; i < count; ++i) {
        const vec3 centre = at(3 * i) * at(1'000'000 + i % 5), size = 0.2F * at(3 * i + 1) * at(3 * i + 1);
        boxes.push_back({centre - size, centre + size});
    }
    return boxes;
}

double half_area(const aabb& b) {
    const double x = static_cast<double>(b.upper.x) - static_cast<double>(b.lower.x),
                 y = static_cast<double>(b.upper.y) - static_cast<double>(b.lower.y),
                 z = static_cast<double>(b.upper.z) - static_cast<double>(b.lower.z);
    return x * y + y * z + z * x;
}

// Surface times blocks of `width`, summed over the boxes on either side.
double cost_of(const std::vector<aabb>& boxes, const std::vector<std::uint32_t>& places, int axis, std::uint32_t bin,
               std::size_t width, std::size_t& below) {
    aabb side[2];
    std::size_t count[2] = {0, 0};
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const bool above = (places[i] >> 8 * axis & 0xFFU) >= bin;
        side[above] = merged(side[above], boxes[i]);
        ++count[above];
    }
    below = count[0];
    if (count[0] == 0 || count[1] == 0) return 1e300;
    double cost = 0;
    for (int i = 0; i < 2; ++i) cost += half_area(side[i]) * static_cast<double>((count[i] + width - 1) / width);
    return cost;
}

template <int Width>
void check_against_all_planes(std::size_t count, std::uint64_t seed) {
    const std::vector<aabb> boxes = random_boxes(count, seed);
    std::vector<build_box> own;
    centre_range centres;
    for (const aabb& b : boxes) {
        own.emplace_back(b);
        centres.add(own.back().half_centre(), own.back().half_centre());
    }
    const sah_grid grid{centres, count};
    sah_bins bins{grid}, second{grid};
    std::vector<std::uint32_t> places(count);
    const std::size_t half = count / 2; // in two parts, as two threads would
    bins.add(grid, own.data(), places.data(), half);
    second.add(grid, own.data() + half, places.data() + half, count - half);
    bins.add(second);

    std::size_t elsewhere = 0;
    for (std::size_t i = 0; i < count; ++i)
        for (int axis = 0; axis < 3; ++axis) { // the fraction of the way from the first centre to the last
            const double begin = centres.begin[axis], extent = static_cast<double>(centres.end[axis]) - begin;
            const double centre = (static_cast<double>(boxes[i].lower[axis]) + boxes[i].upper[axis]) / 4;
            const double place = extent > 0 ? (centre - begin) / extent * grid.bins : 0;
            const double bin = places[i] >> 8 * axis & 0xFFU;
            elsewhere += place < bin - 1e-3 || place > bin + 1 + 1e-3;
        }
    CHECK(elsewhere == 0);

    double smallest = 1e300;
    std::size_t below = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (std::uint32_t bin = 1; bin < static_cast<std::uint32_t>(grid.bins); ++bin)
            smallest = std::min(smallest, cost_of(boxes, places, axis, bin, Width, below));
    const sah_plane best = bins.cheapest<Width>();
    REQUIRE((best.axis >= 0) == (smallest < 1e300));
    if (best.axis < 0) return;
    const double cost = cost_of(boxes, places, best.axis, best.bin, Width, below);
    CHECK(cost == doctest::Approx(smallest).scale(1e-30).epsilon(1e-5));
    CHECK(best.below == below);
    CHECK(bins.count_below(best) == below);
    aabb side[2];
    for (std::size_t i = 0; i < count; ++i)
        side[best.is_above(places[i])] = merged(side[best.is_above(places[i])], boxes[i]);
    for (const bool above : {false, true}) {
        const build_box found = bins.box_of(best, above);
        CHECK(vec3{-found.row[0], -found.row[1], -found.row[2]} == side[above].lower);
        CHECK(vec3{found.row[4], found.row[5], found.row[6]} == side[above].upper);
    }
}

} // namespace

TEST_CASE("no other plane costs less than the chosen one, computed in double") {
    for (const std::size_t count : {2U, 3U, 9U, 40U, 63U, 64U, 300U, 2000U})
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            CAPTURE(count);
            CAPTURE(seed);
            sah_bins_test::check_against_all_planes<4>(count, seed);
            sah_bins_test::check_against_all_planes<8>(count, seed);
        }
}

TEST_CASE("boxes with the same centre are not split") {
    std::vector<build_box> own;
    centre_range centres;
    for (int i = 0; i < 20; ++i) {
        own.emplace_back(aabb{vec3{-1.0F - static_cast<float>(i)}, vec3{1.0F + static_cast<float>(i)}});
        centres.add(own.back().half_centre(), own.back().half_centre());
    }
    const sah_grid grid{centres, own.size()};
    sah_bins bins{grid};
    std::vector<std::uint32_t> places(own.size());
    bins.add(grid, own.data(), places.data(), own.size());
    CHECK(bins.cheapest<8>().axis == -1);
}

} // namespace sah_bins_test
