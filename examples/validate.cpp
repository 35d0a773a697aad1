// Mesh validation: `validate` counts the faults, `explain` says what to do. Tracing needs closed surfaces: the medium
// of an object leaks out through a hole.
#include <insonify/insonify.hpp>
#include "nerve_block_phantom.hpp"
#include <cstdio>
#include <limits>
#include <utility>

int main() {
    using namespace insonify;
    const mesh clean = make_sphere({0, 0, 0}, 10_mm, 3);

    mesh holed = clean;
    holed.faces.pop_back();

    mesh inside_out = clean;
    for (uvec3& face : inside_out.faces) std::swap(face.y, face.z);

    mesh dirty = clean;
    dirty.faces.push_back(dirty.faces.front());                               // a duplicate face
    dirty.faces.push_back({0, 0, 1});                                         // a degenerate face
    dirty.faces.push_back({0, 1, 1000000});                                   // a face with an index out of range
    std::swap(dirty.faces[10].x, dirty.faces[10].y);                          // a face that is oriented inwards
    dirty.positions.push_back(vec3{std::numeric_limits<float>::quiet_NaN()}); // a vertex that is not finite

    const std::pair<const char*, mesh_report> reports[] = {{"clean", validate(clean)},
                                                           {"holed", validate(holed)},
                                                           {"inside out", validate(inside_out)},
                                                           {"dirty", validate(dirty)}};
    for (const auto& [name, report] : reports) {
        const std::string advice = explain(report);
        std::printf("%s: %s, %.1f cm3. %s\n", name, report.closed() ? "closed" : "not closed", report.volume * 1e6,
                    advice.empty() ? "Nothing to do." : advice.c_str());
    }

    const scene phantom = nerve_block_phantom(); // its meshes have no faults
    const bool sound = std::all_of(phantom.objects().begin(), phantom.objects().end(),
                                   [](const object& one) { return explain(validate(one.surface)).empty(); });
    std::printf("The phantom of the other examples has %s.\n", sound ? "no faults" : "faults");

    const mesh_report &good = reports[0].second, &open = reports[1].second, &turned = reports[2].second,
                      &bad = reports[3].second;
    return sound && good.closed() && explain(good).empty() && open.boundary_edges == 3 && !open.closed() &&
                   turned.inside_out_components == 1 && bad.duplicate_faces == 1 && bad.degenerate_faces == 1 &&
                   bad.faces_out_of_range == 1 && bad.non_finite_vertices == 1 && bad.misoriented_edges > 0
               ? 0
               : 1;
}
