#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "../region_values.hpp"
#include "regions.hpp"
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

using namespace insonify;

// Draws the standard views of a region: `anatomy neck fat=6mm side=1`, or of a random body: `anatomy neck seed=7`.
// Without arguments it lists the regions and their parameters.
int main(int count, char** arguments) try {
    if (count < 2) {
        for (const anatomy::region& region : anatomy::regions()) {
            std::printf("%s: %s\n", region.name, region.title);
            for (const anatomy::parameter& one : region.parameters) {
                const anatomy::parameter_unit in = one.written_unit();
                const auto text = [&](float value) { return detail::number_text(value / in.size, 5); };
                std::printf("    %-16s %s to %s %s (%s): %s\n", one.name, text(one.smallest).c_str(),
                            text(one.largest).c_str(), in.name, text(one.usual).c_str(), one.description);
            }
        }
        return 0;
    }
    const anatomy::region& region = anatomy::find_region(arguments[1]);
    std::optional<std::uint64_t> seed;
    std::vector<std::string> words;
    for (const std::string text : std::span{arguments + 2, arguments + count}) {
        if (!text.starts_with("seed=")) {
            words.push_back(text);
            continue;
        }
        std::uint64_t number = 0;
        const char *const begin = text.c_str() + 5, *const end = text.c_str() + text.size();
        if (const auto read = std::from_chars(begin, end, number); read.ec != std::errc{} || read.ptr != end)
            throw usage_error{"'" + text + "' is not a seed, such as seed=7"};
        if (seed) throw usage_error{"`seed` is given twice"};
        seed = number;
    }
    anatomy::values values = anatomy::values_of(region, words);
    if (seed) values.merge(region.drawn(*seed));
    anatomy::body body = region.make(values);
    body.anatomy.build(exec::par);
    std::printf("%zu objects\n", body.anatomy.objects().size());
    for (const anatomy::view& view : body.views) {
        const std::string file = std::string{region.name} + "_" + view.name + ".png";
        const pose at = anatomy::press_probe(body.anatomy, view);
        std::visit(
            [&](const auto& probe) {
                write_png(file, b_mode(exec::par_unseq, body.anatomy, probe, at, view.settings));
            },
            view.probe);
        std::printf("%s: %s\n", file.c_str(), view.title.c_str());
    }
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "anatomy: %s\n", error.what());
    return 2;
}
