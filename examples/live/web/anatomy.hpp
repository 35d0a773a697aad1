#ifndef INSONIFY_EXAMPLES_LIVE_WEB_ANATOMY_HPP
#define INSONIFY_EXAMPLES_LIVE_WEB_ANATOMY_HPP

#include <insonify/insonify.hpp>
#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>

namespace live {

using namespace insonify;

/// The name of a tissue; empty for another medium.
inline std::string tissue_name(const medium& inside) {
    for (const tissue::named_medium& one : tissue::all)
        if (one.value == inside) return one.name;
    return "";
}

/// Loads an OBJ file as the anatomy of a session: turned so that its skin is at the top (-z), and moved so that it begins at
/// the depth 0 and is centred below the probe.
/// @param side        the side of the skin: 0 +x, 1 -x, 2 +y, 3 -y, 4 +z, 5 -z
/// @param material    tissue of the faces, in a file without materials
/// @param background  tissue around the objects
/// @throws as load_obj_scene, and usage_error for an unknown tissue
inline scene load_anatomy(const std::string& path, float unit, int side, const std::string& material,
                          const std::string& background) {
    const auto known = [](const std::string& name) {
        const std::optional<medium> found = tissue::find(name);
        if (!found) throw usage_error{"there is no tissue '" + name + "'"};
        return *found;
    };
    const obj_settings settings{.unit = unit, .background = known(background)};
    std::ifstream file{path};
    const std::string text{std::istreambuf_iterator<char>{file}, {}};
    scene body{settings.background};
    if (text.find("usemtl") != std::string::npos)
        body = load_obj_scene(path, settings);
    else
        body.add(load_obj(path, settings), known(material), {.name = material});
    body.build(exec::par);

    constexpr vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int axis = std::clamp(side / 2, 0, 2);
    const vec3 down = side % 2 == 0 ? -axes[axis] : axes[axis];
    const pose turned = inverse(look_at({0, 0, 0}, down, axis == 0 ? axes[1] : axes[0]));
    const auto place = [&](const pose& to) {
        for (std::size_t i = 0; i < body.objects().size(); ++i) {
            const object& one = body.objects()[i];
            body.place(one.id, to * one.at);
        }
    };
    place(turned);
    const aabb box = body.box();
    place({mat3{1}, {-0.5F * (box.lower.x + box.upper.x), -0.5F * (box.lower.y + box.upper.y), -box.lower.z}});
    return body;
}

} // namespace live

#endif
