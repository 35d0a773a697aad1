#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "regions.hpp"
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <variant>

using namespace insonify;

// Draws the standard views of a region: `anatomy neck fat=0.006 side=1`, or of a random body: `anatomy neck seed=7`.
// Without arguments it lists the regions and their parameters.
int main(int count, char** arguments) try {
    if (count < 2) {
        for (const anatomy::region& region : anatomy::regions()) {
            std::printf("%s: %s\n", region.name, region.title);
            for (const anatomy::parameter& one : region.parameters)
                std::printf("    %-16s %g to %g %s (%g): %s\n", one.name, static_cast<double>(one.smallest),
                            static_cast<double>(one.largest), one.unit, static_cast<double>(one.usual),
                            one.description);
        }
        return 0;
    }
    const anatomy::region& region = anatomy::find_region(arguments[1]);
    anatomy::values values;
    for (int i = 2; i < count; ++i) {
        const std::string text = arguments[i], name = text.substr(0, text.find('='));
        std::size_t used = 0;
        const std::string number = text.substr(std::min(name.size() + 1, text.size()));
        try {
            if (name == "seed") {
                for (const auto& [drawn, value] : region.drawn(std::stoull(number, &used)))
                    values.emplace(drawn, value);
            } else {
                values[name] = std::stof(number, &used);
            }
        } catch (const std::logic_error&) {
            used = 0;
        }
        if (used == 0 || used != number.size())
            throw usage_error{"'" + text + "' is not a parameter and its value, such as fat=0.006 (metres) or seed=7"};
    }
    anatomy::body body = region.make(values);
    body.anatomy.build(exec::par);
    const object_id gel = *body.anatomy.find("gel");
    std::printf("%zu objects\n", body.anatomy.objects().size());
    for (const anatomy::view& view : body.views) {
        const std::string file = std::string{region.name} + "_" + view.name + ".png";
        std::visit(
            [&](const auto& probe) {
                pose at = view.at;
                at.translation += at.direction({0, 0, view.pressed});
                const contact touch = press(body.anatomy, probe, at, {}, [&](object_id id) { return id != gel; });
                body.anatomy.deform(exec::par, touch.deformation);
                write_png(file, b_mode(exec::par_unseq, body.anatomy, probe, at, view.settings));
                body.anatomy.deform(exec::par, pressed_face{});
            },
            view.probe);
        std::printf("%s: %s\n", file.c_str(), view.title.c_str());
    }
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "anatomy: %s\n", error.what());
    return 2;
}
