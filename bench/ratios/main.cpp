#define INSONIFY_IMPLEMENTATION
#include <insonify/io.hpp>
#include "../support/embree_api.hpp"
#include "rows.hpp"

/// Prints the table of ratios, ours against the best peer measured by turns with it, and writes it as JSON. Meshes of
/// the user's own are measured too, each brought to 100 mm.
///
///     bench_ratios [part of the name of a work [file.json [mesh.obj ...]]]
int main(int count, char** arguments) {
    bench::table all{count > 1 ? arguments[1] : "", {arguments + std::min(count, 3), arguments + count}};
    std::printf("%s; %s\n\n", bench::table::circumstances().c_str(), bench::embree_version().c_str());
    for (const auto& [place, measure] : bench::rows::all()) measure(all);
    if (count > 2) all.write_json(arguments[2]);
}
