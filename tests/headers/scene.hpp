// Calls the public templates of scene/, each where its own header alone is included: see tests/CMakeLists.txt.
#include "pencil.hpp"
using namespace insonify;

#ifdef CALL_scene_queries
bool call(const scene& body) {
    return first_surface(body, ray{}, [](object_id) { return true; }).has_value();
}
#endif
#ifdef CALL_scene_scene
scene& call(scene& body, const mesh& surface) {
    const object_id id = body.add(surface, medium{}, {.name = "one"});
    body.build(exec::par);
    body.place(id, pose{});
    body.update(exec::par_unseq);
    body.deform(exec::par, [](vec3 rest) { return rest; });
    return body;
}
#endif
#ifdef CALL_scene_tetrahedra
vec3 call(const tetrahedra& map) { return map({0, 0, 0}); }
#endif
