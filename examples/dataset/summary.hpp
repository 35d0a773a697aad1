#ifndef INSONIFY_DATASET_SUMMARY_HPP
#define INSONIFY_DATASET_SUMMARY_HPP

#include "parts.hpp"
#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>
#include <vector>

namespace dataset {

/// A page with a contact sheet, what varied, and how often each label occurs in the samples shown.
inline void write_summary(const description& d, const anatomies& all, const layout& arrays) {
    constexpr std::uint32_t columns = 8, thumb = 128;
    const std::uint32_t shown = std::min(d.samples, 48U), rows = (shown + columns - 1) / columns;
    std::vector<record> records(shown);
    for_each_index(exec::par, shown, [&](std::size_t i) {
        records[i] = render(d, all, draw_sample(d, static_cast<std::uint32_t>(i * d.samples / shown)));
    });
    image sheet{uvec2{columns * thumb, rows * thumb}};
    std::array<std::size_t, 256> pixels{}, pictures{};
    for (std::uint32_t i = 0; i < shown; ++i) {
        for (std::uint32_t y = 0; y < thumb; ++y)
            for (std::uint32_t x = 0; x < thumb; ++x)
                sheet(i % columns * thumb + x, i / columns * thumb + y) =
                    static_cast<float>(records[i].image[(y * d.size / thumb) * d.size + x * d.size / thumb]) / 255;
        std::array<bool, 256> seen{};
        for (const std::uint8_t label : records[i].label) {
            ++pixels[label];
            seen[label] = true;
        }
        for (std::size_t label = 0; label < 256; ++label) pictures[label] += seen[label] ? 1 : 0;
    }
    const std::filesystem::path folder{d.output};
    write_png((folder / "summary.png").string(), sheet);

    std::ostringstream page;
    page << "<!doctype html><meta charset=utf-8><title>" << d.samples
         << " samples</title>\n<style>body{font:14px sans-serif;"
            "max-width:1024px;margin:2em auto}td,th{padding:0 1em 0 0;text-align:left}svg{margin:0 8px 8px 0}</style>\n"
            "<h1>"
         << d.samples << " samples of " << d.size << " x " << d.size << " pixels</h1>\n<p>" << shown
         << " of them, at equal steps:</p>\n<img src=summary.png width=1024>\n<h2>What varies</h2>\n";
    const std::uint32_t counted = std::min(d.samples, 100'000U);
    std::vector<record> drawn(counted);
    for (std::uint32_t i = 0; i < counted; ++i) drawn[i].numbers = draw_sample(d, i);
    for (std::size_t number = 0; number < arrays.option_count(); ++number) {
        const fact& each = arrays.facts()[number];
        std::vector<float> values;
        for (const record& one : drawn) each.append(one, values);
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        if (*least == *most) continue;
        constexpr std::size_t bars = 20;
        std::array<std::size_t, bars> counts{};
        for (const float value : values)
            ++counts[std::min(bars - 1, static_cast<std::size_t>((value - *least) / (*most - *least) * bars))];
        const auto highest = static_cast<float>(*std::max_element(counts.begin(), counts.end()));
        page << "<svg width=240 height=100><text x=0 y=12 font-size=12>" << each.short_name() << ", " << each.name.unit
             << ": " << *least << " to " << *most << "</text>";
        for (std::size_t i = 0; i < bars; ++i) {
            const float height = 75 * static_cast<float>(counts[i]) / highest;
            page << "<rect x=" << 11 * i << " y=" << 95 - height << " width=10 height=" << height << " fill=#467 />";
        }
        page << "</svg>\n";
    }
    page << "<h2>Labels</h2>\n<table><tr><th>label<th>name<th>share of the pixels<th>images with it\n";
    std::size_t inside = 0;
    for (std::size_t label = 0; label < label_names::outside; ++label) inside += pixels[label];
    for (std::size_t label = 0; label < all.labels().names.size(); ++label)
        page << "<tr><td>" << label << "<td>" << html(all.labels().names[label]) << "<td>"
             << 100 * static_cast<double>(pixels[label]) / static_cast<double>(std::max<std::size_t>(inside, 1))
             << " %<td>" << pictures[label] << " of " << shown << "\n";
    page << "</table>\n";
    replace_file(folder / "summary.html", page.str());
}

} // namespace dataset
#endif
