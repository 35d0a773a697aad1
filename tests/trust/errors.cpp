#include "refusals.hpp"
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace errors_test {
namespace {

struct endless_range { // more primitives than a tree can hold
    std::size_t size() const { return std::size_t{1} << 31U; }
    triangle operator[](std::size_t) const { return {}; }
};

} // namespace

TEST_CASE("geometry that cannot be used is refused with a sentence") {
    mesh astray = make_box({0, 0, 0}, {1, 1, 1}), wild = astray;
    astray.faces[0].y = 99;
    wild.positions[2].x = nan;
    const mesh_view fewer{wild.positions, view<const uvec3>{wild.faces.data(), 3}};
    check<geometry_error>({
        {[&] {
             look_at({0, 0, 0}, {0, 0, 0}, {1, 0, 0});
         },
         "look_at: `from` and `towards` must be different points"},
        {[&] {
             look_at({1e7F, 0, 0}, {0, 0, 0}, {1, 0, 0});
         },
         "within 1000 km of the origin"},
        {[&] {
             look_at({0, 0, 0}, {0, 0, 1}, {0, 0, 2});
         },
         "look_at: `lateral` is parallel to the line of sight"},
        {[&] { scene{}.add(astray, tissue::fat, {.name = "a"}); },
         "object 'a': a face names vertex 99, but the mesh has 8"},
        {[&] { scene{}.add(wild, tissue::fat); }, "vertex 2 is not finite; repair the mesh (`validate` reports more)"},
        {[&] { scene{}.add({}, tissue::fat, {.at = {.rotation = mat3{2}}}); },
         "its pose is not a rigid transform; scale the mesh"},
        {[&] {
             body().place(object_id{0}, {.translation = {nan, 0, 0}});
         },
         "place: the pose is not a rigid transform"},
        {[&] { trace(exec::seq, body(), probe, {.rotation = mat3{0}}, law2011{}, scan); },
         "trace: the pose of the probe"},
        {[&] {
             (bvh{exec::seq, astray});
         },
         "bvh: a face names vertex 99"},
        {[&] {
             detail::bvh_storage<mesh_view> tree;
             tree.build(exec::seq, mesh_view{wild});
             tree.refit(exec::seq, fewer);
         },
         "bvh: refit needs as many primitives as the tree was built over; call rebuild"},
        {[&] { subdivide(astray); }, "subdivide: a face names vertex"},
        {[&] {
             make_box({0, 0, 0}, {1, 1, -1});
         },
         "along z must be above 0"},
        {[&] {
             make_sphere({nan, 0, 0}, 1, 1);
         },
         "coordinates must be finite and within 1000 km"},
        {[&] {
             make_sphere({0, 0, 0}, 1, 11);
         },
         "11 subdivisions are more than 10; each makes four times as many triangles"},
        {[&] {
             make_sphere({1e6F, 0, 0}, 1e-3F, 3);
         },
         "vertices round to the same point"},
        {[&] {
             make_cylinder({0, 0, 0}, {0, 0, 1}, 1, 2);
         },
         "make_cylinder: `segments` is 2; it must be from 3 to 1,000,000"},
        {[&] {
             make_cylinder({0, 0, 0}, {0, 0, 1}, 1, 8, 0);
         },
         "make_cylinder: `segments_along` is 0; it must be from 1 to 1,000,000"},
    });
}

TEST_CASE("settings of scenes and probes out of range are refused with a sentence") {
    scene unbuilt{tissue::fat};
    unbuilt.add(make_box({0, 0, 0}, {1, 1, 1}), tissue::bone);
    const auto sheathed = [](float thickness, float insertion) {
        medium muscle = tissue::muscle;
        muscle.structure.sheath.thickness = thickness;
        muscle.structure.sheath.insertion = insertion;
        return muscle;
    };
    check<usage_error>({
        {[&] { (scene{{.density = -1}}); }, "scene: the background needs a density and a sound speed above 0"},
        {[&] { unbuilt.add({}, {.sound_speed = 0}); }, "its medium needs a density and a sound speed above 0"},
        {[&] { (scene{sheathed(20, 0)}); },
         "scene: the background has a `structure.sheath.thickness` of 20 m; it must be 0 to 1 m, such as 20_mm"},
        {[&] { unbuilt.add({}, sheathed(1_mm, 20), {.name = "calf"}); },
         "object 'calf': its medium has a `structure.sheath.insertion` of 20 m; it must be 0 to 1 m, such as 20_mm"},
        {[&] { unbuilt.add({}, sheathed(1_mm, nan)); },
         "its medium has a `structure.sheath.insertion` of nan m; it must be 0 to 1 m, such as 20_mm"},
        {[&] { unbuilt.remove(object_id{7}); }, "scene: no object has the id 7"},
        {[&] { unbuilt.update(exec::seq); }, "scene: call build(policy) after the last add or remove"},
        {[&] { trace(exec::seq, unbuilt, probe, pose{}, law2011{}, scan); }, "scene: call build(policy)"},
        {[&] { linear_array{.lines = 0}.check(); }, "probe: lines is 0; it must be at least 1"},
        {[&] { linear_array{.width = 0}.check(); }, "probe: width is 0 m; it must be from 1 nm to 1 m"},
        {[&] { linear_array{.frequency = nan}.check(); },
         "probe: frequency is nan Hz; it must be from 1 kHz to 10 GHz"},
        {[&] { linear_array{.width = 38}.check(); }, "probe: width is 38 m: did you mean 38_mm?"},
        {[&] { linear_array{.frequency = 5}.check(); }, "probe: frequency is 5 Hz: did you mean 5_MHz?"},
        {[&] { linear_array{.fnumber = -1}.check(); }, "probe: fnumber is -1; it must be a number from 1e-9 to 1e12"},
        {[&] { linear_array{.focus = -1}.check(); }, "probe: focus is -1 m; it must be from 1 nm to 10 m"},
        {[&] { convex_array{.field_of_view = 60}.check(); },
         "convex_array: field_of_view is 60 rad: did you mean 60_deg?"},
        {[&] { phased_array{.field_of_view = 90}.check(); },
         "phased_array: field_of_view is 90 rad: did you mean 90_deg?"},
        {[&] { phased_array{.field_of_view = -1}.check(); },
         "phased_array: field_of_view is -1 rad; it must be from 1e-9 rad to 180_deg"},
        {[&] { beam_of(probe, 0); }, "beam_of: depth is 0 m; it must be from 1 nm to 10 m"},
        {[&] { beam_of(probe, 80); }, "beam_of: depth is 80 m: did you mean 80_mm?"},
        {[&] { for_each_index(exec::par.threads(1025), 3, [](std::size_t) {}); },
         "threads(1025): at most 1024 threads"},
    });
}

TEST_CASE("a tree says when it is asked for too much") {
    const mesh box = make_box({0, 0, 0}, {1, 1, 1});
    const bvh tree{exec::seq, box};
    const std::vector<ray> rays(3);
    std::vector<hit> hits(2);
    check<usage_error>({
        {[&] { tree.closest(exec::seq, rays, hits); }, "bvh: as many results as rays are needed"},
        {[&] {
             detail::bvh_storage<endless_range> storage;
             storage.build(exec::seq, endless_range{});
         },
         "bvh: more than 2147483647 primitives in one tree; split them"},
    });
}

} // namespace errors_test
