#ifndef INSONIFY_DATASET_SUMMARY_HPP
#define INSONIFY_DATASET_SUMMARY_HPP

#include "parts.hpp"
#include <array>
#include <fstream>

namespace dataset {

/// One file that stands for all parts: a virtual dataset for each array.
inline void write_whole(const description& d, const anatomies& all, std::uint32_t line_samples) {
    const std::filesystem::path done = std::filesystem::path{d.output} / "dataset.h5", draft = done.string() + ".draft";
    {
        hdf5_file file{draft.string()};
        std::string names;
        for (const std::string& name : all.labels().names) names += (names.empty() ? "" : "\n") + name;
        file.set_text("label_names", names);
        file.set_text("description", "all parts as one: virtual datasets over part-*.h5");
        file.add_group("data", "images and signals, a row for each sample");
        file.add_group("insonify", "ground truth, and the numbers that vary");
        std::vector<hdf5_file::source> sources;
        for (std::uint32_t part = 0; part < part_count(d); ++part) {
            const auto [first, last] = samples_of_part(d, part);
            sources.push_back({part_name(d, part), last - first});
        }
        const hsize_t n = d.samples;
        const auto add = [&](const std::string& name, const char* unit, const char* text, hid_t type,
                             std::vector<hsize_t> shape) {
            shape.insert(shape.begin(), n);
            file.add_virtual(name, type, shape, sources, unit, text);
        };
        for (const row_kind& kind : row_kinds(d, line_samples))
            add(kind.name, kind.unit, kind.description, kind.bytes ? H5T_STD_U8LE : H5T_IEEE_F32LE, kind.shape);
        add("insonify/number", "-", "number of the sample in the dataset", H5T_STD_U32LE, {});
        add("insonify/pitch", "m", "width and height of a pixel", H5T_IEEE_F32LE, {2});
        add("insonify/pose", "m", "from the probe to the anatomy", H5T_IEEE_F32LE, {4, 4});
        for (const named_number& each : numbers())
            add(std::string{"insonify/"} + each.name, each.unit, each.description, H5T_IEEE_F32LE, {});
        file.flush();
    }
    std::filesystem::rename(draft, done);
}

/// A page with a contact sheet, what varied, and how often each label occurs in the samples shown.
inline void write_summary(const description& d, const anatomies& all) {
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

    std::ofstream page{folder / "summary.html"};
    page << "<!doctype html><meta charset=utf-8><title>" << d.samples
         << " samples</title>\n<style>body{font:14px sans-serif;"
            "max-width:1024px;margin:2em auto}td,th{padding:0 1em 0 0;text-align:left}svg{margin:0 8px 8px 0}</style>\n"
            "<h1>"
         << d.samples << " samples of " << d.size << " x " << d.size << " pixels</h1>\n<p>" << shown
         << " of them, at equal steps:</p>\n<img src=summary.png width=1024>\n<h2>What varies</h2>\n";
    for (const named_number& each : numbers()) {
        std::vector<float> values;
        for (std::uint32_t i = 0; i < d.samples; ++i) values.push_back(each.of(draw_sample(d, i)));
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        if (*least == *most) continue;
        constexpr std::size_t bars = 20;
        std::array<std::size_t, bars> counts{};
        for (const float value : values)
            ++counts[std::min(bars - 1, static_cast<std::size_t>((value - *least) / (*most - *least) * bars))];
        const auto highest = static_cast<float>(*std::max_element(counts.begin(), counts.end()));
        page << "<svg width=240 height=100><text x=0 y=12 font-size=12>" << each.name << ", " << each.unit << ": "
             << *least << " to " << *most << "</text>";
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
        page << "<tr><td>" << label << "<td>" << all.labels().names[label] << "<td>"
             << 100 * static_cast<double>(pixels[label]) / static_cast<double>(std::max<std::size_t>(inside, 1))
             << " %<td>" << pictures[label] << " of " << shown << "\n";
    page << "</table>\n";
    if (!page.flush()) throw io_error{"cannot write " + (folder / "summary.html").string() + "; is the disk full?"};
}

} // namespace dataset
#endif
